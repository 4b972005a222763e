// interest_step: the rule of aura-nimbus matching; who hears of what, with hysteresis, and at which
// level of detail. matcher.h applies it to everybody.
#pragma once

#include "server/world/entities.h"
#include "server/world/visibility.h"

#include <algorithm>
#include <cstdint>
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
    std::uint32_t changed = 0;    ///< entities that moved, came, left or changed their radius
    std::uint32_t refreshed = 0;  ///< sets made anew: of viewers that came, jumped or changed
    std::uint32_t examined = 0;   ///< pairs that a step led out of what was settled
    bool broadcast = false;       ///< all areas overlap: who moves changes nothing
    bool skipped = false;         ///< no viewer: nothing ran
};

/// The rule, for one pair, horizontally (x, z): a hears of b when the distance is at most min(aura
/// of b, nimbus of a), m, closed. `known` adds the hysteresis. A radius that is not positive
/// reaches nobody, not even at distance zero. This one function is what the matching, the broadcast
/// test and brute force all call.
inline bool hears(float distance_squared,
                  float nimbus_m,
                  float aura_m,
                  bool known,
                  float hysteresis) {
    float radius = std::min(nimbus_m, aura_m);
    if (known) {
        radius *= 1.0F + hysteresis;
    }
    return radius > 0.0F && distance_squared <= radius * radius;
}

/// LOD subscribed at a distance: the smallest k with distance <= lod_radius_m[k] + lead (known at k
/// or nearer: + lead + hysteresis x radius).
std::uint8_t lod_at(float distance, const Settings& settings, int current_lod);

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
