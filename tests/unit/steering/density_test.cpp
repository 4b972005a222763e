#include "server/ai/pathfinding/flow_fields/density.h"

#include "server/ai/crowd/orca_avoidance.h"
#include "server/ai/pathfinding/flow_fields/crowd_flow_field.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "tests/unit/steering/crowd_scene.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace zoned::ai::steering {

using namespace pathfinding;

namespace {

using pathfinding::Cell;
using pathfinding::GridMap;
using pathfinding::Place;

TEST(CrowdFlowField, IsAGoalFieldWhereNobodyIs) {
    const GridMap map = pathfinding::random_map(50, 40, 0.25F, 3);
    const std::vector<Crowding> nobody(map.places(), 0);
    Cell goal{0, 0};
    while (!map.passable(goal)) {
        ++goal.x;
    }
    CrowdFlowField crowded;
    crowded.build(map, nobody, goal);
    pathfinding::FlowField plain;
    plain.build(map, goal);
    for (Place p = 0; p < map.places(); ++p) {
        if (plain.cost(p) == pathfinding::kNoCost) {
            ASSERT_EQ(crowded.cost(p), CrowdFlowField::kNoPath);
        } else {
            ASSERT_EQ(crowded.cost(p), CrowdFlowField::Cost{plain.cost(p)} * 2 * kPerStep);
        }
    }
}

/// Hops lead to the goal at the stated cost; after changes both equal those built anew.
TEST(CrowdFlowField, IsAfterEachChangeAsIfItWereBuiltAnew) {
    core::Rng rng(4);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        GridMap map = pathfinding::random_map(30, 25, 0.05F * static_cast<float>(seed % 6), seed);
        std::vector<Crowding> crowding(map.places(), 0);
        const Cell goal{15, 12};
        map.set_passable(goal, true);
        CrowdFlowField kept;
        kept.build(map, crowding, goal);
        CrowdFlowField anew;
        for (int round = 0; round < 60; ++round) {
            std::vector<Place> changed;
            for (std::uint32_t i = 0; i <= rng.below(6); ++i) {
                const Cell c{static_cast<std::uint16_t>(rng.below(30)),
                             static_cast<std::uint16_t>(rng.below(25))};
                if (rng.below(3) == 0) {
                    map.set_passable(c, !map.passable(c));
                } else {
                    // Few values in every other map, so that many ways are equally good.
                    crowding[map.place(c)] =
                        static_cast<Crowding>(seed % 2 == 0 ? 16 * rng.below(3) : rng.below(300));
                }
                changed.push_back(map.place(c));
            }
            kept.update(map, crowding, changed);
            anew.build(map, crowding, goal);
            for (Place p = 0; p < map.places(); ++p) {
                ASSERT_EQ(kept.cost(p), anew.cost(p)) << "seed " << seed << " round " << round;
                ASSERT_EQ(kept.hop(p), anew.hop(p)) << "seed " << seed << " round " << round;
                if (kept.cost(p) == CrowdFlowField::kNoPath || map.place(goal) == p) {
                    continue;
                }
                const Place q = map.place(pathfinding::hopped(map.cell(p), kept.hop(p)));
                const bool diagonal = kept.hop(p) >= 4;
                ASSERT_EQ(kept.cost(p) - kept.cost(q),
                          CrowdFlowField::Cost{diagonal ? pathfinding::kDiagonal
                                                        : pathfinding::kStraight} *
                              (2U * kPerStep + crowding[p] + crowding[q]));
            }
        }
    }
}

TEST(CrowdFlowField, LooksAtFewCellsWhereFewChange) {
    const GridMap map = pathfinding::random_map(200, 200, 0.1F, 9);
    std::vector<Crowding> crowding(map.places(), 0);
    CrowdFlowField field;
    Cell goal{0, 0};
    while (!map.passable(goal)) {
        ++goal.x;
    }
    field.build(map, crowding, goal);
    const std::size_t all = field.work();
    // Far from the goal hardly any path leads through a cell.
    const Place changed[] = {map.place({190, 190})};
    crowding[changed[0]] = 100;
    field.update(map, crowding, changed);
    EXPECT_LT(field.work() * 50, all);
    const std::uint64_t before = allocation_count();
    crowding[changed[0]] = 0;
    field.update(map, crowding, changed);
    EXPECT_EQ(allocation_count() - before, 0U);
}

GridMap open_map(int width, int height) {
    GridMap map(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            map.set_passable({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)}, true);
        }
    }
    return map;
}

