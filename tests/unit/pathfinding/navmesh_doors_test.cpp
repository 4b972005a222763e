// Navmesh doors: a navmesh whose doors turn equals the navmesh of the world as it is.
#include "server/ai/pathfinding/navmesh/navmesh_paths.h"
#include "tests/unit/pathfinding/walkers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

constexpr GroundRect kMaze{-15.0F, -15.0F, 15.0F, 15.0F};
const motion::CharacterLimits kMazeWalker;

motion::Door door_of(const motion::StaticBox& box) {
    motion::Door door;
    door.box = box;
    door.times.period = 1000;
    door.times.open = {{1, 2}};
    return door;
}

Navmesh baked(const motion::StaticGeometry& world) {
    auto mesh = Navmesh::bake(world, kMazeWalker, kMaze);
    EXPECT_TRUE(mesh.ok());
    return std::move(mesh).value();
}

/// Nine rooms, with a doorway of 2.4 m somewhere in each wall between two, most with a door.
motion::StaticGeometry maze(core::Rng& rng) {
    std::vector<motion::StaticBox> walls;
    std::vector<motion::Door> doors;
    for (int axis = 0; axis < 2; ++axis) {
        for (int line = 0; line < 2; ++line) {
            for (int room = 0; room < 3; ++room) {
                const float at = -5.0F + 10.0F * static_cast<float>(line);
                const float begin = -15.0F + 10.0F * static_cast<float>(room);
                const float gap = begin + rng.range(2.5F, 7.5F);
                const auto box = [&](float from, float to, float half_wide) {
                    const float middle = 0.5F * (from + to);
                    const float half = 0.5F * (to - from);
                    return axis == 0
                               ? static_box(Vec3(at, 1.5F, middle), Vec3(half_wide, 1.5F, half))
                               : static_box(Vec3(middle, 1.5F, at), Vec3(half, 1.5F, half_wide));
                };
                walls.push_back(box(begin, gap - 1.2F, 0.2F));
                walls.push_back(box(gap + 1.2F, begin + 10.0F, 0.2F));
                if (rng.below(5) != 0) {
                    doors.push_back(door_of(box(gap - 1.2F, gap + 1.2F, 0.15F)));
                }
            }
        }
    }
    return {walls, 0.0F, motion::kStaticCell_m, {}, doors};
}

TEST(NavmeshDoors, AnswerRightAfterAChangeAsAMeshOfTheWorldAsItIs) {
    core::Rng rng(17);
    int compared = 0;
    int out_of_date = 0;
    double ratio = 0.0;
    int found = 0;
    for (int world = 0; world < 4; ++world) {
        const motion::StaticGeometry rooms = maze(rng);
        const std::size_t doors = rooms.doors().size();
        std::vector<std::uint8_t> shut(doors, 0);
        NavmeshPaths paths(baked(rooms), kMaze, shut);
        for (int change = 0; change < 8; ++change) {
            NavmeshPaths before(paths.mesh(), kMaze, shut);
            std::vector<std::uint32_t> closed;
            for (std::uint32_t d = 0; d < doors; ++d) {
                shut[d] = rng.below(3) != 0 ? 1 : 0;
                if (shut[d] != 0) {
                    closed.push_back(d);
                }
            }
            paths.turn_doors(shut);
            NavmeshPaths anew(baked(rooms.with_shut(closed)), kMaze, {});
            for (int i = 0; i < 40; ++i) {
                const auto middle = [&rng] {
                    // In the middle of a room, away from doors.
                    const auto room = [&rng] {
                        return -10.0F + 10.0F * static_cast<float>(rng.below(3)) +
                               rng.range(-2.0F, 2.0F);
                    };
                    const float x = room();
                    return Spot{x, room()};
                };
                const Spot from = middle();
                const PathRequest ask{0, from, middle()};
                const auto answer_of = [&ask](NavmeshPaths& map) {
                    const PathRequestId t = map.ask(ask);
                    map.serve();
                    const PathResult a = map.answer(t);
                    map.release(t);
                    return std::pair(a.outcome, a.length_m);
                };
                const auto [outcome, length] = answer_of(paths);
                const auto [wanted, best] = answer_of(anew);
                ASSERT_EQ(outcome, wanted) << world << " " << change << " " << i;
                out_of_date += answer_of(before).first != wanted ? 1 : 0;
                ++compared;
                if (outcome == PathOutcome::kFound && best > 1.0F) {
                    ratio += static_cast<double>(length) / static_cast<double>(best);
                    ++found;
                }
            }
        }
    }
    EXPECT_EQ(compared, 4 * 8 * 40);
    EXPECT_GT(out_of_date, compared / 10) << "who does not follow the doors is found out";
    // Contours of doorways are others, by 1.3 cells at most, and so are the middles of edges by
    // which corridors are chosen: no more than 2 % on average.
    EXPECT_NEAR(ratio / found, 1.0, 0.02);
}

