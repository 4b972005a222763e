// XorTask: the smallest learning task that needs a network with hidden nodes.
#pragma once

#include "server/ai/learning/task.h"

namespace zoned::ai::learning {

/// Four cases of exclusive or, inputs 0 and 1, outputs -1 and 1. Fitness as in the paper on NEAT
/// (section 4.1): (4 - sum of errors)^2. Errors here are in halves of the output's range.
class XorTask final : public Task {
  public:
    [[nodiscard]] std::size_t inputs() const override { return 2; }

    [[nodiscard]] std::size_t outputs() const override { return 1; }

    [[nodiscard]] double fitness(const NeuralNetwork& network, std::uint64_t course) const override;

    /// The number of cases on the right side of 0.
    [[nodiscard]] double score(const NeuralNetwork& network, std::uint64_t course) const override;

    [[nodiscard]] double solved_at() const override { return 4.0; }
};

}  // namespace zoned::ai::learning
