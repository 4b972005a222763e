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

/// Place of a member beside the centre, m.
struct FormationSlot {
    float ahead = 0.0F;
    float right = 0.0F;
};

struct FormationSettings {
    float pull_per_s = 1.5F;       ///< speed towards the own place per distance, within near_m
    float near_m = 3.0F;           ///< farther off the pull fades as 1 / distance
    float straggler_m = 8.0F;      ///< who is farther from its place walks by itself
    float taken_back_m = 3.0F;     ///< until it is as near as this and sees its place
    float repel_m = 0.5F;          ///< from the body to a wall, in which walls push
    float repel_speed = 0.8F;      ///< m/s, at a wall
    std::uint32_t ask_every = 20;  ///< steps after which a straggler asks for its path anew
};

/// What a member in its place wants, m/s: to go with the centre at `velocity`, and to its slot,
/// which is at `offset` from it: pull_per_s times the offset where that is small, fading as 1 /
/// distance.
Vec2 pull_to_slot(const FormationSettings& settings, const Vec2& velocity, const Vec2& offset);

/// Off walls, m/s: fully at the body of `radius`, not at all at repel_m from it.
Vec2 push_off_walls(const FormationSettings& settings,
                    const Vec2& at,
                    float radius,
                    const Walls& walls);

/// The slot at `offset` from the centre, moved towards that where a wall is between them.
Vec2 slot_before_walls(const Vec2& centre, const Vec2& offset, float radius, const Walls& walls);

/// Slots around a moving centre. A member is drawn to its slot, by a force that grows with the
/// distance at first and then fades, so that nobody is dragged along walls by a group that is far.
/// Who is far, or has a wall between itself and its slot, is a straggler: it asks for a path, walks
/// it, and is taken back. A slot behind a wall, seen from the centre, moves towards the centre
/// until it is before the wall, and walls push whoever is near: so nobody is drawn into a trap.
class Formation {
  public:
    /// Where to walk next, from a place to another: the next corner of a path, or `to` itself.
    using Route = std::function<Vec2(std::size_t row, const Vec2& from, const Vec2& to)>;

    Formation(std::vector<FormationSlot> slots, const FormationSettings& settings);

    /// Where the centre is (m), how it moves (m/s), and where the formation looks (unit length).
    void place(const Vec2& centre, const Vec2& velocity, const Vec2& heading);

    /// Gives slots to rows of `agents`, so that the sum of squared distances is least (Assignment
    /// says how many this holds for). Members without a slot walk with the centre.
    void enlist(const CrowdAgents& agents, std::span<const std::size_t> members);

    /// Writes what its members want.
    void aim(CrowdAgents& agents, const Walls& walls, const Route& route);

    [[nodiscard]] std::span<const std::size_t> members() const { return rows_; }

    /// Where the slot of the i-th member is, moved before walls.
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
    std::vector<std::uint32_t> asked_;  // steps until it asks again
    std::vector<double> cost_;
    Assignment assignment_;
};

/// The share of the path from a to b, 0 to 1, after which it meets a wall; 1 where it meets none.
float free_share(const Vec2& a, const Vec2& b, const Walls& walls);

}  // namespace zoned::ai::steering