TEST(NavmeshDoors, MayBeBridgesThatAreThereWhileShut) {
    // Two platforms 1 m high and a ditch of 4 m between them; no agent can climb out of it.
    const motion::StaticGeometry world(
        {static_box(Vec3(-8.5F, 0.5F, 0.0F), Vec3(6.5F, 0.5F, 15.0F)),
         static_box(Vec3(8.5F, 0.5F, 0.0F), Vec3(6.5F, 0.5F, 15.0F))},
        0.0F,
        motion::kStaticCell_m,
        {},
        {door_of(static_box(Vec3(0.0F, 0.9F, 3.0F), Vec3(2.2F, 0.1F, 1.5F)))});
    NavmeshPaths paths(baked(world), kMaze, std::vector<std::uint8_t>{0});
    const PathRequestId t = paths.ask({0, {-8.0F, -5.0F}, {8.0F, -5.0F}, 1.0F, 1.0F});
    paths.serve();
    EXPECT_EQ(paths.answer(t).outcome, PathOutcome::kPartial);
    paths.turn_doors(std::vector<std::uint8_t>{1});
    EXPECT_EQ(paths.requeued().size(), 1U);
    paths.serve();
    ASSERT_EQ(paths.answer(t).outcome, PathOutcome::kFound);
    bool over = false;
    for (const Spot& c : paths.answer(t).corners) {
        over = over || (std::abs(c.x) < 3.0F && std::abs(c.z - 3.0F) < 1.5F);
    }
    EXPECT_TRUE(over);
    paths.turn_doors(std::vector<std::uint8_t>{0});
    EXPECT_EQ(paths.counts().broken, 1U);
    paths.serve();
    EXPECT_EQ(paths.answer(t).outcome, PathOutcome::kPartial);
}

TEST(NavmeshDoors, CutOnlyWhatIsStillAhead) {
    const motion::StaticGeometry world(
        {static_box(Vec3(0.0F, 1.5F, -8.0F), Vec3(0.2F, 1.5F, 7.0F)),
         static_box(Vec3(0.0F, 1.5F, 8.0F), Vec3(0.2F, 1.5F, 7.0F)),
         static_box(Vec3(6.0F, 1.5F, 4.0F), Vec3(0.2F, 1.5F, 11.0F))},
        0.0F,
        motion::kStaticCell_m,
        {},
        {door_of(static_box(Vec3(0.0F, 1.5F, 0.0F), Vec3(0.2F, 1.5F, 1.0F)))});
    NavmeshPaths paths(baked(world), kMaze, std::vector<std::uint8_t>{0});
    const PathRequestId t = paths.ask({0, {-5.0F, 5.0F}, {12.0F, 5.0F}});
    paths.serve();
    ASSERT_EQ(paths.answer(t).outcome, PathOutcome::kFound);
    // Through the door, and on to the corner behind it.
    const std::vector<Spot> corners(paths.answer(t).corners.begin(), paths.answer(t).corners.end());
    for (const Spot& c : corners) {
        if (c.x < 4.0F) {
            paths.heading(t, c, 0.3F);
        }
    }
    paths.turn_doors(std::vector<std::uint8_t>{1});
    EXPECT_TRUE(paths.requeued().empty());
    EXPECT_EQ(paths.counts().broken, 0U);
}

