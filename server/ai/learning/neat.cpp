#include "server/ai/learning/neat.h"

#include "server/ai/learning/genetic.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace zoned::ai::learning {

Neat::Neat(const NeatSettings& settings,
           std::uint32_t inputs,
           std::uint32_t outputs,
           std::uint64_t seed)
    : settings_(settings) {
    ZONED_ASSERT(settings.population >= 2, "a generation has parents");
    state_.rng = core::Rng(seed, 0x4EA7);
    const Genome seed_genome = simplest(inputs, outputs, state_.inventions);
    state_.genomes.assign(settings.population, seed_genome);
    for (Genome& genome : state_.genomes) {
        for (Genome::GeneLink& link : genome.links) {
            link.weight = state_.rng.range(-1.0F, 1.0F);
        }
    }
    sort_into_species();
}

/// Each genome to the first species whose representative is near, or to one of its own.
void Neat::sort_into_species() {
    for (Species& species : state_.species) {
        species.members.clear();
    }
    for (std::uint32_t i = 0; i < state_.genomes.size(); ++i) {
        const Genome& genome = state_.genomes[i];
        const auto home = std::find_if(
            state_.species.begin(), state_.species.end(), [this, &genome](const Species& species) {
                return distance_of(species.representative, genome, settings_.distance) <
                       settings_.threshold;
            });
        if (home != state_.species.end()) {
            home->members.push_back(i);
        } else {
            state_.species.push_back({genome, -1.0, state_.generation, {i}});
        }
    }
    std::erase_if(state_.species, [](const Species& species) { return species.members.empty(); });
}

/// Members by fitness, and whether a species became better.
void Neat::note_progress(std::span<const double> fitness) {
    for (Species& species : state_.species) {
        std::sort(species.members.begin(),
                  species.members.end(),
                  [fitness](std::uint32_t a, std::uint32_t b) {
                      return fitness[a] > fitness[b] || (fitness[a] == fitness[b] && a < b);
                  });
        const std::uint32_t champion = species.members.front();
        species.representative = state_.genomes[champion];
        if (fitness[champion] > species.best) {
            species.best = fitness[champion];
            species.improved_at = state_.generation;
        }
    }
}

/// Species without progress end, but never that of the fittest of all.
void Neat::end_species(std::span<const double> fitness) {
    const std::uint32_t best = static_cast<std::uint32_t>(Genetic::fittest(fitness));
    std::erase_if(state_.species, [this, best](const Species& species) {
        return state_.generation - species.improved_at >= settings_.patience &&
               species.members.front() != best;
    });
}

/// Children in proportion to the sum of the members' fitness divided by their number: largest
/// remainders.
std::vector<std::size_t> Neat::children_of_species(std::span<const double> fitness) const {
    std::vector<double> shares;
    for (const Species& species : state_.species) {
        double sum = 0.0;
        for (const std::uint32_t member : species.members) {
            sum += fitness[member];
        }
        // Where all fitness is 0 all species count alike.
        shares.push_back(sum / static_cast<double>(species.members.size()) + 1e-9);
    }
    const double all = std::accumulate(shares.begin(), shares.end(), 0.0);
    std::vector<std::size_t> children;
    std::vector<double> left;
    for (const double share : shares) {
        const double exact = share / all * static_cast<double>(settings_.population);
        children.push_back(static_cast<std::size_t>(exact));
        left.push_back(exact - std::floor(exact));
    }
    while (std::accumulate(children.begin(), children.end(), std::size_t{0}) <
           settings_.population) {
        const std::size_t most = Genetic::fittest(left);
        left[most] -= 1.0;
        ++children[most];
    }
    return children;
}

void Neat::breed(std::span<const double> fitness) {
    ZONED_ASSERT(fitness.size() == state_.genomes.size(), "every genome is judged");
    ZONED_ASSERT(
        std::all_of(
            fitness.begin(), fitness.end(), [](double f) { return f >= 0.0 && std::isfinite(f); }),
        "shares of fitness are shares of something");
    note_progress(fitness);
    end_species(fitness);
    const std::vector<std::size_t> children = children_of_species(fitness);
    std::vector<Genome> next;
    next.reserve(settings_.population);
    for (std::size_t s = 0; s < state_.species.size(); ++s) {
        add_children(state_.species[s], children[s], fitness, next);
    }
    state_.genomes = std::move(next);
    state_.genomes.resize(settings_.population, state_.genomes.front());
    ++state_.generation;
    sort_into_species();
}

void Neat::add_children(const Species& species,
                        std::size_t count,
                        std::span<const double> fitness,
                        std::vector<Genome>& next) {
    for (std::size_t k = 0; k < count; ++k) {
        const bool champion = k == 0 && species.members.size() >= settings_.champions_from;
        next.push_back(champion ? state_.genomes[species.members.front()]
                                : child_of(species, fitness));
    }
}

Genome Neat::child_of(const Species& species, std::span<const double> fitness) {
    core::Rng& rng = state_.rng;
    const auto parent_of = [this, &rng](const Species& of) {
        const auto survivors = static_cast<std::uint32_t>(
            std::max(1.0F, std::ceil(settings_.survivors * static_cast<float>(of.members.size()))));
        return of.members[rng.below(survivors)];
    };
    std::uint32_t mother = parent_of(species);
    if (rng.unit() >= settings_.crossover) {
        Genome child = state_.genomes[mother];
        mutate(child);
        return child;
    }
    const bool foreign = rng.unit() < settings_.between_species;
    const Species& other =
        foreign ? state_.species[rng.below(static_cast<std::uint32_t>(state_.species.size()))]
                : species;
    std::uint32_t father = parent_of(other);
    const std::size_t mother_links = state_.genomes[mother].links.size();
    const std::size_t father_links = state_.genomes[father].links.size();
    // Of equally fit parents the smaller one gives its topology.
    if (fitness[father] > fitness[mother] ||
        (fitness[father] == fitness[mother] && father_links < mother_links)) {
        std::swap(mother, father);
    }
    Genome child = cross(state_.genomes[mother], state_.genomes[father], rng);
    mutate(child);
    return child;
}

void Neat::mutate(Genome& genome) {
    core::Rng& rng = state_.rng;
    if (rng.unit() < settings_.add_node) {
        add_node(genome, state_.inventions, rng);
    }
    if (rng.unit() < settings_.add_link) {
        add_link(genome, state_.inventions, rng);
    }
    if (rng.unit() < settings_.weight_mutation) {
        mutate_weights(genome);
    }
}

void Neat::mutate_weights(Genome& genome) {
    core::Rng& rng = state_.rng;
    const float range = settings_.weight_range;
    for (Genome::GeneLink& link : genome.links) {
        if (rng.unit() < settings_.perturbed) {
            link.weight = std::clamp(
                link.weight + settings_.perturbation * bell(rng), -2.0F * range, 2.0F * range);
        } else {
            link.weight = rng.range(-range, range);
        }
    }
}

}  // namespace zoned::ai::learning
