#include "server/interest/interest_step.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::interest {

std::uint8_t lod_at(float distance, const Settings& settings, int current_lod) {
    std::uint8_t lod = 0;
    for (const float radius : settings.lod_radius_m) {
        const bool held = current_lod >= 0 && current_lod <= static_cast<int>(lod);
        const float reach =
            radius + settings.lod_lead_m + (held ? settings.hysteresis * radius : 0.0F);
        if (distance <= reach) {
            break;
        }
        ++lod;
    }
    return lod;
}

void brute_force(const world::Entities& entities,
                 const world::TypeTable& types,
                 const world::Viewer& viewer,
                 const Settings& settings,
                 std::vector<world::Row>& inner,
                 std::vector<world::Row>& outer) {
    inner.clear();
    outer.clear();
    const world::Row own = entities.find(viewer.avatar);
    if (own == world::kNoRow) {
        return;
    }
    const float nimbus = types[entities.type[own]].nimbus_m.at(entities.behaviour[own]);
    for (world::Row row = 0; row < entities.size(); ++row) {
        if (row == own || entities.has(row, world::kHidden)) {
            continue;
        }
        const float aura = types[entities.type[row]].aura_m.at(entities.behaviour[row]);
        const float dx = entities.position[row].x() - entities.position[own].x();
        const float dz = entities.position[row].z() - entities.position[own].z();
        const float distance_squared = dx * dx + dz * dz;
        if (hears(distance_squared, nimbus, aura, false, settings.hysteresis)) {
            inner.push_back(row);
        }
        if (hears(distance_squared, nimbus, aura, true, settings.hysteresis)) {
            outer.push_back(row);
        }
    }
}

}  // namespace zoned::interest
