#include "server/ai/learning/evolution.h"

#include "server/ai/learning/cart_pole.h"
#include "server/ai/learning/xor_task.h"
#include "server/compute/team.h"
#include "server/compute/worker_pool.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace zoned::ai::learning {
namespace {

TEST(Genetic, FindsTheTopOfAHillAndKeepsItsBest) {
    const std::vector<float> start(6, 0.0F);
    GeneticSettings settings;
    settings.mutation_scale = 0.1F;
    Genetic genetic(settings, start, 1.0F, 4);
    const auto height = [](const std::vector<float>& genes) {
        double off = 0.0;
        for (std::size_t g = 0; g < genes.size(); ++g) {
            const double d = static_cast<double>(genes[g]) - (static_cast<double>(g) - 2.5);
            off += d * d;
        }
        return -off;
    };
    double before = -1e9;
    for (int generation = 0; generation < 200; ++generation) {
        std::vector<double> fitness;
        for (const auto& genes : genetic.individuals()) {
            fitness.push_back(height(genes));
        }
        const double best = fitness[Genetic::fittest(fitness)];
        EXPECT_GE(best, before);  // the elite lives on as it is
        before = best;
        genetic.breed(fitness);
    }
    // Six coordinates within about one mutation of the top.
    EXPECT_GT(before, -6.0 * 0.1 * 0.1);
}

TEST(Genetic, CountsNoNumberAsTheWorst) {
    const double nan = std::nan("");
    EXPECT_EQ(Genetic::fittest(std::array{nan, -5.0, nan, -4.0}), 3u);
    EXPECT_EQ(Genetic::fittest(std::array{nan, nan}), 0u);
    Genetic genetic({4, 1, 2, 0.0F, 0.0F, 0.0F}, std::array{1.0F}, 1.0F, 3);
    const float third = genetic.individuals()[2][0];
    genetic.breed(std::array{nan, nan, 0.5, nan});
    EXPECT_EQ(genetic.individuals()[0][0], third);
}

TEST(Bell, HasTheMomentsOfItsFormula) {
    core::Rng rng(2);
    double sum = 0.0;
    double squares = 0.0;
    constexpr int kCount = 200000;
    for (int i = 0; i < kCount; ++i) {
        const auto x = static_cast<double>(bell(rng));
        sum += x;
        squares += x * x;
        EXPECT_LE(std::abs(x), 2.0 * std::sqrt(3.0) + 1e-6);
    }
    // Five standard errors: 1 / sqrt(n), and of the variance sqrt((kurtosis - 1) / n) < sqrt(2 /
    // n).
    EXPECT_NEAR(sum / kCount, 0.0, 5.0 / std::sqrt(kCount));
    EXPECT_NEAR(squares / kCount, 1.0, 5.0 * std::sqrt(2.0 / kCount));
}

Genome split_once(Inventions& inventions, std::uint64_t seed) {
    Genome genome = simplest(2, 1, inventions);
    core::Rng rng(seed);
    for (Genome::GeneLink& link : genome.links) {
        link.weight = rng.range(-1.0F, 1.0F);
    }
    add_node(genome, inventions, rng);
    return genome;
}

TEST(Genome, NamesTheSameInventionAlikeAndAnotherOtherwise) {
    Inventions inventions;
    std::set<std::uint32_t> nodes;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Genome genome = split_once(inventions, seed);
        ASSERT_EQ(genome.hidden.size(), 1u);
        EXPECT_EQ(genome.links.size(), 5u);
        nodes.insert(genome.hidden[0]);
    }
    // Three links can be split, each gives one node, however often that is done.
    EXPECT_EQ(nodes.size(), 3u);
    EXPECT_EQ(inventions.links.size(), 3u + 2u * 3u);
}

TEST(Genome, SplittingALinkAgainGivesAnotherNode) {
    Inventions inventions;
    Genome genome = split_once(inventions, 1);
    for (Genome::GeneLink& link : genome.links) {
        link.on = !link.on;  // only the one that was split
    }
    core::Rng rng(3);
    ASSERT_TRUE(add_node(genome, inventions, rng));
    ASSERT_EQ(genome.hidden.size(), 2u);
    EXPECT_NE(genome.hidden[0], genome.hidden[1]);
}

