// Interest rule: decides for one pair, by aura and nimbus with hysteresis, whether the viewer is
// notified of the entity and at which level of detail. matcher.h applies it to all pairs.
#pragma once

#include "server/world/entities.h"
#include "server/world/visibility.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace zoned::interest {

struct InterestSettings {
    float hysteresis =
        0.1F;  ///< a known entity is lost only beyond (1 + hysteresis) x the radius, [0, 1]
    std::vector<float> lod_radius_m;  ///< promised LOD k holds within lod_radius_m[k], ascending;
                                      ///< the last LOD holds beyond them all. 0..3 entries
    float lod_lead_m = 3.0F;  ///< a LOD is subscribed this much before its radius is reached, so
                              ///< that its updates arrive in time
};

struct InterestReport {
    std::uint32_t viewers = 0;
    std::uint32_t visible_pairs = 0;
    std::uint32_t entered = 0;
    std::uint32_t left = 0;
    std::uint32_t changed = 0;    ///< entities that moved, came, left or changed their radius
    std::uint32_t refreshed = 0;  ///< sets made anew: of viewers that came, jumped or changed
    std::uint32_t examined = 0;   ///< pairs that a step led out of their settled range
    bool broadcast = false;       ///< all areas overlap: no move changes anything
    bool skipped = false;         ///< no viewer: nothing ran
};

/// The rule, for one pair, horizontally (x, z): a hears of b when the distance is at most min(aura
/// of b, nimbus of a), m, closed. `known` adds the hysteresis. A radius that is not positive
/// reaches nobody, not even at distance zero. The matching, the broadcast test and brute force all
/// call this one function.
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

/// The cone that a viewer hears beside its nimbus: as far as `length_m` within half an angle about
/// the direction of its view. The default is none.
struct ViewCone {
    float length_m = 0.0F;
    float ahead_x = 0.0F;  ///< unit, horizontal: where it looks
    float ahead_z = 1.0F;
    float cosine = 1.0F;        ///< of half the angle
    float cosine_known = 1.0F;  ///< of (1 + hysteresis) times it, at most half a turn
};

/// Of a viewer that faces `yaw` (65536 = one turn about +y, 0 looks along +z).
ViewCone view_cone(const world::Cone& cone, std::uint16_t yaw, float hysteresis);

/// The cone of an entity's stance and yaw; none where its type has none.
ViewCone view_cone(const world::Entities& entities,
                   const world::TypeTable& types,
                   world::Row row,
                   float hysteresis);

/// The rule for a viewer with a cone: (dx, dz) is from the viewer to the entity, m. Its edges
/// belong to it; `known` widens length and angle by the hysteresis.
inline bool hears(float dx,
                  float dz,
                  float nimbus_m,
                  const ViewCone& cone,
                  float aura_m,
                  bool known,
                  float hysteresis) {
    const float squared = dx * dx + dz * dz;
    if (hears(squared, nimbus_m, aura_m, known, hysteresis)) {
        return true;
    }
    if (!(cone.length_m > 0.0F) || !hears(squared, cone.length_m, aura_m, known, hysteresis)) {
        return false;
    }
    // ahead . d >= cosine |d|, without the root.
    const float along = cone.ahead_x * dx + cone.ahead_z * dz;
    const float cosine = known ? cone.cosine_known : cone.cosine;
    const float edge = cosine * cosine * squared;
    return cosine >= 0.0F ? along >= 0.0F && along * along >= edge
                          : along >= 0.0F || along * along <= edge;
}

/// LOD subscribed at a distance: the smallest k with distance <= lod_radius_m[k] + lead (known at k
/// or nearer: + lead + hysteresis x radius).
std::uint8_t lod_at(float distance, const InterestSettings& settings, int current_lod);

/// Brute force over all pairs, memory-less: the set within the radii (`inner`) and within the radii
/// with hysteresis (`outer`), by row. The set that a viewer knows must contain `inner` and be
/// contained in `outer`. For tests and audits.
void brute_force(const world::Entities& entities,
                 const world::TypeTable& types,
                 const world::Viewer& viewer,
                 const InterestSettings& settings,
                 std::vector<world::Row>& inner,
                 std::vector<world::Row>& outer);

}  // namespace zoned::interest
