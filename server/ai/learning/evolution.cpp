#include "server/ai/learning/evolution.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::learning {

namespace {

std::variant<Genetic, Neat> first_population(const Task& task,
                                             const BreedingSettings& settings,
                                             std::uint64_t seed) {
    if (const auto* fixed = std::get_if<FixedTopology>(&settings)) {
        ZONED_ASSERT(
            fixed->shape.inputs == task.inputs() && fixed->shape.outputs.size() == task.outputs(),
            "a network fits its task");
        return Genetic(fixed->genetic, fixed->shape.parameters, fixed->spread, seed);
    }
    return Neat(std::get<NeatSettings>(settings),
                static_cast<std::uint32_t>(task.inputs()),
                static_cast<std::uint32_t>(task.outputs()),
                seed);
}

}  // namespace

Evolution::Evolution(const Task& task, const BreedingSettings& settings, std::uint64_t seed)
    : task_(task),
      seed_(seed),
      moved_set_(first_population(task, settings, seed)) {
    if (const auto* fixed = std::get_if<FixedTopology>(&settings)) {
        shape_ = fixed->shape;
    }
    judged_.resize(individuals());
    best_ = network_of_individual(0);
}

std::size_t Evolution::individuals() const {
    const auto* genetic = std::get_if<Genetic>(&moved_set_);
    return genetic != nullptr ? genetic->individuals().size()
                              : std::get<Neat>(moved_set_).genomes().size();
}

NeuralNetwork Evolution::network_of_individual(std::size_t index) const {
    if (const auto* genetic = std::get_if<Genetic>(&moved_set_)) {
        NeuralNetwork network = shape_;
        network.parameters = genetic->individuals()[index];
        return network;
    }
    return network_of(std::get<Neat>(moved_set_).genomes()[index]);
}

void Evolution::step(const RunRanges& run) {
    const std::uint64_t course = core::mix(seed_ ^ core::mix(generation() + 1));
    run(judged_.size(), [this, course](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            judged_[i] = task_.fitness(network_of_individual(i), course);
        }
    });
    const std::size_t fittest = Genetic::fittest(judged_);
    fitness_ = judged_[fittest];
    const NeuralNetwork champion = network_of_individual(fittest);
    const double score = task_.score(champion, core::mix(seed_));
    if (score > score_) {
        score_ = score;
        best_ = champion;
    }
    std::visit([this](auto& population) { population.breed(judged_); }, moved_set_);
}

std::uint64_t Evolution::generation() const {
    return std::visit([](const auto& population) { return population.generation(); }, moved_set_);
}

std::size_t Evolution::species() const {
    const auto* neat = std::get_if<Neat>(&moved_set_);
    return neat != nullptr ? neat->species().size() : 1;
}

Evolution::EvolutionState Evolution::state() const {
    EvolutionState state;
    if (const auto* genetic = std::get_if<Genetic>(&moved_set_)) {
        state.population = genetic->state();
    } else {
        state.population = std::get<Neat>(moved_set_).state();
    }
    state.best = best_;
    state.score = score_;
    state.fitness = fitness_;
    return state;
}

void Evolution::restore(EvolutionState state) {
    if (auto* genetic = std::get_if<Genetic>(&moved_set_)) {
        genetic->restore(std::move(std::get<Genetic::GeneticState>(state.population)));
    } else {
        std::get<Neat>(moved_set_).restore(std::move(std::get<Neat::NeatState>(state.population)));
    }
    judged_.resize(individuals());
    best_ = std::move(state.best);
    score_ = state.score;
    fitness_ = state.fitness;
}

}  // namespace zoned::ai::learning
