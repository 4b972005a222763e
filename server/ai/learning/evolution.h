// Evolution: breeds networks for a task by a chosen method, and keeps the best network so far.
#pragma once

#include "server/ai/learning/genetic.h"
#include "server/ai/learning/neat.h"
#include "server/ai/learning/task.h"

#include <cstdint>
#include <variant>
#include <vector>

namespace zoned::ai::learning {

/// FixedTopology: breeds the parameters of a network of fixed topology; they are the genes.
struct FixedTopology {
    NeuralNetwork shape;  ///< the first generation lies around its parameters
    float spread = 1.0F;
    GeneticSettings genetic;
};

using BreedingSettings = std::variant<FixedTopology, NeatSettings>;

/// After any number of generations a copy of the state continues as the original does, bit for bit,
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

    /// Judges a generation on one course that is drawn by its number, and breeds the next. The
    /// fittest is scored on a separate course that is always the same.
    void step(const RunRanges& run);

    [[nodiscard]] std::uint64_t generation() const;

    [[nodiscard]] const NeuralNetwork& best() const { return best_; }

    [[nodiscard]] double score() const { return score_; }

    [[nodiscard]] double fitness() const { return fitness_; }

    /// The number of species in a population that grows, else 1.
    [[nodiscard]] std::size_t species() const;

    [[nodiscard]] EvolutionState state() const;

    /// `state` must come from the same settings and task.
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
