// PairMatcher: who hears of what at one moment, from nothing and without memory, in columns.
#pragma once

#include "server/interest/kept_grid.h"
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
    /// Where a viewer listens.
    struct Place {
        std::uint32_t viewer = 0;
        world::Row row = 0;
        float x = 0.0F;
        float z = 0.0F;
        float nimbus_m = 0.0F;
    };

    void read_entities(const world::Entities& entities, const world::TypeTable& types);
    void read_viewers(const world::Entities& entities,
                      const world::TypeTable& types,
                      std::span<const world::Viewer> viewers);
    void order_viewers();

    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<float> aura_;
    std::vector<float> aura_of_;  // by type and behaviour
    std::vector<world::Row> viewer_row_;
    std::vector<float> viewer_nimbus_;
    std::vector<std::uint32_t> line_begin_;  // of `order_`, by line of the grid
    std::vector<Place> order_;               // viewers by line: neighbours ask for the same cells
    float largest_aura_m_ = 0.0F;
    float largest_nimbus_m_ = 0.0F;
    KeptGrid grid_;
};

}  // namespace zoned::interest
