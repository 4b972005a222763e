#include "server/ai/learning/arena.h"
#include "server/ai/learning/cart_pole.h"
#include "server/ai/learning/descent.h"
#include "server/ai/learning/evolution.h"
#include "server/ai/learning/guard.h"
#include "server/compute/team.h"
#include "server/compute/worker_pool.h"
#include "tests/determinism/hashes.h"
#include "shared/core/state_hash.h"

#include <array>

namespace zoned::determinism {

namespace {

namespace learning = ai::learning;

std::string hash_of(const learning::NeuralNetwork& network, double score) {
    core::StateHash hash;
    for (const float parameter : network.parameters) {
        hash.add(parameter);
    }
    hash.add(score);
    return hex(hash.value());
}

std::string bred(const learning::Task& task,
                 const learning::BreedingSettings& settings,
                 unsigned threads) {
    learning::Evolution evolution(task, settings, 7);
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    const compute::Team::Shift shift(team);
    for (int generation = 0; generation < 5; ++generation) {
        evolution.step([&team](std::size_t count, const auto& work) { team.run(count, 1, work); });
    }
    return hash_of(evolution.best(), evolution.score());
}

learning::FixedTopology layers(std::size_t inputs, std::size_t outputs) {
    learning::FixedTopology fixed;
    fixed.shape = learning::dense(std::array<std::size_t, 3>{inputs, 6, outputs});
    return fixed;
}

std::string fitted() {
    learning::Samples samples;
    samples.inputs = 3;
    samples.outputs = 1;
    core::Rng rng(5);
    for (int i = 0; i < 300; ++i) {
        const std::array<float, 3> x{rng.unit(), rng.unit(), rng.unit()};
        samples.add(x, std::array{x[0] * x[1] - x[2]});
    }
    learning::NeuralNetwork network = learning::dense(std::array<std::size_t, 3>{3, 8, 1});
    randomise(network, rng);
    learning::Descent descent({}, network, 9);
    double error = 0.0;
    for (int epoch = 0; epoch < 20; ++epoch) {
        error = descent.epoch(network, samples);
    }
    return hash_of(network, error);
}

}  // namespace

std::vector<Line> training_lines(unsigned threads) {
    const learning::CartPoleTask pole;
    const learning::ArenaTask arena;
    return {{"training", "pole_genetic", bred(pole, layers(4, 1), threads)},
            {"training", "pole_neat", bred(pole, learning::NeatSettings{}, threads)},
            {"training", "arena_genetic", bred(arena, layers(5, 2), threads)},
            {"training", "gradient", fitted()}};
}

}  // namespace zoned::determinism
