// CartPole: the learning task of keeping a pole upright on a cart; it compares learning methods.
#pragma once

#include "server/ai/learning/task.h"

namespace zoned::ai::learning {

/// Barto, Sutton, Anderson, "Neuronlike adaptive elements that can solve difficult learning control
/// problems", IEEE Transactions on Systems, Man, and Cybernetics 13 (1983), appendix, without
/// friction. The push is 10 N from the left or the right, and the step is 0.02 s by Euler. The cart
/// has 1 kg; the pole has 0.1 kg and 1 m. The episode ends when the pole is more than 12 degrees
/// off or the cart more than 2.4 m.
struct CartPole {
    double x = 0.0;        ///< m
    double speed = 0.0;    ///< m/s
    double angle = 0.0;    ///< rad off upright
    double turning = 0.0;  ///< rad/s

    /// Each number is uniform within 0.05 of 0.
    static CartPole start(core::Rng& rng);

    void step(bool push_right);

    [[nodiscard]] bool over() const;
};

inline constexpr int kCartPoleSteps = 500;  ///< an episode of this many steps is full

/// The number of steps that a network keeps the pole up from `pole`, at most kCartPoleSteps. The
/// network gets the four numbers, each scaled to about 1 at its limit. It pushes right where its
/// output is above 0.
int steps_held(const NeuralNetwork& network, CartPole pole);

class CartPoleTask final : public Task {
  public:
    [[nodiscard]] std::size_t inputs() const override { return 4; }

    [[nodiscard]] std::size_t outputs() const override { return 1; }

    /// Mean steps over kEpisodes episodes.
    [[nodiscard]] double fitness(const NeuralNetwork& network, std::uint64_t course) const override;

    /// Mean steps over a hundred episodes that no fitness() uses.
    [[nodiscard]] double score(const NeuralNetwork& network, std::uint64_t course) const override;

    [[nodiscard]] double solved_at() const override { return 475.0; }

    static constexpr int kEpisodes = 5;
};

}  // namespace zoned::ai::learning
