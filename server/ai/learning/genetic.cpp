#include "server/ai/learning/genetic.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace zoned::ai::learning {

namespace {

bool fitter(double a, double b) {
    return a > b || (std::isnan(b) && !std::isnan(a));
}

}  // namespace

Genetic::Genetic(const GeneticSettings& settings,
                 std::span<const float> start,
                 float spread,
                 std::uint64_t seed)
    : settings_(settings) {
    ZONED_ASSERT(
        settings.population >= 2 && settings.elite < settings.population && settings.tournament > 0,
        "a generation has parents and children");
    state_.rng = core::Rng(seed, 0x6E4E71C);
    state_.genes.assign(settings.population, std::vector<float>(start.begin(), start.end()));
    for (std::size_t i = 1; i < state_.genes.size(); ++i) {
        for (float& gene : state_.genes[i]) {
            gene += spread * bell(state_.rng);
        }
    }
}

std::size_t Genetic::fittest(std::span<const double> fitness) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < fitness.size(); ++i) {
        if (fitter(fitness[i], fitness[best])) {
            best = i;
        }
    }
    return best;
}

void Genetic::restore(GeneticState state) {
    ZONED_ASSERT(state.genes.size() == settings_.population, "a state has all individuals");
    state_ = std::move(state);
}

std::size_t Genetic::choose_parent(std::span<const std::size_t> rank_of) {
    const auto count = static_cast<std::uint32_t>(rank_of.size());
    std::size_t best = state_.rng.below(count);
    for (std::size_t k = 1; k < settings_.tournament; ++k) {
        const std::size_t other = state_.rng.below(count);
        if (rank_of[other] < rank_of[best]) {
            best = other;
        }
    }
    return best;
}

void Genetic::breed(std::span<const double> fitness) {
    const std::size_t count = state_.genes.size();
    ZONED_ASSERT(fitness.size() == count, "every individual is judged");
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [fitness](std::size_t a, std::size_t b) {
        return fitter(fitness[a], fitness[b]) || (!fitter(fitness[b], fitness[a]) && a < b);
    });
    std::vector<std::size_t> rank_of(count);
    for (std::size_t rank = 0; rank < count; ++rank) {
        rank_of[order[rank]] = rank;
    }
    std::vector<std::vector<float>> next;
    next.reserve(count);
    for (std::size_t e = 0; e < settings_.elite; ++e) {
        next.push_back(state_.genes[order[e]]);
    }
    while (next.size() < count) {
        std::vector<float> child = state_.genes[choose_parent(rank_of)];
        if (state_.rng.unit() < settings_.crossover) {
            const std::vector<float>& other = state_.genes[choose_parent(rank_of)];
            for (std::size_t g = 0; g < child.size(); ++g) {
                if ((state_.rng.next() & 1U) != 0) {
                    child[g] = other[g];
                }
            }
        }
        for (float& gene : child) {
            if (state_.rng.unit() < settings_.mutation) {
                gene += settings_.mutation_scale * bell(state_.rng);
            }
        }
        next.push_back(std::move(child));
    }
    state_.genes = std::move(next);
    ++state_.generation;
}

}  // namespace zoned::ai::learning
