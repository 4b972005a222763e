// Neat: evolves the weights and topology of networks together, from the simplest ones on (NEAT).
#pragma once

#include "server/ai/learning/genome.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::learning {

/// The defaults are those of the paper (Stanley, Miikkulainen 2002, section 4.1). The weights suit
/// the network's own activation, which is half as steep as the paper's.
struct NeatSettings {
    std::size_t population = 150;  ///< [2, 10000]
    Distance distance;
    float threshold = 3.0F;        ///< genomes within this distance are one species
    float weight_mutation = 0.8F;  ///< share of genomes whose weights change
    float perturbed = 0.9F;        ///< share of these weights that move; the others are drawn anew
    float perturbation = 0.5F;     ///< standard deviation of a move
    float weight_range = 4.0F;     ///< new weights lie within this of 0
    float add_node = 0.03F;
    float add_link = 0.05F;
    float crossover = 0.75F;         ///< share of children with two parents
    float between_species = 0.001F;  ///< share of these with a parent of another species
    float survivors = 0.2F;          ///< share of a species, the fittest, that become parents
    std::uint64_t patience = 15;     ///< a species ends after this many generations without
                                     ///< progress
    std::size_t champions_from = 5;  ///< the best of a species of at least this size lives on
                                     ///< unchanged
};

/// A population in species that first compete within themselves (explicit fitness sharing, section
/// 3.3). So new structures have time to become good.
class Neat {
  public:
    struct Species {
        Genome representative;  ///< the fittest of its last generation
        double best = -1.0;     ///< best fitness so far
        std::uint64_t improved_at = 0;
        std::vector<std::uint32_t> members;
    };

    struct NeatState {
        std::uint64_t generation = 0;
        std::vector<Genome> genomes;
        std::vector<Species> species;
        Inventions inventions;
        core::Rng rng;
    };

    Neat(const NeatSettings& settings,
         std::uint32_t inputs,
         std::uint32_t outputs,
         std::uint64_t seed);

    [[nodiscard]] std::span<const Genome> genomes() const { return state_.genomes; }

    [[nodiscard]] std::uint64_t generation() const { return state_.generation; }

    [[nodiscard]] std::span<const Species> species() const { return state_.species; }

    /// Makes the next generation; `fitness` holds the fitness of each genome, >= 0.
    void breed(std::span<const double> fitness);

    [[nodiscard]] const NeatState& state() const { return state_; }

    void restore(NeatState state) { state_ = std::move(state); }

  private:
    void sort_into_species();
    void note_progress(std::span<const double> fitness);
    void end_species(std::span<const double> fitness);
    [[nodiscard]] std::vector<std::size_t> children_of_species(
        std::span<const double> fitness) const;
    void add_children(const Species& species,
                      std::size_t count,
                      std::span<const double> fitness,
                      std::vector<Genome>& next);
    Genome child_of(const Species& species, std::span<const double> fitness);
    void mutate(Genome& genome);
    void mutate_weights(Genome& genome);

    NeatSettings settings_;
    NeatState state_;
};

}  // namespace zoned::ai::learning
