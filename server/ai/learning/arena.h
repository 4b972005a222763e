// Arena: reach a goal that moves, within a round wall that hurts: a task from a simulated world
// whose policy runs in the server as it is.
#pragma once

#include "server/ai/learning/policy.h"
#include "server/ai/learning/task.h"

namespace zoned::ai::learning {

/// The walker's home is the middle. The goal walks to one random point after the other, some of
/// them beyond the wall, at `goal_speed`; once reached it is somewhere else.
struct Arena {
    float wall_m = 20.0F;        ///< radius
    float goal_reach_m = 26.0F;  ///< radius of the disc in which the goal walks
    float speed = 5.0F;          ///< of the walker, m/s
    float goal_speed = 3.0F;     ///< m/s
    float acceleration = 20.0F;  ///< m/s2
    float touch_m = 1.5F;        ///< so near is reached
    float seconds = 60.0F;       ///< of an episode
};

/// What a walker made of an episode.
struct ArenaResult {
    int reached = 0;
    float wall_s = 0.0F;      ///< time at the wall
    float mean_off_m = 0.0F;  ///< distance to the goal

    /// Each second at the wall takes back two goals.
    [[nodiscard]] double points() const {
        return static_cast<double>(reached) - 2.0 * static_cast<double>(wall_s);
    }
};

/// The policy of a network for the arena: target distance, the way home along and across, home
/// distance, the goal's speed across.
Policy arena_policy(const Arena& arena, NeuralNetwork network);

/// `policy` null: walks straight at the goal.
ArenaResult play(const Arena& arena, const Policy* policy, core::Rng rng);

class ArenaTask final : public Task {
  public:
    explicit ArenaTask(const Arena& arena = {}) : arena_(arena) {}

    [[nodiscard]] std::size_t inputs() const override { return 5; }

    [[nodiscard]] std::size_t outputs() const override { return 2; }

    /// Points of four episodes and, as long as there are none, nearness: above 0.
    [[nodiscard]] double fitness(const NeuralNetwork& network, std::uint64_t course) const override;

    /// Mean points of fifty episodes that no fitness() uses.
    [[nodiscard]] double score(const NeuralNetwork& network, std::uint64_t course) const override;

    /// What walking straight at the goal brings.
    [[nodiscard]] double solved_at() const override;

    [[nodiscard]] const Arena& arena() const { return arena_; }

  private:
    Arena arena_;
};

/// Mean points of who walks straight at the goal, on the episodes of score(course).
double straight_score(const Arena& arena, std::uint64_t course);

}  // namespace zoned::ai::learning
