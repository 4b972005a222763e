#include "server/ai/pathfinding/grid/door_cells.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/unit/pathfinding/walkers.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::ai::pathfinding {

namespace {

constexpr GroundRect kYard{-16.0F, -16.0F, 16.0F, 16.0F};
constexpr float kYardCell_m = 0.5F;
const motion::CharacterLimits kVisitor;

motion::Door yard_door(const Vec3& centre, const Vec3& half, float turn = 0.0F) {
    motion::Door door;
    door.box.centre = centre;
    door.box.half_extents = half;
    door.box.orientation = Quat(Eigen::AngleAxisf(turn, Vec3::UnitY()));
    door.times.period = 10;
    door.times.open = {{0, 5}};
    return door;
}

/// Cells of the yard that a map with these doors shut has other than the bake of that world.
std::size_t yard_differences(const motion::StaticGeometry& world,
                             const GroundMap& open,
                             DoorMap& doors,
                             GridMap& map,
                             const std::vector<bool>& shut) {
    std::vector<CellChange> changes;
    std::vector<std::uint32_t> closed;
    for (std::uint32_t d = 0; d < shut.size(); ++d) {
        doors.turn(d, shut[d], changes);
        if (shut[d]) {
            closed.push_back(d);
        }
    }
    for (const CellChange& c : changes) {
        EXPECT_NE(map.passable(c.cell), c.passable) << "only what changes is told";
        map.set_passable(c.cell, c.passable);
    }
    const GroundMap baked = bake_ground(world.with_shut(closed), kVisitor, kYard, kYardCell_m);
    std::size_t off = 0;
    for (Place p = 0; p < map.places(); ++p) {
        off += map.passable(p) != baked.cells.passable(p) ? 1U : 0U;
    }
    EXPECT_EQ(open.cells.places(), baked.cells.places());
    return off;
}

TEST(DoorCells, MakeTheMapThatABakeOfTheWorldSoShutMakes) {
    // A yard in four parts, with doors between them that are far apart, one turned, and a bridge
    // over a pit of walls.
    std::vector<motion::StaticBox> walls(5);
    walls[0].centre = Vec3(-9.0F, 1.0F, 0.0F);
    walls[0].half_extents = Vec3(7.0F, 2.0F, 0.2F);
    walls[1].centre = Vec3(7.0F, 1.0F, 0.0F);
    walls[1].half_extents = Vec3(7.0F, 2.0F, 0.2F);
    walls[2].centre = Vec3(0.0F, 1.0F, -10.0F);
    walls[2].half_extents = Vec3(0.2F, 2.0F, 6.0F);
    walls[3].centre = Vec3(0.0F, 1.0F, 4.0F);
    walls[3].half_extents = Vec3(0.2F, 2.0F, 4.0F);
    walls[4].centre = Vec3(0.0F, 1.0F, 13.0F);
    walls[4].half_extents = Vec3(0.2F, 2.0F, 3.0F);
    std::vector<motion::Door> doors;
    doors.push_back(yard_door(Vec3(-1.0F, 1.0F, 0.0F), Vec3(1.0F, 2.0F, 0.15F)));
    doors.push_back(yard_door(Vec3(15.0F, 1.0F, 0.0F), Vec3(1.0F, 2.0F, 0.15F), 0.3F));
    doors.push_back(yard_door(Vec3(0.0F, 1.0F, 9.0F), Vec3(0.1F, 2.0F, 1.0F)));
    const motion::StaticGeometry world(walls, 0.0F, motion::kStaticCell_m, {}, doors);
    const GroundMap open = bake_ground(world, kVisitor, kYard, kYardCell_m);
    DoorMap map(bake_doors(world, kVisitor, kYard, kYardCell_m, open), open.cells);
    GridMap cells = open.cells;
    core::Rng rng(5, 1);
    for (int round = 0; round < 24; ++round) {
        const std::uint32_t bits = round < 8 ? static_cast<std::uint32_t>(round) : rng.below(8);
        const std::vector<bool> shut{(bits & 1U) != 0, (bits & 2U) != 0, (bits & 4U) != 0};
        EXPECT_EQ(yard_differences(world, open, map, cells, shut), 0U) << bits;
    }
}

TEST(DoorCells, OfABridgeAreThereWhileItIsShut) {
    // Two banks two metres up with a gap between them, and ramps to neither. The bank is the
    // largest part of the ground; walls along its ends cut off the gap's floor.
    std::vector<motion::StaticBox> banks(2);
    banks[0].centre = Vec3(-9.5F, 1.0F, 0.0F);
    banks[0].half_extents = Vec3(6.5F, 1.0F, 16.0F);
    banks[1].centre = Vec3(9.5F, 1.0F, 0.0F);
    banks[1].half_extents = Vec3(6.5F, 1.0F, 16.0F);
    const motion::Door bridge = yard_door(Vec3(0.0F, 1.9F, 0.0F), Vec3(3.2F, 0.1F, 2.0F));
    const motion::StaticGeometry world(banks, 0.0F, motion::kStaticCell_m, {}, {bridge});
    const GroundMap open = bake_ground(world, kVisitor, kYard, kYardCell_m);
    const auto cells = bake_doors(world, kVisitor, kYard, kYardCell_m, open);
    DoorMap map(cells, open.cells);
    std::vector<CellChange> changes;
    map.turn(0, true, changes);
    GridMap shut = open.cells;
    for (const CellChange& c : changes) {
        shut.set_passable(c.cell, c.passable);
    }
    GridPlanner before(open.cells);
    GridPlanner after(shut);
    GridQuery q;
    q.start = open.grid.cell({-8.0F, 0.0F});
    q.goal = open.grid.cell({8.0F, 0.0F});
    EXPECT_EQ(before.plan(q).outcome, PathOutcome::kUnreachable);
    EXPECT_EQ(after.plan(q).outcome, PathOutcome::kFound);
}

TEST(DoorCells, OfDoorsBesideEachOtherAddUp) {
    // Both leaves of a gate, four metres wide, and a wall around them.
    std::vector<motion::StaticBox> walls(2);
    walls[0].centre = Vec3(-9.0F, 1.0F, 0.0F);
    walls[0].half_extents = Vec3(7.0F, 2.0F, 0.2F);
    walls[1].centre = Vec3(9.0F, 1.0F, 0.0F);
    walls[1].half_extents = Vec3(7.0F, 2.0F, 0.2F);
    const std::vector<motion::Door> leaves{
        yard_door(Vec3(-1.0F, 1.0F, 0.0F), Vec3(1.0F, 2.0F, 0.1F)),
        yard_door(Vec3(1.0F, 1.0F, 0.0F), Vec3(1.0F, 2.0F, 0.1F))};
    const motion::StaticGeometry world(walls, 0.0F, motion::kStaticCell_m, {}, leaves);
    const GroundMap open = bake_ground(world, kVisitor, kYard, kYardCell_m);
    DoorMap map(bake_doors(world, kVisitor, kYard, kYardCell_m, open), open.cells);
    GridMap cells = open.cells;
    for (const unsigned bits : {1U, 3U, 2U, 3U, 0U}) {
        EXPECT_EQ(yard_differences(world, open, map, cells, {(bits & 1U) != 0, (bits & 2U) != 0}),
                  0U)
            << bits;
    }
}

}  // namespace

}  // namespace zoned::ai::pathfinding
