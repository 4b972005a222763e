#include "server/ai/pathfinding/requests/grid_paths.h"

#include <cmath>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// Work in a tick on costs between portals, in units of about 2 ns, while there are rough exits; in
/// addition to GridPathSettings::work_per_tick.
constexpr std::uint64_t kPortalWork = 200'000;

}  // namespace

GridPaths::Baked GridPaths::bake(const motion::StaticGeometry& statics,
                                 const motion::CharacterLimits& limits,
                                 const GroundRect& area,
                                 float cell_m,
                                 std::span<const std::uint8_t> shut) {
    auto open = std::make_unique<GroundMap>(bake_ground(statics, limits, area, cell_m));
    // Floors matter to portals alone.
    const GroundMap flat{open->grid, open->cells, {}};
    Baked baked{std::move(open), flat, {}, flat.cells};
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
    : GridPathRequests(std::move(baked.ground), settings, &baked.most_open),
      ground_(std::move(baked.open)),
      doors_(std::move(baked.doors)) {
}

void GridPaths::turn_doors(std::span<const std::uint8_t> shut) {
    changes_.clear();
    for (std::uint32_t d = 0; d < shut.size(); ++d) {
        doors_.turn(d, shut[d] != 0, changes_);
    }
    change(changes_);
}

std::optional<MapExit> GridPaths::exit_towards(Spot from, float from_y, Spot to) {
    const bool place = std::isfinite(to.x) && std::isfinite(to.z);
    if (const auto out = place ? portal_towards(from, to) : std::nullopt) {
        return out;
    }
    return GridPathRequests::exit_towards(from, from_y, to);
}

std::optional<MapExit> GridPaths::portal_towards(Spot from, Spot to) {
    if (portals_ == nullptr) {
        return std::nullopt;
    }
    if (contains(to)) {
        // A goal in an obstacle is replaced by the nearest cell, and searched within the zone.
        const Cell goal = grid().cell(to);
        if (!planner().map().passable(goal) || reaches(from, goal)) {
            return std::nullopt;
        }
    }
    const std::optional<std::uint32_t> other = portals_->zone_of(zone_, to);
    if (!other) {
        return std::nullopt;
    }
    const auto exit = portals_->straight_exit(
        zone_,
        from,
        *other,
        portals_->local(zone_, to, *other),
        costs_.rows(),
        [&](Cell c) { return length(from, c); },
        scratch_);
    spend(scratch_.work);
    for (const std::uint32_t portal : scratch_.unknown) {
        costs_.want(portal);
    }
    return exit ? std::optional(MapExit{exit->at, kOnGround, exit->rough}) : std::nullopt;
}

bool GridPaths::learn_exits() {
    return costs_.advance(kPortalWork);
}

void GridPaths::know_zones(std::shared_ptr<const ZonePortals> portals, std::uint32_t zone) {
    costs_ = PortalCosts(portals);
    portals_ = std::move(portals);
    zone_ = zone;
    ground_.reset();
}

SavedPaths GridPaths::save() const {
    SavedPaths memory = GridPathRequests::save();
    memory.portal_costs = costs_.save();
    return memory;
}

std::string GridPaths::load(const SavedPaths& memory) {
    std::string wrong = costs_.defect_of(memory.portal_costs);
    if (wrong.empty()) {
        wrong = GridPathRequests::load(memory);
    }
    if (wrong.empty()) {
        costs_.load(memory.portal_costs);
    }
    return wrong;
}

std::size_t GridPaths::bytes() const {
    const std::size_t kept =
        ground_ != nullptr ? ground_->floor_m.capacity() * sizeof(float) : std::size_t{0};
    return kept + GridPathRequests::bytes() + doors_.bytes() + costs_.bytes() +
           changes_.capacity() * sizeof(CellChange);
}

}  // namespace zoned::ai::pathfinding
