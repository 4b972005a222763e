// Door cells: which cells of a ground map each door takes away while it is shut, or gives.
#pragma once

#include "server/ai/pathfinding/grid/ground_map.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// What a map with a door shut has other than one with all doors open.
struct DoorCells {
    std::vector<Cell> taken;  ///< passable only while it is open
    std::vector<Cell> given;  ///< only while it is shut: a bridge
};

/// One for each of world.doors(), by what bake_ground() says of the world with the door shut, near
/// the door; `open` is what it says of `area` with none shut. Doors that are far from each other
/// are baked at once, so that a bake more is made than doors are near any one of them. Islands far
/// from a door that would be ground no more because the door parts them remain ground: nobody gets
/// there.
std::vector<DoorCells> bake_doors(const motion::StaticGeometry& world,
                                  const motion::CharacterLimits& limits,
                                  const GroundRect& area,
                                  float cell_m,
                                  const GroundMap& open);

/// How far from a door the ground may be another because of it, m.
float door_reach(const motion::CharacterLimits& limits, float cell_m);

/// Bounds of a door's box, so much larger to all sides.
Aabb grown_door(const motion::StaticGeometry& world, std::uint32_t door, float reach);

/// Doors in groups of which no two are near each other, each ascending: every door goes into the
/// first group that has room for it.
std::vector<std::vector<std::uint32_t>> doors_apart(const motion::StaticGeometry& world,
                                                    float reach);

/// The map as doors shut and open. Where several doors take a cell, it is passable while all of
/// them are open; where several give one, while any of them is shut; where doors give what others
/// take, taking counts.
class DoorMap {
  public:
    DoorMap() = default;

    explicit DoorMap(std::vector<DoorCells> doors, const GridMap& open);

    /// Appends the cells that are other than before to `changes`; nothing where the door is so
    /// already.
    void turn(std::uint32_t door, bool shut, std::vector<CellChange>& changes);

    /// Opens all cells that hang on doors.
    void open_all(GridMap& map) const;

    [[nodiscard]] bool shut(std::uint32_t door) const { return shut_[door]; }

    [[nodiscard]] std::size_t doors() const { return doors_.size(); }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// A cell that hangs on doors.
    struct Ground {
        Cell cell;
        bool open = false;         ///< as with no door shut
        std::uint16_t takers = 0;  ///< shut now
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