TEST(Genome, MeasuresDistanceByTheFormula) {
    // Innovations: a has 0 1 2 4, b has 0 1 2 3 5 6. Both have three, of which two differ in weight
    // by 0.5 and 1. 4 and 3 are disjoint (below 4), 5 and 6 are excess.
    const auto make = [](std::vector<std::pair<std::uint32_t, float>> genes) {
        Genome genome;
        for (const auto& [innovation, weight] : genes) {
            genome.links.push_back({innovation, 0, 9, weight, true});
        }
        return genome;
    };
    const Genome a = make({{0, 1.0F}, {1, 0.0F}, {2, 0.5F}, {4, 9.0F}});
    const Genome b = make({{0, 0.5F}, {1, 1.0F}, {2, 0.5F}, {3, 1.0F}, {5, 1.0F}, {6, 1.0F}});
    const Distance weights{2.0F, 3.0F, 4.0F};
    EXPECT_FLOAT_EQ(distance_of(a, b, weights), 2.0F * 2 + 3.0F * 2 + 4.0F * 0.5F);
    EXPECT_FLOAT_EQ(distance_of(b, a, weights), distance_of(a, b, weights));
    EXPECT_EQ(distance_of(a, a, weights), 0.0F);
}

TEST(Genome, ComputesTheSameAfterALinkIsSplitWhereTheSquashIsNearlyAStraightLine) {
    Inventions inventions;
    Genome genome = simplest(1, 1, inventions);
    genome.links[0].weight = 0.02F;
    const NeuralNetwork before = network_of(genome);
    Genome grown = genome;
    core::Rng rng(1);
    while (grown.links[0].on) {
        grown = genome;
        add_node(grown, inventions, rng);
    }
    const NeuralNetwork after = network_of(grown);
    EXPECT_EQ(after.nodes.size(), before.nodes.size() + 1);
    EXPECT_EQ(defect_of(after), "");
    float a = 0.0F;
    float b = 0.0F;
    std::array<float, 8> values{};
    evaluate(before, std::array{0.05F}, values, std::span(&a, 1));
    evaluate(after, std::array{0.05F}, values, std::span(&b, 1));
    // squash(x) = x - 8 x^3 / 27 + ...: at x = 0.05 less than a thousandth of x.
    EXPECT_NEAR(a, b, 1e-3F * 0.001F);
}

TEST(Neat, GrowsOnlySoundNetworksWhateverItDoes) {
    NeatSettings settings;
    settings.population = 60;
    settings.add_node = 0.5F;
    settings.add_link = 0.8F;
    Neat neat(settings, 3, 2, 5);
    core::Rng rng(6);
    for (int generation = 0; generation < 40; ++generation) {
        std::vector<double> fitness;
        for (const Genome& genome : neat.genomes()) {
            EXPECT_EQ(defect_of(network_of(genome)), "");
            EXPECT_TRUE(std::is_sorted(
                genome.links.begin(), genome.links.end(), [](const auto& a, const auto& b) {
                    return a.innovation < b.innovation;
                }));
            fitness.push_back(rng.unit());
        }
        neat.breed(fitness);
        std::set<std::uint32_t> members;
        for (const Neat::Species& species : neat.species()) {
            members.insert(species.members.begin(), species.members.end());
        }
        EXPECT_EQ(members.size(), settings.population);
        EXPECT_EQ(neat.genomes().size(), settings.population);
    }
    std::size_t most = 0;
    for (const Genome& genome : neat.genomes()) {
        most = std::max(most, genome.hidden.size());
    }
    EXPECT_GT(most, 5u);
}

TEST(Neat, SolvesExclusiveOrForTenOfTenSeeds) {
    const XorTask task;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Evolution evolution(task, NeatSettings{}, seed);
        while (evolution.score() < task.solved_at() && evolution.generation() < 300) {
            evolution.step(run_here);
        }
        EXPECT_EQ(evolution.score(), 4.0) << "seed " << seed;
        // No network without a hidden node does it (Minsky, Papert, "Perceptrons", 1969).
        EXPECT_GE(evolution.best().nodes.size(), 2u);
    }
}

