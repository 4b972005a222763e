// PortalCosts: the costs of paths between portals, found when a path first depends on them.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/requests/saved_paths.h"
#include "server/ai/pathfinding/requests/zone_portals.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::pathfinding {

/// A wanted row is found by a flow field over the zone beyond its portal, in the order of requests.
/// The work of a tick is a count of cells, so the tick in which a row is there depends on the calls
/// alone. Rows are those of a map that never changes, hence they are kept: a world has at most
/// ZonePortals::kMostPortals. Each zone finds its own, so that no zone waits for another.
///
/// Nothing is allocated once a row was found, but for the rows themselves.
class PortalCosts {
  public:
    PortalCosts() = default;
    explicit PortalCosts(std::shared_ptr<const ZonePortals> portals);

    /// By portal; empty where not known.
    [[nodiscard]] std::span<const PortalRow> rows() const { return rows_; }

    /// Puts a row in the queue, unless it is known or wanted already.
    void want(std::uint32_t portal);

    /// Goes on for about so many units of some 2 ns. True where a row was completed. A field that
    /// begins takes memory_units() of its map besides.
    bool advance(std::uint64_t units);

    /// The number of rows that are wanted and not there yet.
    [[nodiscard]] std::size_t wanted() const { return wanted_.size(); }

    [[nodiscard]] SavedPortalCosts save() const;

    /// The reason why the state does not fit these portals; empty: it fits.
    [[nodiscard]] std::string defect_of(const SavedPortalCosts& saved) const;

    /// Loads what has no defect.
    void load(const SavedPortalCosts& saved);

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// Spreads the field of the first wanted row over so many cells; true once it is complete.
    bool spread(std::uint32_t cells);

    std::shared_ptr<const ZonePortals> portals_;
    std::vector<PortalRow> rows_;
    std::vector<std::uint32_t> wanted_;  // the one that is being found first
    FlowField field_;
    std::uint64_t spread_ = 0;  // cells of the first wanted row so far
};

}  // namespace zoned::ai::pathfinding
