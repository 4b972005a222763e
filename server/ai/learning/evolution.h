// Evolution: a task, a method that breeds networks for it, and the best network so far.
#pragma once

#include "server/ai/learning/genetic.h"
#include "server/ai/learning/neat.h"
#include "server/ai/learning/task.h"

#include <cstdint>
#include <variant>
#include <vector>

namespace zoned::ai::learning {

/// The parameters of a network of fixed topology are the genes.
struct FixedTopology {
    NeuralNetwork shape;  ///< with the parameters around which the first generation lies
    float spread = 1.0F;
    GeneticSettings genetic;
};

using BreedingSettings = std::variant<FixedTopology, NeatSettings>;

/// After any number of generations a copy of the state goes on as the original does, bit for bit,
/// for any number of threads.
class Evolution {
  public:
    struct EvolutionState {
        std::variant<Genetic::GeneticState, Neat::NeatState> population;
        NeuralNetwork best;    ///< by score
        double score = -1.0;   ///< of `best`
        double fitness = 0.0;  ///< of the fittest of the last generation
    };

    /// `task` must outlive this and fit the shape.
    Evolution(const Task& task, const BreedingSettings& settings, std::uint64_t seed);

    /// Judges a generation, all on one course that is drawn by its number, scores its fittest on a
    /// course of their own that is always the same, and breeds the next.
    void step(const RunRanges& run);

    [[nodiscard]] std::uint64_t generation() const;

    [[nodiscard]] const NeuralNetwork& best() const { return best_; }

    [[nodiscard]] double score() const { return score_; }

    [[nodiscard]] double fitness() const { return fitness_; }

    /// Species of a population that grows, else 1.
    [[nodiscard]] std::size_t species() const;

    [[nodiscard]] EvolutionState state() const;

    /// `state` is of the same settings and task.
    void restore(EvolutionState state);

  private:
    [[nodiscard]] NeuralNetwork network_of_individual(std::size_t index) const;
    [[nodiscard]] std::size_t individuals() const;

    const Task& task_;
    std::uint64_t seed_;
    NeuralNetwork shape_;
    std::variant<Genetic, Neat> moved_set_;
    NeuralNetwork best_;
    double score_ = -1.0;
    double fitness_ = 0.0;
    std::vector<double> judged_;
};

}  // namespace zoned::ai::learning