TEST(CartPole, FollowsTheEquationsOfMotion) {
    // At rest and upright a push of 10 N moves 1.1 kg: by hand, angular acceleration -(10 / 1.1) /
    // (0.5 (4 / 3 - 0.1 / 1.1)), and 10 / 1.1 less the pole's share.
    CartPole pole;
    pole.step(true);
    const double turn = -(10.0 / 1.1) / (0.5 * (4.0 / 3.0 - 0.1 / 1.1));
    EXPECT_NEAR(pole.turning, 0.02 * turn, 1e-12);
    EXPECT_NEAR(pole.speed, 0.02 * (10.0 / 1.1 - 0.1 * 0.5 * turn / 1.1), 1e-12);
    EXPECT_EQ(pole.x, 0.0);  // Euler: the position follows a step later
    // Left alone at a slant it falls: without pushes that balance, within a second or so.
    pole = CartPole{};
    pole.angle = 0.05;
    int steps = 0;
    while (!pole.over() && steps < 500) {
        pole.step(steps++ % 2 == 0);
    }
    EXPECT_LT(steps, 100);
}

TEST(CartPole, IsSolvedByWhoeverLeansAgainstTheFallAndNotByAConstant) {
    NeuralNetwork network = dense(std::array<std::size_t, 2>{4, 1});
    const CartPoleTask task;
    EXPECT_LT(task.score(network, 1), 20.0);  // always left
    network.parameters = {0.0F, 0.1F, 0.3F, 1.0F, 1.0F};
    EXPECT_GT(task.score(network, 1), 475.0);
}

FixedTopology cart_pole_topology() {
    FixedTopology fixed;
    fixed.shape = dense(std::array<std::size_t, 3>{4, 6, 1});
    return fixed;
}

TEST(Genetic, BalancesThePoleForTenOfTenSeedsOnEpisodesThatItNeverSaw) {
    const CartPoleTask task;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Evolution evolution(task, cart_pole_topology(), seed);
        while (evolution.score() < 499.0 && evolution.generation() < 100) {
            evolution.step(run_here);
        }
        EXPECT_GE(task.score(evolution.best(), 1000 + seed), 475.0)
            << "seed " << seed << ", generation " << evolution.generation();
    }
}

/// The same course of breeding on `threads` threads.
Evolution::EvolutionState bred(const BreedingSettings& settings,
                               unsigned threads,
                               int generations) {
    const CartPoleTask task;
    Evolution evolution(task, settings, 3);
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    const compute::Team::Shift shift(team);
    for (int g = 0; g < generations; ++g) {
        evolution.step([&team](std::size_t count, const auto& work) { team.run(count, 4, work); });
    }
    return evolution.state();
}

TEST(Evolution, GivesTheSameBitsForAnyNumberOfThreads) {
    const auto fixed = std::get<Genetic::GeneticState>(bred(cart_pole_topology(), 1, 6).population);
    const auto same = std::get<Genetic::GeneticState>(bred(cart_pole_topology(), 3, 6).population);
    EXPECT_EQ(fixed.genes, same.genes);
    EXPECT_EQ(fixed.rng.state, same.rng.state);
    const auto neat = std::get<Neat::NeatState>(bred(NeatSettings{}, 1, 4).population);
    const auto alike = std::get<Neat::NeatState>(bred(NeatSettings{}, 3, 4).population);
    EXPECT_EQ(neat.genomes, alike.genomes);
}

TEST(Evolution, GoesOnBitForBitFromACopyOfItsState) {
    const CartPoleTask task;
    for (const BreedingSettings& settings :
         {BreedingSettings(cart_pole_topology()), BreedingSettings(NeatSettings{})}) {
        Evolution whole(task, settings, 8);
        for (int g = 0; g < 3; ++g) {
            whole.step(run_here);
        }
        Evolution resumed(task, settings, 8);
        resumed.restore(whole.state());
        for (int g = 0; g < 3; ++g) {
            whole.step(run_here);
            resumed.step(run_here);
        }
        EXPECT_EQ(whole.best(), resumed.best());
        EXPECT_EQ(whole.score(), resumed.score());
        EXPECT_EQ(whole.fitness(), resumed.fitness());
    }
}

}  // namespace
}  // namespace zoned::ai::learning
