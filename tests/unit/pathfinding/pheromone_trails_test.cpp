#include "tests/scenario/ant_colony.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

namespace zoned::ai::pathfinding {

using namespace scenario;

namespace {

using pathfinding::Cell;
using pathfinding::GridMap;

/// Two paths from home (left) to food (right): a short one above, a long one below (the double
/// bridge of Goss, Aron, Deneubourg and Pasteels, "Self-organized shortcuts in the Argentine ant",
/// Naturwissenschaften 76, 1989).
constexpr std::string_view kBridge[] = {"@@@@@@@@@@@@@@@@@@@@@",
                                        "@...@@@@@@@@@@@@@...@",
                                        "@...................@",
                                        "@...@@@@@@@@@@@@@...@",
                                        "@...@@@@@@@@@@@@@...@",
                                        "@@.@@@@@@@@@@@@@@@.@@",
                                        "@@.@@@@@@@@@@@@@@@.@@",
                                        "@@.@@@@@@@@@@@@@@@.@@",
                                        "@@.@@@@@@@@@@@@@@@.@@",
                                        "@@.................@@",
                                        "@@@@@@@@@@@@@@@@@@@@@"};
constexpr Cell kNest{1, 2};
constexpr Cell kMeal{19, 2};
constexpr Cell kShortMiddle{10, 2};
constexpr Cell kLongMiddle{10, 9};

/// Two paths of the same length.
constexpr std::string_view kEqualBridge[] = {"@@@@@@@@@@@@@@@@@@@@@",
                                             "@@.................@@",
                                             "@@.@@@@@@@@@@@@@@@.@@",
                                             "@@.@@@@@@@@@@@@@@@.@@",
                                             "@...@@@@@@@@@@@@@...@",
                                             "@...@@@@@@@@@@@@@...@",
                                             "@...@@@@@@@@@@@@@...@",
                                             "@@.@@@@@@@@@@@@@@@.@@",
                                             "@@.@@@@@@@@@@@@@@@.@@",
                                             "@@.................@@",
                                             "@@@@@@@@@@@@@@@@@@@@@"};

GridMap bridge(std::span<const std::string_view, 11> rows = kBridge) {
    GridMap map(21, 11);
    for (std::uint16_t y = 0; y < 11; ++y) {
        for (std::uint16_t x = 0; x < 21; ++x) {
            map.set_passable({x, y}, rows[y][x] == '.');
        }
    }
    return map;
}

struct Passages {
    double over_short = 0.0;
    double over_long = 0.0;

    [[nodiscard]] double short_share() const { return over_short / (over_short + over_long); }
};

Passages walk(AntColony& colony, const GridMap& map, int ticks) {
    Passages seen;
    for (int t = 0; t < ticks; ++t) {
        colony.step();
        for (std::size_t i = 0; i < colony.walkers(); ++i) {
            seen.over_short += colony.walker_at(i) == map.place(kShortMiddle) ? 1.0 : 0.0;
            seen.over_long += colony.walker_at(i) == map.place(kLongMiddle) ? 1.0 : 0.0;
        }
    }
    return seen;
}

class AntColonyOnABridge : public testing::TestWithParam<std::uint64_t> {
  protected:
    AntColonyOnABridge() {
        colony.set_food(kMeal, true);
        colony.add_walkers(60);
    }

    AntColonySettings with_seed() const {
        AntColonySettings s;
        s.seed = GetParam();
        return s;
    }

