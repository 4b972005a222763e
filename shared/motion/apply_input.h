// apply_input: one tick of character movement, the same function on the server and in the client's
// prediction.
#pragma once

#include "shared/math/types.h"
#include "shared/motion/input_command.h"
#include "shared/motion/static_geometry.h"

namespace zoned::motion {

/// Body and abilities of a character type.
struct CharacterLimits {
    float radius = 0.4F;            ///< capsule radius, m
    float half_segment = 0.5F;      ///< half length of the capsule's segment along y, m
    float speed = 5.0F;             ///< full walking speed, m/s
    float sprint_factor = 1.6F;     ///< speed with kButtonSprint / speed
    float acceleration = 20.0F;     ///< on the ground, m/s2
    float air_acceleration = 4.0F;  ///< in the air, m/s2
    float jump_speed = 5.0F;        ///< m/s
    float max_slope_cos = 0.64F;    ///< steeper ground (normal.y below this) does not carry
    float step_down = 0.35F;   ///< how far a walking character follows ground that falls away, m
    float gravity = kGravity;  ///< m/s2
};

/// All that movement depends on; `position` is the capsule's centre.
struct CharacterState {
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    std::uint16_t yaw = 0;
    bool grounded = false;
};

/// Moves a capsule for `dt` seconds (dt > 0): accelerates towards the wanted velocity, applies
/// gravity, slides along `world`, follows slopes down and stands still on what carries. Never
/// tunnels: a move longer than the radius is split. Deterministic: same arguments, same bits.
CharacterState apply_input(const CharacterState& from,
                           const InputCommand& command,
                           const CharacterLimits& limits,
                           const StaticGeometry& world,
                           float dt);

/// Orientation of a character that faces `yaw` (65536 = one turn about +y).
Quat orientation_from_yaw(std::uint16_t yaw);

}  // namespace zoned::motion
