// Genetic: a genetic algorithm over real vectors, with the same bits for the same seed.
#pragma once

#include "shared/core/rng.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::learning {

/// A random number of mean 0 and variance 1 within 2 sqrt(3). It is the sum of four uniform numbers
/// (Irwin, Hall, Biometrika 19, 1927), which needs no logarithm of the C library.
inline float bell(core::Rng& rng) {
    const float sum = (rng.unit() + rng.unit()) + (rng.unit() + rng.unit());
    return (sum - 2.0F) * 1.7320508F;
}

struct GeneticSettings {
    std::size_t population = 64;  ///< [2, 10000]
    std::size_t elite = 2;        ///< the best ones that live on unchanged, < population
    std::size_t tournament = 3;   ///< candidates per tournament; the fittest becomes a parent, > 0
    float crossover = 0.5F;       ///< share of children with two parents, [0, 1]
    float mutation = 0.2F;        ///< share of genes that change, [0, 1]
    float mutation_scale = 0.3F;  ///< standard deviation of that change
};

/// A generation of individuals, each a vector of genes. The same bits for any number of threads.
/// Source: Goldberg, "Genetic Algorithms in Search, Optimization and Machine Learning", 1989,
/// chapter 3. Source for tournaments: Miller, Goldberg, "Genetic algorithms, tournament selection,
/// and the effects of noise", Complex Systems 9, 1995.
class Genetic {
  public:
    struct GeneticState {
        std::uint64_t generation = 0;
        std::vector<std::vector<float>> genes;  ///< by individual, all of one length
        core::Rng rng;
    };

    /// The first individual is `start`, the others lie around it by `spread` in each gene.
    Genetic(const GeneticSettings& settings,
            std::span<const float> start,
            float spread,
            std::uint64_t seed);

    [[nodiscard]] std::span<const std::vector<float>> individuals() const { return state_.genes; }

    [[nodiscard]] std::uint64_t generation() const { return state_.generation; }

    /// Replaces this generation by the next. `fitness`: of each individual, more is better; not a
    /// number (NaN) counts as the worst. Of equally fit ones the first counts.
    void breed(std::span<const double> fitness);

    /// Index of the fittest, as breed() sees it.
    static std::size_t fittest(std::span<const double> fitness);

    [[nodiscard]] const GeneticState& state() const { return state_; }

    void restore(GeneticState state);

  private:
    std::size_t choose_parent(std::span<const std::size_t> rank_of);

    GeneticSettings settings_;
    GeneticState state_;
};

}  // namespace zoned::ai::learning
