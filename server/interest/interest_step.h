// interest_step: aura-nimbus matching; who hears of what, with hysteresis, and at which level of
// detail.
#pragma once

#include "server/spatial/point_grid.h"
#include "server/world/entities.h"
#include "server/world/visibility.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::interest {

struct Settings {
    float hysteresis =
        0.1F;  ///< what is heard is lost only beyond (1 + hysteresis) x the radius, [0, 1]
    std::vector<float> lod_radius_m;  ///< promised LOD k holds within lod_radius_m[k], ascending;
                                      ///< the last LOD holds beyond them all. 0..3 entries
    float lod_lead_m = 3.0F;  ///< a LOD is subscribed this much before its radius is reached, so
                              ///< that its news is there in time
};

struct Report {
    std::uint32_t viewers = 0;
    std::uint32_t visible_pairs = 0;
    std::uint32_t entered = 0;
    std::uint32_t left = 0;
    bool broadcast = false;  ///< all areas overlapped: matching was skipped
    bool skipped = false;    ///< no viewer: nothing ran
};

/// The rule, for one pair, horizontally (x, z): a hears of b when the distance is at most min(aura
/// of b, nimbus of a), m, closed. `known` adds the hysteresis. This one function is what the
/// matching, the broadcast test and brute force all call.
bool hears(float distance_squared, float nimbus_m, float aura_m, bool known, float hysteresis);

/// LOD subscribed at a distance: the smallest k with distance <= lod_radius_m[k] + lead (known at k
/// or nearer: + lead + hysteresis x radius).
std::uint8_t lod_at(float distance, const Settings& settings, int current_lod);

/// Writes `out` (one set per viewer in the order of `viewers`, which ascend by client id). Sets of
/// viewers that stay are updated in place; entered/left/lod_changed say the difference. Hidden
/// entities are heard by nobody; a viewer without a row hears nothing. `grid` indexes
/// entities.position by row, or is empty (size 0), in which case step() builds its own when it
/// needs one.
class Matcher {
  public:
    Report step(const world::Entities& entities,
                const world::TypeTable& types,
                std::span<const world::Viewer> viewers,
                const spatial::PointGrid& grid,
                const Settings& settings,
                world::Visibility& out);

  private:
    spatial::PointGrid own_grid_;
    std::vector<world::Visible> scratch_;
};

/// Brute force over all pairs, memory-less: the set within the radii (`inner`) and within the radii
/// with hysteresis (`outer`), by row. What a viewer knows must contain `inner` and be contained in
/// `outer`. For tests and audits.
void brute_force(const world::Entities& entities,
                 const world::TypeTable& types,
                 const world::Viewer& viewer,
                 const Settings& settings,
                 std::vector<world::Row>& inner,
                 std::vector<world::Row>& outer);

}  // namespace zoned::interest
