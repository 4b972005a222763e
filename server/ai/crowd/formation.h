// Places in a formation: the pull towards one, and where it lies before walls.
#pragma once

#include "server/ai/crowd/walls.h"
#include "shared/math/types.h"

namespace zoned::ai::steering {

/// The place of a member relative to the centre, m.
struct FormationSlot {
    float ahead = 0.0F;
    float right = 0.0F;
};

struct FormationSettings {
    float pull_per_s = 1.5F;    ///< speed towards its own place per metre, within near_m
    float near_m = 3.0F;        ///< farther off the pull fades as 1 / distance
    float straggler_m = 8.0F;   ///< a member farther from its place walks by itself
    float taken_back_m = 3.0F;  ///< a straggler is taken back this near to a place that it sees
};

/// The desired velocity of a member in its place, m/s. It is the centre's `velocity` plus a pull to
/// its slot, which lies at `offset`. The pull is pull_per_s times a small offset, and fades as 1 /
/// distance for a large one.
Vec2 pull_to_slot(const FormationSettings& settings, const Vec2& velocity, const Vec2& offset);

/// The slot at `offset` from the centre, moved towards the centre where a wall lies between them.
Vec2 slot_before_walls(const Vec2& centre, const Vec2& offset, float radius, const Walls& walls);

/// The share of the path from a to b, 0 to 1, after which it meets a wall; 1 where it meets none.
float free_share(const Vec2& a, const Vec2& b, const Walls& walls);

}  // namespace zoned::ai::steering
