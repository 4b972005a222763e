// PairMatcher: who hears of what at one moment, from nothing and without memory, in columns.
#pragma once

#include "server/interest/row_grid.h"
#include "server/world/entities.h"
#include "server/world/visibility.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::interest {

/// Viewer i hears of rows[first[i]] .. rows[first[i] + count[i] - 1], in no order.
struct Pairs {
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> count;
    std::vector<world::Row> rows;
    std::size_t size = 0;  ///< of all counts together
};

/// For snapshots of a world, and for what needs no sets that live on: builds a grid and asks it for
/// each viewer, without hysteresis, levels of detail or lists of differences. No allocation after
/// warm-up.
class PairMatcher {
  public:
    void step(const world::Entities& entities,
              const world::TypeTable& types,
              std::span<const world::Viewer> viewers,
              Pairs& out);

  private:
    void read_entities(const world::Entities& entities, const world::TypeTable& types);
    void read_viewers(const world::Entities& entities,
                      const world::TypeTable& types,
                      std::span<const world::Viewer> viewers);
    void order_queries();

    std::vector<float> x_;  // by row, as are the next two
    std::vector<float> z_;
    std::vector<float> aura_;
    std::vector<float> aura_of_;  // by type and stance
    std::vector<world::Row> viewer_row_;
    std::vector<RowGridQuery> asked_;         // of viewers that hear at all
    std::vector<std::uint32_t> asker_;        // their viewers
    std::vector<std::uint32_t> place_;        // and where they stand
    std::vector<std::uint32_t> place_begin_;  // of the next two, by place
    std::vector<RowGridQuery> queries_;       // by place: neighbours ask for the same points
    std::vector<std::uint32_t> viewer_of_;
    std::vector<std::uint32_t> ends_;
    float largest_aura_m_ = 0.0F;
    float largest_nimbus_m_ = 0.0F;
    RowGrid row_grid_;
};

}  // namespace zoned::interest
