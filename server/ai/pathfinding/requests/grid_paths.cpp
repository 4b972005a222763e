#include "server/ai/pathfinding/requests/grid_paths.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

float spots_apart(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

}  // namespace

GridPaths::Baked GridPaths::bake(const motion::StaticGeometry& statics,
                                 const motion::CharacterLimits& limits,
                                 const GroundRect& area,
                                 float cell_m,
                                 std::span<const std::uint8_t> shut) {
    Baked baked{nullptr, bake_ground(statics, limits, area, cell_m), {}, {1, 1}};
    baked.most_open = baked.ground.cells;
    baked.open = std::make_unique<GroundMap>(baked.ground);
    if (shut.empty()) {
        return baked;
    }
    baked.doors =
        DoorMap(bake_doors(statics, limits, area, cell_m, baked.ground), baked.ground.cells);
    baked.doors.open_all(baked.most_open);
    std::vector<CellChange> changes;
    for (std::uint32_t d = 0; d < shut.size(); ++d) {
        baked.doors.turn(d, shut[d] != 0, changes);
    }
    for (const CellChange& c : changes) {
        baked.ground.cells.set_passable(c.cell, c.passable);
    }
    return baked;
}

GridPaths::GridPaths(const motion::StaticGeometry& statics,
                     const motion::CharacterLimits& limits,
                     const GroundRect& area,
                     float cell_m,
                     std::span<const std::uint8_t> shut,
                     const GridPathSettings& settings)
    : GridPaths(bake(statics, limits, area, cell_m, shut), settings) {
}

GridPaths::GridPaths(Baked baked, const GridPathSettings& settings)
    : ground_(std::move(baked.open)),
      doors_(std::move(baked.doors)),
      service_(std::move(baked.ground), settings, &baked.most_open) {
}

void GridPaths::turn_doors(std::span<const std::uint8_t> shut) {
    changes_.clear();
    for (std::uint32_t d = 0; d < shut.size(); ++d) {
        doors_.turn(d, shut[d] != 0, changes_);
    }
    if (!changes_.empty()) {
        service_.change(changes_);
    }
}

bool GridPaths::straight(Spot from, float /*from_y*/, Spot to, float /*to_y*/) const {
    const GroundGrid& grid = service_.grid();
    const GridMap& map = service_.planner().map();
    if (!grid.contains(from) || !grid.contains(to) || !map.passable(grid.cell(from)) ||
        !map.passable(grid.cell(to))) {
        return false;
    }
    std::uint32_t looked = 0;
    return sees(map, grid.cell(from), grid.cell(to), looked);
}

MapExit GridPaths::straight_exit(Spot from, float /*from_y*/, Spot to) {
    const GroundGrid& grid = service_.grid();
    const GridMap& map = service_.planner().map();
    const int right = grid.width() - 1;
    const int bottom = grid.height() - 1;
    const Spot first = grid.centre({0, 0});
    const Spot last =
        grid.centre({static_cast<std::uint16_t>(right), static_cast<std::uint16_t>(bottom)});
    Spot best{std::clamp(to.x, first.x, last.x), std::clamp(to.z, first.z, last.z)};
    float least = std::numeric_limits<float>::infinity();
    const auto consider = [&](int x, int y) {
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const Spot at = grid.centre(c);
        const float sum = spots_apart(from, at) + spots_apart(at, to);
        if (sum < least && map.passable(c) && service_.reaches(from, c)) {
            least = sum;
            best = at;
        }
    };
    for (int y = 0; y <= bottom && (to.x < first.x || to.x > last.x); ++y) {
        consider(to.x < first.x ? 0 : right, y);
    }
    for (int x = 0; x <= right && (to.z < first.z || to.z > last.z); ++x) {
        consider(x, to.z < first.z ? 0 : bottom);
    }
    return {best};
}

std::optional<MapExit> GridPaths::exit_towards(Spot from, float from_y, Spot to) {
    const bool place = std::isfinite(to.x) && std::isfinite(to.z);
    if (const auto out = place ? portal_towards(from, to) : std::nullopt) {
        return MapExit{*out};
    }
    return PathProvider::exit_towards(from, from_y, to);
}

std::optional<Spot> GridPaths::portal_towards(Spot from, Spot to) {
    if (portals_ == nullptr) {
        return std::nullopt;
    }
    const GroundGrid& grid = service_.grid();
    if (grid.contains(to)) {
        // A goal in an obstacle stands for what is nearest, and is looked for within the zone.
        const Cell goal = grid.cell(to);
        if (!service_.planner().map().passable(goal) || service_.reaches(from, goal)) {
            return std::nullopt;
        }
    }
    const std::optional<std::uint32_t> other = portals_->zone_of(zone_, to);
    if (!other) {
        return std::nullopt;
    }
    return portals_->straight_exit(
        zone_,
        from,
        *other,
        portals_->local(zone_, to, *other),
        [&](Cell c) { return service_.length(from, c); },
        scratch_);
}

void GridPaths::know_zones(std::shared_ptr<const ZonePortals> portals, std::uint32_t zone) {
    portals_ = std::move(portals);
    zone_ = zone;
    ground_.reset();
}

std::size_t GridPaths::bytes() const {
    const std::size_t kept =
        ground_ != nullptr ? ground_->floor_m.capacity() * sizeof(float) : std::size_t{0};
    return kept + service_.bytes() + doors_.bytes() + changes_.capacity() * sizeof(CellChange);
}

}  // namespace zoned::ai::pathfinding
