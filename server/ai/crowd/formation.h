// Formation: a group that keeps its order while it moves.
#pragma once

#include "server/ai/crowd/assignment.h"
#include "server/ai/crowd/crowd_agents.h"
#include "server/ai/crowd/walls.h"
#include "shared/math/types.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace zoned::ai::steering {

/// The place of a member relative to the centre, m.
struct FormationSlot {
    float ahead = 0.0F;
    float right = 0.0F;
};

struct FormationSettings {
    float pull_per_s = 1.5F;       ///< speed towards its own place per metre of distance, within
                                   ///< near_m
    float near_m = 3.0F;           ///< farther off the pull fades as 1 / distance
    float straggler_m = 8.0F;      ///< a member farther from its place walks by itself
    float taken_back_m = 3.0F;     ///< a straggler is taken back this near to its place if it sees
                                   ///< it
    float repel_m = 0.5F;          ///< distance from body to wall within which walls push
    float repel_speed = 0.8F;      ///< m/s, at a wall
    std::uint32_t ask_every = 20;  ///< steps after which a straggler requests a new path
};

/// The desired velocity of a member in its place, m/s. It is the centre's `velocity` plus a pull to
/// its slot, which lies at `offset`. The pull is pull_per_s times a small offset, and fades as 1 /
/// distance for a large one.
Vec2 pull_to_slot(const FormationSettings& settings, const Vec2& velocity, const Vec2& offset);

/// The push off walls, m/s: full at the body of `radius`, zero at repel_m from it.
Vec2 push_off_walls(const FormationSettings& settings,
                    const Vec2& at,
                    float radius,
                    const Walls& walls);

/// The slot at `offset` from the centre, moved towards the centre where a wall lies between them.
Vec2 slot_before_walls(const Vec2& centre, const Vec2& offset, float radius, const Walls& walls);

/// Slots around a moving centre. Each member is drawn to its slot. The force first grows with
/// distance and then fades, so a group that is far does not drag anybody along walls.
/// A member that is far, or has a wall between itself and its slot, is a straggler. It requests a
/// path, walks it, and is taken back.
/// A slot behind a wall, seen from the centre, moves towards the centre until it is before the
/// wall. Walls push members that are near. So no member is drawn into a trap.
class Formation {
  public:
    /// The next point to walk to from a place to another: the next corner of a path, or `to`
    /// itself.
    using Route = std::function<Vec2(std::size_t row, const Vec2& from, const Vec2& to)>;

    Formation(std::vector<FormationSlot> slots, const FormationSettings& settings);

    /// Sets the centre's position (m) and velocity (m/s) and the formation's heading (unit length).
    void place(const Vec2& centre, const Vec2& velocity, const Vec2& heading);

    /// Gives slots to rows of `agents`, so that the sum of squared distances is least (Assignment
    /// states the limit on numbers). Members without a slot walk with the centre.
    void enlist(const CrowdAgents& agents, std::span<const std::size_t> members);

    /// Writes the desired velocities of its members.
    void aim(CrowdAgents& agents, const Walls& walls, const Route& route);

    [[nodiscard]] std::span<const std::size_t> members() const { return rows_; }

    /// The slot position of the i-th member, moved before walls.
    [[nodiscard]] Vec2 slot_of(std::size_t i, const Walls& walls, float radius) const;

    [[nodiscard]] bool straggles(std::size_t i) const { return straggles_[i] != 0; }

  private:
    void follow_path(std::size_t i, CrowdAgents& agents, const Vec2& slot, const Route& route);

    std::vector<FormationSlot> slots_;
    FormationSettings settings_;
    Vec2 centre_ = Vec2::Zero();
    Vec2 velocity_ = Vec2::Zero();
    Vec2 heading_ = Vec2(1.0F, 0.0F);
    std::vector<std::size_t> rows_;
    std::vector<std::uint32_t> slot_;  // by member
    std::vector<std::uint8_t> straggles_;
    std::vector<Vec2> corner_;
    std::vector<std::uint32_t> asked_;  // steps until it requests a path again
    std::vector<double> cost_;
    Assignment assignment_;
};

/// The share of the path from a to b, 0 to 1, after which it meets a wall; 1 where it meets none.
float free_share(const Vec2& a, const Vec2& b, const Walls& walls);

}  // namespace zoned::ai::steering
