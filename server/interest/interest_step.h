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
/// of b, nimbus of a), m, closed. `known` adds the hysteresis. A radius that is not positive
/// reaches nobody, not even at distance zero. This one function is what the matching, the broadcast
/// test and brute force all call.
bool hears(float distance_squared, float nimbus_m, float aura_m, bool known, float hysteresis);

/// LOD subscribed at a distance: the smallest k with distance <= lod_radius_m[k] + lead (known at k
/// or nearer: + lead + hysteresis x radius).
std::uint8_t lod_at(float distance, const Settings& settings, int current_lod);

/// Writes `out` (one set per viewer in the order of `viewers`, which ascend by client id). Sets of
/// viewers that stay are updated in place, sets of viewers that are gone are dropped;
/// entered/left/lod_changed say the difference. Hidden entities are heard by nobody; a viewer
/// without a row hears nothing. `grid` indexes entities.position by row, or is empty (size 0), in
/// which case step() builds its own when it needs one. No allocation after warm-up.
class Matcher {
  public:
    Report step(const world::Entities& entities,
                const world::TypeTable& types,
                std::span<const world::Viewer> viewers,
                const spatial::PointGrid& grid,
                const Settings& settings,
                world::Visibility& out);

  private:
    /// One entity that a viewer may hear of, before membership is decided.
    struct Candidate {
        std::uint64_t key = 0;  // entity id in the upper half, so that sorting orders by entity
        float distance_squared = 0.0F;
        float aura_m = 0.0F;
    };

    /// What the population as a whole says about matching.
    struct Survey {
        float largest_nimbus_m = 0.0F;
        float largest_aura_m = 0.0F;
        bool all_overlap = false;
    };

    void align_sets(std::span<const world::Viewer> viewers, world::Visibility& out);
    Survey survey(const world::Entities& entities,
                  const world::TypeTable& types,
                  std::span<const world::Viewer> viewers,
                  const Settings& settings);
    void list_everybody(const world::Entities& entities);
    void gather_near(const world::Entities& entities,
                     const spatial::PointGrid& grid,
                     world::Row own_row,
                     float reach_m,
                     const Settings& settings);
    void gather_all(const world::Entities& entities, world::Row own_row);
    void update_set(float nimbus_m,
                    bool everybody,
                    const Settings& settings,
                    world::VisibleSet& set);

    spatial::PointGrid own_grid_;
    std::vector<float> aura_m_;             // by row; hidden entities have none
    std::vector<world::Row> viewer_row_;    // by viewer
    std::vector<float> viewer_nimbus_m_;    // by viewer
    std::vector<std::uint64_t> everybody_;  // entity << 32 | row, ascending; broadcasts only
    std::vector<Candidate> candidates_;
    std::vector<world::Visible> scratch_;
    world::Visibility spare_;
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
