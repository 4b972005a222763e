#include "server/ai/learning/xor_task.h"

#include <array>
#include <cmath>

namespace zoned::ai::learning {

namespace {

/// Output in each case, for inputs (0,0) (1,0) (0,1) (1,1).
std::array<float, 4> answers_of(const NeuralNetwork& network) {
    std::array<float, kMaxValues> values;
    std::array<float, 4> answers{};
    for (unsigned k = 0; k < 4; ++k) {
        const float in[] = {static_cast<float>(k & 1U), static_cast<float>(k >> 1U)};
        evaluate(network, in, values, std::span(&answers[k], 1));
    }
    return answers;
}

constexpr std::array<float, 4> kWanted{-1.0F, 1.0F, 1.0F, -1.0F};

}  // namespace

double XorTask::fitness(const NeuralNetwork& network, std::uint64_t /*course*/) const {
    const std::array<float, 4> answers = answers_of(network);
    double left = 4.0;
    for (std::size_t k = 0; k < 4; ++k) {
        left -= 0.5 * std::abs(static_cast<double>(answers[k]) - static_cast<double>(kWanted[k]));
    }
    return left > 0.0 ? left * left : 0.0;
}

double XorTask::score(const NeuralNetwork& network, std::uint64_t /*course*/) const {
    const std::array<float, 4> answers = answers_of(network);
    int right = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        right += answers[k] * kWanted[k] > 0.0F ? 1 : 0;
    }
    return right;
}

}  // namespace zoned::ai::learning