TEST(NavmeshDoors, TellFloorsApart) {
    // A platform at 3 m, and a ramp to it from the left.
    const float slope = std::asin(0.45F);
    const float length = 3.0F / 0.45F;
    const motion::StaticGeometry world(
        {static_box(Vec3(5.0F, 2.9F, 0.0F), Vec3(4.9F, 0.1F, 4.0F)),
         static_box(Vec3(-0.5F * length * std::cos(slope) + 0.1F * std::sin(slope) + 0.1F,
                         1.5F - 0.1F * std::cos(slope),
                         0.0F),
                    Vec3(0.5F * length, 0.1F, 2.0F),
                    slope * 180.0F / 3.14159265F,
                    Vec3::UnitZ())},
        0.0F);
    NavmeshPaths paths(baked(world), kMaze, {});
    const Spot here{6.0F, 0.0F};
    EXPECT_TRUE(paths.straight({6.0F, -6.0F}, 0.0F, {6.0F, 6.0F}, 0.0F)) << "under the platform";
    EXPECT_FALSE(paths.straight({6.0F, -6.0F}, 0.0F, here, 3.0F)) << "it is above";
    EXPECT_TRUE(paths.straight({3.0F, 0.0F}, 3.0F, here, 3.0F));
    const PathRequestId below = paths.ask({0, {-12.0F, 0.0F}, here, 0.0F, 0.0F});
    const PathRequestId above = paths.ask({1, {-12.0F, 0.0F}, here, 0.0F, 3.0F});
    const PathRequestId ground = paths.ask({2, {-12.0F, 0.0F}, here});
    const PathRequestId up = paths.ask({3, here, here, 0.0F, 3.0F});
    paths.serve();
    for (const PathRequestId t : {below, above, ground, up}) {
        EXPECT_EQ(paths.answer(t).outcome, PathOutcome::kFound);
    }
    // Up the ramp straight ahead; on the ground round it, since the ramp blocks the straight line.
    EXPECT_NEAR(paths.answer(above).length_m, 18.0F, 0.5F);
    EXPECT_GT(paths.answer(below).length_m, 18.3F);
    EXPECT_FLOAT_EQ(paths.answer(ground).length_m, paths.answer(below).length_m);
    // Out from under the platform, round to the foot of the ramp, and back: 2 x 12 m at least.
    EXPECT_GT(paths.answer(up).length_m, 24.0F);
}

TEST(NavmeshPaths, LeaveTheZoneWhereThatIsSoonest) {
    // A wall along the east side, with a gap from z = 8 to z = 12.
    const motion::StaticGeometry world(
        {static_box(Vec3(14.0F, 1.5F, -4.0F), Vec3(0.2F, 1.5F, 12.0F)),
         static_box(Vec3(14.0F, 1.5F, 14.0F), Vec3(0.2F, 1.5F, 2.0F))},
        0.0F);
    NavmeshPaths paths(baked(world), kMaze, {});
    EXPECT_FALSE(paths.contains({60.0F, 0.0F}));
    const MapExit east = paths.straight_exit({0.0F, 0.0F}, 0.0F, {60.0F, 0.0F});
    EXPECT_GT(east.at.x, 13.0F);
    const PathRequestId t = paths.ask({0, {0.0F, 0.0F}, east.at, 0.0F, east.y});
    paths.serve();
    EXPECT_EQ(paths.answer(t).outcome, PathOutcome::kFound);
    const MapExit west = paths.straight_exit({0.0F, 5.0F}, 0.0F, {-60.0F, 5.0F});
    EXPECT_NEAR(west.at.z, 5.0F, 0.1F);
    EXPECT_LT(west.at.x, -13.0F);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
