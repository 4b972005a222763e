// GroundGrid: the position of a grid map's cells on the ground of a zone.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"

#include <string>

namespace zoned::ai::pathfinding {

/// A place on the ground, zone-local, m.
struct Spot {
    float x = 0.0F;
    float z = 0.0F;

    friend bool operator==(const Spot&, const Spot&) = default;
};

/// A rectangle of the ground, m.
struct GroundRect {
    float min_x = 0.0F;
    float min_z = 0.0F;
    float max_x = 0.0F;
    float max_z = 0.0F;
};

/// Columns along x and rows along z, from the corner of least x and z. A rest of less than a cell
/// along the other sides belongs to no cell.
class GroundGrid {
  public:
    /// Empty, or the reason why no such grid is possible. Sides and cells must have a size, with at
    /// most GridMap::kMaxSide cells to a side and kMostPassable in all.
    static std::string defect_of(const GroundRect& area, float cell_m);

    /// defect_of() must be empty.
    GroundGrid(const GroundRect& area, float cell_m);

    [[nodiscard]] int width() const { return width_; }

    [[nodiscard]] int height() const { return height_; }

    [[nodiscard]] float cell_m() const { return cell_m_; }

    [[nodiscard]] float min_x() const { return min_x_; }

    [[nodiscard]] float min_z() const { return min_z_; }

    /// True if a cell contains the place. False for a place that is not a number.
    [[nodiscard]] bool contains(Spot s) const;

    /// The cell that contains the place. For a place beside the grid it is the nearest cell; for
    /// one that is not a number it is the first.
    [[nodiscard]] Cell cell(Spot s) const;

    [[nodiscard]] Spot centre(Cell c) const {
        return {min_x_ + (static_cast<float>(c.x) + 0.5F) * cell_m_,
                min_z_ + (static_cast<float>(c.y) + 0.5F) * cell_m_};
    }

  private:
    float min_x_;
    float min_z_;
    float cell_m_;
    int width_;
    int height_;
};

/// Finds the passable cell whose centre is nearest to the place, ties to the smaller row, then
/// column; nothing within `reach` cells. The cost grows with the square of its distance.
bool nearest_passable(const GridMap& map, const GroundGrid& grid, Spot s, int reach, Cell& found);

}  // namespace zoned::ai::pathfinding
