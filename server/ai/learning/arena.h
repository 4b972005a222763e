// Arena: a learning task: reach a moving goal inside a round wall that costs points.
// The learned policy runs in the server unchanged.
#pragma once

#include "server/ai/learning/policy.h"
#include "server/ai/learning/task.h"

namespace zoned::ai::learning {

/// The walker's home is the middle. The goal walks from one random point to the next at
/// `goal_speed`; some points lie beyond the wall. Once reached, the goal moves elsewhere.
struct Arena {
    float wall_m = 20.0F;        ///< radius
    float goal_reach_m = 26.0F;  ///< radius of the disc in which the goal walks
    float speed = 5.0F;          ///< of the walker, m/s
    float goal_speed = 3.0F;     ///< m/s
    float acceleration = 20.0F;  ///< m/s2
    float touch_m = 1.5F;        ///< the goal counts as reached within this distance
    float seconds = 60.0F;       ///< length of an episode
};

/// ArenaResult: a walker's result in an episode.
struct ArenaResult {
    int reached = 0;
    float wall_s = 0.0F;      ///< time spent at the wall
    float mean_off_m = 0.0F;  ///< mean distance to the goal

    /// Each second at the wall costs two goals.
    [[nodiscard]] double points() const {
        return static_cast<double>(reached) - 2.0 * static_cast<double>(wall_s);
    }
};

/// The policy of a network for the arena. Its inputs: target distance, path home along and across,
/// home distance, the goal's speed across.
Policy arena_policy(const Arena& arena, NeuralNetwork network);

/// `policy` null: the walker goes straight at the goal.
ArenaResult play(const Arena& arena, const Policy* policy, core::Rng rng);

class ArenaTask final : public Task {
  public:
    explicit ArenaTask(const Arena& arena = {}) : arena_(arena) {}

    [[nodiscard]] std::size_t inputs() const override { return 5; }

    [[nodiscard]] std::size_t outputs() const override { return 2; }

    /// Points of four episodes; without any points, nearness to the goal. Above 0.
    [[nodiscard]] double fitness(const NeuralNetwork& network, std::uint64_t course) const override;

    /// Mean points of fifty episodes that no fitness() uses.
    [[nodiscard]] double score(const NeuralNetwork& network, std::uint64_t course) const override;

    /// The score of a walker that goes straight at the goal.
    [[nodiscard]] double solved_at() const override;

    [[nodiscard]] const Arena& arena() const { return arena_; }

  private:
    Arena arena_;
};

/// Mean points of a walker that goes straight at the goal, on the episodes of score(course).
double straight_score(const Arena& arena, std::uint64_t course);

}  // namespace zoned::ai::learning