    GridMap map = bridge();
    AntColony colony{map, kNest, with_seed()};
};

TEST_P(AntColonyOnABridge, MostTakeTheShortWayAndSomeExplore) {
    walk(colony, map, 4000);
    const std::uint64_t before = colony.delivered();
    const Passages seen = walk(colony, map, 4000);
    EXPECT_GT(seen.short_share(), 0.8);
    EXPECT_GT(seen.over_long, 0.0) << "nobody explores";
    // A path of 18 steps there and 18 back at best.
    const double best = 60.0 * 4000.0 / 36.0;
    EXPECT_GT(static_cast<double>(colony.delivered() - before), 0.4 * best);
}

TEST_P(AntColonyOnABridge, AWayThatBecomesWorseIsAbandoned) {
    walk(colony, map, 4000);
    // Mud: 13 cells that take eight times as long make the short path the longer one (111 ticks
    // against 32 or more).
    for (std::uint16_t x = 4; x <= 16; ++x) {
        colony.set_slowness({x, 2}, 8);
    }
    walk(colony, map, 6000);
    const Passages seen = walk(colony, map, 4000);
    // An ant in mud is seen there eight times as often.
    const double crossings = seen.over_short / 8.0;
    EXPECT_LT(crossings / (crossings + seen.over_long), 0.3);
}

TEST_P(AntColonyOnABridge, AWayThatIsClosedIsReplaced) {
    walk(colony, map, 4000);
    map.set_passable(kShortMiddle, false);
    walk(colony, map, 5000);
    const std::uint64_t before = colony.delivered();
    walk(colony, map, 4000);
    // 32 steps in each direction at best.
    EXPECT_GT(static_cast<double>(colony.delivered() - before), 0.3 * 60.0 * 4000.0 / 64.0);
}

TEST_P(AntColonyOnABridge, ScentIsForgottenWhereNobodyWalks) {
    walk(colony, map, 3000);
    ASSERT_GT(colony.scent(AntColony::kFood, map.place(kShortMiddle)), 0.0F);
    colony.set_food(kMeal, false);
    // Ants with food deliver it; then 0.998^t falls below the smell threshold, 1e-4, within 4,600
    // ticks.
    walk(colony, map, 8000);
    EXPECT_EQ(colony.scent(AntColony::kFood, map.place(kShortMiddle)), 0.0F);
    const std::uint64_t before = colony.delivered();
    walk(colony, map, 500);
    EXPECT_EQ(colony.delivered(), before);
}

INSTANTIATE_TEST_SUITE_P(Seeds, AntColonyOnABridge, testing::Values(1, 2, 3, 4, 5));

TEST(AntColony, IsTheSameForTheSameSeed) {
    const GridMap map = bridge();
    AntColony one(map, kNest, {});
    AntColony two(map, kNest, {});
    for (AntColony* colony : {&one, &two}) {
        colony->set_food(kMeal, true);
        colony->add_walkers(20);
        walk(*colony, map, 1000);
    }
    for (std::size_t i = 0; i < one.walkers(); ++i) {
        ASSERT_EQ(one.walker_at(i), two.walker_at(i));
    }
    EXPECT_EQ(one.delivered(), two.delivered());
}

std::uint64_t hash_of(const PheromoneTrails& trails) {
    core::StateHash hash;
    trails.hash(hash);
    return hash.value();
}

/// A corridor of one cell's width up and down from its middle, {1, 3}.
GridMap corridor() {
    GridMap map(3, 7);
    for (std::uint16_t y = 0; y < 7; ++y) {
        for (std::uint16_t x = 0; x < 3; ++x) {
            map.set_passable({x, y}, x == 1 && y > 0 && y < 6);
        }
    }
    return map;
}

/// Of `draws` walkers that came along the x axis into the middle of the corridor, how many go up,
/// where `up` marks were made above and `down` below.
int go_up(float reinforcement, int up, int down, int draws) {
    const GridMap map = corridor();
    TrailSettings settings;
    settings.reinforcement = reinforcement;
    PheromoneTrails trails(map, settings);
    for (int k = 0; k < up; ++k) {
        trails.mark(kFood, map.place({1, 2}), 0);
    }
    for (int k = 0; k < down; ++k) {
        trails.mark(kFood, map.place({1, 4}), 0);
    }
    core::Rng rng(7);
    int went = 0;
    for (int k = 0; k < draws; ++k) {
        const unsigned direction = trails.choose(map.place({1, 3}), 0, kFood, true, rng);
        went += direction == 6 ? 1 : 0;
        EXPECT_TRUE(direction == 2 || direction == 6) << direction;
    }
    return went;
}

/// Deneubourg and others: (1 + r a)^2 : (1 + r b)^2 for a and b passages.
TEST(Reinforcement, DrawsWalkersAsTheChoiceFunctionSays) {
    constexpr int kDraws = 20'000;
    constexpr float kOfAnts = 0.05F;
    for (const auto& [up, down] : {std::pair(1, 1), {10, 1}, {1, 10}, {40, 20}, {200, 1}}) {
        const auto weight = [](int passages) {
            return std::pow(1.0 + static_cast<double>(kOfAnts) * passages, 2.0);
        };
        const double share = weight(up) / (weight(up) + weight(down));
        // Four standard deviations of a binomial.
        const double bound = 4.0 * std::sqrt(share * (1.0 - share) * kDraws);
        EXPECT_NEAR(go_up(kOfAnts, up, down, kDraws), share * kDraws, bound) << up << " : " << down;
        EXPECT_NEAR(go_up(0.0F, up, down, kDraws), 0.5 * kDraws, 4.0 * std::sqrt(0.25 * kDraws));
    }
}

/// The share of 60 walkers that take the upper of two equal paths, once they know both.
double share_of_upper(float reinforcement, std::uint64_t seed) {
    const GridMap map = bridge(kEqualBridge);
    AntColonySettings settings;
    settings.seed = seed;
    settings.reinforcement = reinforcement;
    AntColony colony(map, {1, 5}, settings);
    colony.set_food({19, 5}, true);
    colony.add_walkers(60);
    double upper = 0.0;
    double lower = 0.0;
    for (int t = 0; t < 8000; ++t) {
        colony.step();
        for (std::size_t i = 0; t >= 4000 && i < colony.walkers(); ++i) {
            upper += colony.walker_at(i) == map.place({10, 1}) ? 1.0 : 0.0;
            lower += colony.walker_at(i) == map.place({10, 9}) ? 1.0 : 0.0;
        }
    }
    return upper / (upper + lower);
}

/// The bridge of two equal branches in the paper: ants end up on one of them, by chance on either.
/// Where it does not count how many pass, they keep to both. A share of 0.15 scouts goes half and
/// half, so that at most 0.075 of all are on the other branch by their own choice.
TEST(Reinforcement, LetsAColonySettleForOneOfTwoEqualBranches) {
    int upper = 0;
    constexpr int kSeeds = 16;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const double with = share_of_upper(0.05F, seed);
        EXPECT_GT(std::max(with, 1.0 - with), 0.8) << seed;
        upper += with > 0.5 ? 1 : 0;
        EXPECT_NEAR(share_of_upper(0.0F, seed), 0.5, 0.1) << seed;
    }
    // All on one side by chance: once in 32,768.
    EXPECT_GT(upper, 0);
    EXPECT_LT(upper, kSeeds);
}

/// Ten walkers leave ten times what one leaves, of which each time the same share evaporates.
TEST(Reinforcement, AddsUpAndEvaporates) {
    const GridMap map = bridge();
    TrailSettings settings;
    settings.reinforcement = 0.05F;
    PheromoneTrails trails(map, settings);
    const pathfinding::Place at = map.place(kShortMiddle);
    for (int k = 0; k < 10; ++k) {
        trails.mark(kHome, at, 0);
    }
    EXPECT_EQ(trails.passages(at), 10.0F);
    EXPECT_EQ(trails.scent(kHome, at), 1.0F);
    double left = 10.0;
    for (int k = 0; k < 100; ++k) {
        trails.evaporate();
        left *= 1.0 - static_cast<double>(settings.evaporation);
    }
    // A hundred roundings of a number below 10.
    EXPECT_NEAR(trails.passages(at), left, 100 * 10.0 * std::numeric_limits<float>::epsilon());
    for (int k = 0; k < 10'000; ++k) {
        trails.evaporate();
    }
    EXPECT_EQ(trails.passages(at), 0.0F);
    EXPECT_EQ(hash_of(trails), hash_of(PheromoneTrails(map, settings))) << "a bare map again";
}

}  // namespace

