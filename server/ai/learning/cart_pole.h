// CartPole: a pole on a cart that a policy keeps upright by pushes from either side: the task by
// which methods of learning are compared.
#pragma once

#include "server/ai/learning/task.h"

namespace zoned::ai::learning {

/// Barto, Sutton, Anderson, "Neuronlike adaptive elements that can solve difficult learning control
/// problems", IEEE Transactions on Systems, Man, and Cybernetics 13 (1983), appendix, without
/// friction: 10 N from the left or the right, a step of 0.02 s by Euler, a cart of 1 kg, a pole of
/// 0.1 kg and 1 m; over when it is more than 12 degrees off or the cart more than 2.4 m.
struct CartPole {
    double x = 0.0;        ///< m
    double speed = 0.0;    ///< m/s
    double angle = 0.0;    ///< rad off upright
    double turning = 0.0;  ///< rad/s

    /// Each number uniform within 0.05 of 0.
    static CartPole start(core::Rng& rng);

    void step(bool push_right);

    [[nodiscard]] bool over() const;
};

inline constexpr int kCartPoleSteps = 500;  ///< an episode that holds out so long is full

/// Steps, at most kCartPoleSteps, that a network holds out from `pole`: it gets the four numbers,
/// each scaled to about 1 where it is over, and pushes right where its output is above 0.
int steps_held(const NeuralNetwork& network, CartPole pole);

class CartPoleTask final : public Task {
  public:
    [[nodiscard]] std::size_t inputs() const override { return 4; }

    [[nodiscard]] std::size_t outputs() const override { return 1; }

    /// Mean steps of kEpisodes episodes.
    [[nodiscard]] double fitness(const NeuralNetwork& network, std::uint64_t course) const override;

    /// Mean steps of a hundred episodes that no fitness() uses.
    [[nodiscard]] double score(const NeuralNetwork& network, std::uint64_t course) const override;

    [[nodiscard]] double solved_at() const override { return 475.0; }

    static constexpr int kEpisodes = 5;
};

}  // namespace zoned::ai::learning
