// Door cells: the cells of a ground map that each door takes away or gives while it is shut.
#pragma once

#include "server/ai/pathfinding/grid/ground_map.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// DoorCells: the difference between the maps with a door shut and with all doors open.
struct DoorCells {
    std::vector<Cell> taken;  ///< passable only while it is open
    std::vector<Cell> given;  ///< only while it is shut: a bridge
};

/// Returns the cells of each of world.doors(). They come from bake_ground() with the door shut,
/// near the door. `open` is its result for `area` with no door shut. Doors that are far apart are
/// baked together. So the number of bakes is one more than the most doors near any one door. An
/// island far from a door remains ground even if the shut door cuts it off, because nobody gets
/// there.
std::vector<DoorCells> bake_doors(const motion::StaticGeometry& world,
                                  const motion::CharacterLimits& limits,
                                  const GroundRect& area,
                                  float cell_m,
                                  const GroundMap& open);

/// The distance from a door within which it may change the ground, m.
float door_reach(const motion::CharacterLimits& limits, float cell_m);

/// The bounds of a door's box, grown on all sides by door_reach().
Aabb grown_door(const motion::StaticGeometry& world, std::uint32_t door, float reach);

/// Doors in groups within which no two are near each other, each ascending. Every door goes into
/// the first group that has room for it.
std::vector<std::vector<std::uint32_t>> doors_apart(const motion::StaticGeometry& world,
                                                    float reach);

/// The map as doors shut and open. A cell that several doors take is passable while all of them are
/// open. A cell that several doors give is passable while any of them is shut. Where a cell is both
/// given and taken, taking counts.
class DoorMap {
  public:
    DoorMap() = default;

    explicit DoorMap(std::vector<DoorCells> doors, const GridMap& open);

    /// Appends the cells that changed to `changes`; nothing where the door already is so.
    void turn(std::uint32_t door, bool shut, std::vector<CellChange>& changes);

    /// Opens all cells that depend on doors.
    void open_all(GridMap& map) const;

    [[nodiscard]] bool shut(std::uint32_t door) const { return shut_[door]; }

    [[nodiscard]] std::size_t doors() const { return doors_.size(); }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// Ground: a cell that depends on doors.
    struct Ground {
        Cell cell;
        bool open = false;         ///< as with no door shut
        std::uint16_t takers = 0;  ///< number of shut doors that take it
        std::uint16_t givers = 0;

        [[nodiscard]] bool passable() const { return takers == 0 && (open || givers > 0); }
    };

    struct Turned {
        std::vector<std::uint32_t> taken;  // of ground_
        std::vector<std::uint32_t> given;
    };

    std::vector<Ground> ground_;
    std::vector<Turned> doors_;
    std::vector<bool> shut_;
};

}  // namespace zoned::ai::pathfinding
