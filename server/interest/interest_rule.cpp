#include "server/interest/interest_rule.h"

#include "shared/core/assert.h"
#include "shared/core/elementary/elementary.h"
#include "shared/math/heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::interest {

ViewCone view_cone(const world::Cone& cone, std::uint16_t yaw, float hysteresis) {
    ViewCone out;
    if (!(cone.length_m > 0.0F)) {
        return out;
    }
    constexpr double kPi = std::numbers::pi;
    const auto half = static_cast<double>(cone.half_angle_rad);
    out.length_m = cone.length_m;
    const Vec2 ahead = heading_of(yaw);
    out.ahead_x = ahead.x();
    out.ahead_z = ahead.y();
    out.cosine = static_cast<float>(elementary::cos(std::min(kPi, half)));
    out.cosine_known = static_cast<float>(
        elementary::cos(std::min(kPi, half * (1.0 + static_cast<double>(hysteresis)))));
    return out;
}

ViewCone view_cone(const world::Entities& entities,
                   const world::TypeTable& types,
                   world::Row row,
                   float hysteresis) {
    return view_cone(
        types[entities.type[row]].nimbus_cone[entities.stance[row]], entities.yaw[row], hysteresis);
}

std::uint8_t lod_at(float distance, const InterestSettings& settings, int current_lod) {
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
                 const InterestSettings& settings,
                 std::vector<world::Row>& inner,
                 std::vector<world::Row>& outer) {
    inner.clear();
    outer.clear();
    const world::Row own = entities.find(viewer.avatar);
    if (own == world::kNoRow) {
        return;
    }
    const float nimbus = types[entities.type[own]].nimbus_m.at(entities.stance[own]);
    const ViewCone cone = view_cone(entities, types, own, settings.hysteresis);
    for (world::Row row = 0; row < entities.size(); ++row) {
        if (row == own || (entities.flags[row] & world::kUnheard) != 0) {
            continue;
        }
        const float aura = types[entities.type[row]].aura_m.at(entities.stance[row]);
        const float dx = entities.position[row].x() - entities.position[own].x();
        const float dz = entities.position[row].z() - entities.position[own].z();
        if (hears(dx, dz, nimbus, cone, aura, false, settings.hysteresis)) {
            inner.push_back(row);
        }
        if (hears(dx, dz, nimbus, cone, aura, true, settings.hysteresis)) {
            outer.push_back(row);
        }
    }
}

}  // namespace zoned::interest