TEST(Density, FollowsFromWhoIsThere) {
    const GridMap map = open_map(4, 4);
    DensitySettings settings;
    settings.cell_m = 2.0F;
    settings.x0 = -4.0F;
    settings.remember = 0.0F;
    Density density(map, settings);
    CrowdAgents agents;
    for (std::uint32_t i = 0; i < 9; ++i) {
        agents.add(i, -1.0F, 3.0F, 0.25F, 1.0F);
    }
    agents.add(9, 100.0F, 3.0F, 0.25F, 1.0F);  // off the map
    density.look(agents);
    const Place p = map.place({1, 1});
    EXPECT_FLOAT_EQ(density.of(p), 9.0F / 4.0F);
    // Half the density of a jam: half the speed, twice the time.
    EXPECT_EQ(density.crowding()[p], kPerStep);
    EXPECT_THAT(density.changed(), testing::ElementsAre(p));
    density.look(agents);
    EXPECT_TRUE(density.changed().empty());
    density.look(CrowdAgents());
    EXPECT_EQ(density.crowding()[p], 0);
    EXPECT_THAT(density.changed(), testing::ElementsAre(p));
}

TEST(Density, RemembersAsLongAsItIsTold) {
    const GridMap map = open_map(2, 2);
    DensitySettings settings;
    settings.remember = 0.5F;
    Density density(map, settings);
    CrowdAgents agents;
    agents.add(1, 0.5F, 0.5F, 0.25F, 1.0F);
    const float by_hand[] = {0.5F, 0.75F, 0.875F};
    for (const float d : by_hand) {
        density.look(agents);
        EXPECT_FLOAT_EQ(density.of(map.place({0, 0})), d);
    }
}

/// A crowd near one of two doors in a wall, 12 m apart.
class TwoDoors {
  public:
    TwoDoors() {
        for (std::uint16_t y = 0; y < 20; ++y) {
            map.set_passable({12, y}, y == 4 || y == 16);
        }
        scene.walls = {{12, 0, 12, 4},
                       {13, 0, 13, 4},
                       {12, 5, 12, 16},
                       {13, 5, 13, 16},
                       {12, 17, 12, 20},
                       {13, 17, 13, 20},
                       {12, 4, 13, 4},
                       {12, 5, 13, 5},
                       {12, 16, 13, 16},
                       {12, 17, 13, 17},
                       {0, 0, 25, 0},
                       {0, 20, 25, 20},
                       {0, 0, 0, 20}};
        for (std::uint32_t i = 0; i < 120; ++i) {
            scene.agents.add(i,
                             2.0F + 0.75F * static_cast<float>(i % 12),
                             1.0F + 0.75F * static_cast<float>(i / 12),
                             0.2F,
                             2.0F);
        }
    }

    /// Steps until all are through, at most 6,000.
    int run(bool aware) {
        const Walls walls = Walls::make(scene.walls, 3.0F).value();
        Density density(map, {});
        CrowdFlowField field;
        field.build(map, density.crowding(), {24, 4});
        OrcaAvoidance avoidance({});
        compute::Team alone;
        CrowdAgents& a = scene.agents;
        for (int step = 0; step < 6000; ++step) {
            if (step % 10 == 0 && aware) {
                density.look(a);
                field.update(map, density.crowding(), density.changed());
            }
            for (std::size_t i = a.size(); i-- > 0;) {
                if (a.x[i] > 14.0F) {
                    ++(a.z[i] < 10.0F ? by_near : by_far);
                    a.remove(i);
                } else {
                    aim(density, field, i);
                }
            }
            if (a.size() == 0) {
                return step;
            }
            avoidance.step(a, walls, static_cast<std::uint64_t>(step), alone);
        }
        return 6000;
    }

    int by_near = 0;
    int by_far = 0;

  private:
    void aim(const Density& density, const CrowdFlowField& field, std::size_t i) {
        CrowdAgents& a = scene.agents;
        const Place p = density.place_of(a.x[i], a.z[i]);
        const Cell next = pathfinding::hopped(map.cell(p), field.hop(p));
        const float dx = static_cast<float>(next.x) + 0.5F - a.x[i];
        const float dz = static_cast<float>(next.y) + 0.5F - a.z[i];
        const float d = std::max(1e-3F, std::hypot(dx, dz));
        a.want_x[i] = 1.3F * dx / d;
        a.want_z[i] = 1.3F * dz / d;
        a.path_left[i] = static_cast<float>(field.cost(p)) /
                         static_cast<float>(pathfinding::kStraight * 2 * kPerStep);
    }

    GridMap map = open_map(25, 20);
    CrowdScene scene;
};

TEST(Density, SpreadsACrowdOverTwoDoorsSoThatItClearsSooner) {
    TwoDoors blind;
    const int without = blind.run(false);
    EXPECT_LT(without, 6000);
    EXPECT_EQ(blind.by_far, 0) << "all take the nearer door";
    TwoDoors seeing;
    const int with = seeing.run(true);
    EXPECT_GT(seeing.by_far, 24) << "a fifth and more of 120";
    EXPECT_GT(seeing.by_near, 24);
    EXPECT_LT(with, without * 4 / 5);
}

}  // namespace

}  // namespace zoned::ai::steering