/// The hash follows every change of a scent. It is the same in any order of marks and after the
/// scents were saved and loaded, and it differs when two cells exchange their scents.
TEST(PheromoneTrails, HashesWhatTheyAreAndNotHowTheyBecameSo) {
    const GridMap map = bridge();
    PheromoneTrails one(map, TrailSettings{});
    PheromoneTrails other(map, TrailSettings{});
    const pathfinding::Place places[] = {map.place({2, 2}), map.place({10, 2}), map.place({10, 9})};
    std::uint64_t before = hash_of(one);
    for (std::uint32_t k = 0; k < 60; ++k) {
        one.mark(k % 2 == 0 ? kHome : kFood, places[k % 3], 60 - k);
        EXPECT_NE(hash_of(one), before) << k;
        before = hash_of(one);
        if (k % 10 == 9) {
            one.evaporate();
            EXPECT_NE(hash_of(one), before) << k;
            before = hash_of(one);
        }
    }
    one.for_each_scent([&](const ScentCell& cell) { ASSERT_TRUE(other.put_scent(cell)); });
    EXPECT_EQ(hash_of(other), hash_of(one));
    ASSERT_TRUE(
        other.put_scent({places[0], one.scent(kFood, places[0]), one.scent(kHome, places[0])}));
    EXPECT_NE(hash_of(other), hash_of(one));
    PheromoneTrails forwards(map, TrailSettings{});
    PheromoneTrails backwards(map, TrailSettings{});
    for (std::uint32_t k = 0; k < 3; ++k) {
        forwards.mark(kHome, places[k], k);
        backwards.mark(kHome, places[2 - k], 2 - k);
    }
    EXPECT_EQ(hash_of(forwards), hash_of(backwards));
    backwards.mark(kHome, places[1], 2);  // weaker than the present mark
    EXPECT_EQ(hash_of(forwards), hash_of(backwards));
}

}  // namespace zoned::ai::pathfinding
