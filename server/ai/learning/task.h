// Task: something that a network learns, and the measure of its skill.
#pragma once

#include "server/ai/learning/neural_network.h"

#include <cstdint>
#include <functional>

namespace zoned::ai::learning {

/// Calls work(begin, end) for ranges that cover [0, count), in any order, on any thread. Returns
/// when all are done. Each index is independent of the others, so the result is the same.
using RunRanges = std::function<void(std::size_t count,
                                     const std::function<void(std::size_t, std::size_t)>& work)>;

/// Runs all indices at once, on the calling thread.
inline void run_here(std::size_t count, const std::function<void(std::size_t, std::size_t)>& work) {
    if (count > 0) {
        work(0, count);
    }
}

/// A task has no changing state: several threads ask it at a time.
class Task {
  public:
    Task() = default;
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;
    virtual ~Task() = default;

    [[nodiscard]] virtual std::size_t inputs() const = 0;
    [[nodiscard]] virtual std::size_t outputs() const = 0;

    /// >= 0, finite, more is better. `course` numbers the circumstances (starts, paths of others).
    /// Networks to be compared are judged on the same course.
    [[nodiscard]] virtual double fitness(const NeuralNetwork& network,
                                         std::uint64_t course) const = 0;

    /// The figure by which people judge the task. It covers many circumstances that fitness() never
    /// uses; `course` chooses them. More is better.
    [[nodiscard]] virtual double score(const NeuralNetwork& network,
                                       std::uint64_t course) const = 0;

    /// A score that counts as solved.
    [[nodiscard]] virtual double solved_at() const = 0;
};

}  // namespace zoned::ai::learning
