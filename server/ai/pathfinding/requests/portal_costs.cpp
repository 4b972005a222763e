#include "server/ai/pathfinding/requests/portal_costs.h"

#include "server/ai/pathfinding/grid/work_units.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// The cells of one part of the work.
constexpr std::uint32_t kAtOnce = 4096;
/// A field spreads from a cell at most as often: once from each bucket that a cell may wait in.
constexpr std::uint64_t kMostSpread = 3;

}  // namespace

PortalCosts::PortalCosts(std::shared_ptr<const ZonePortals> portals)
    : portals_(std::move(portals)),
      rows_(portals_->portals()) {
}

void PortalCosts::want(std::uint32_t portal) {
    if (rows_[portal].empty() &&
        std::find(wanted_.begin(), wanted_.end(), portal) == wanted_.end()) {
        wanted_.push_back(portal);
    }
}

bool PortalCosts::spread(std::uint32_t cells) {
    const std::uint32_t portal = wanted_.front();
    const GridMap& map = portals_->map_beyond(portal);
    if (spread_ == 0) {
        field_.begin(map, portals_->entry(portal));
    }
    spread_ += cells;
    return field_.advance(map, cells);
}

bool PortalCosts::advance(std::uint64_t units) {
    bool completed = false;
    for (std::uint64_t left = units / kFieldUnits; left > 0 && !wanted_.empty();) {
        const auto cells = static_cast<std::uint32_t>(std::min<std::uint64_t>(left, kAtOnce));
        left -= cells;
        if (spread(cells)) {
            portals_->read_row(wanted_.front(), field_, rows_[wanted_.front()]);
            wanted_.erase(wanted_.begin());
            spread_ = 0;
            completed = true;
        }
    }
    return completed;
}

SavedPortalCosts PortalCosts::save() const {
    SavedPortalCosts saved;
    for (std::uint32_t p = 0; p < rows_.size(); ++p) {
        if (!rows_[p].empty()) {
            saved.rows.push_back({p, rows_[p]});
        }
    }
    saved.wanted = wanted_;
    saved.spread = spread_;
    return saved;
}

std::string PortalCosts::defect_of(const SavedPortalCosts& saved) const {
    std::vector<std::uint8_t> seen(rows_.size(), 0);
    const auto anew = [&seen](std::uint32_t portal) {
        return portal < seen.size() && std::exchange(seen[portal], std::uint8_t{1}) == 0;
    };
    const bool rows = std::all_of(saved.rows.begin(), saved.rows.end(), [&](const auto& row) {
        return anew(row.portal) && row.costs.size() == portals_->out_of_beyond(row.portal).size();
    });
    const bool wanted = std::all_of(saved.wanted.begin(), saved.wanted.end(), anew);
    const std::uint64_t most =
        saved.wanted.empty() || !wanted
            ? 0
            : kMostSpread * portals_->map_beyond(saved.wanted.front()).passable_cells();
    return rows && wanted && saved.spread <= most ? "" : "paths know portals that there are not";
}

void PortalCosts::load(const SavedPortalCosts& saved) {
    for (const SavedPortalRow& row : saved.rows) {
        rows_[row.portal] = row.costs;
    }
    wanted_ = saved.wanted;
    // How the work is cut changes nothing about the field.
    while (spread_ < saved.spread) {
        spread(
            static_cast<std::uint32_t>(std::min<std::uint64_t>(saved.spread - spread_, kAtOnce)));
    }
}

std::size_t PortalCosts::bytes() const {
    std::size_t bytes = rows_.capacity() * sizeof(PortalRow) + field_.bytes() +
                        wanted_.capacity() * sizeof(std::uint32_t);
    for (const PortalRow& row : rows_) {
        bytes += row.capacity() * sizeof(float);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
