#include "server/config/expand/stability_report.h"

#include "server/assets/geometry_survey.h"
#include "server/config/settings.h"
#include "server/physics/scene/stability_warnings.h"
#include "server/zone/simulation/type_body.h"

#include <algorithm>

namespace zoned::config {

namespace {

void add(const std::string& about,
         const std::vector<std::string>& warnings,
         std::vector<std::string>& out) {
    for (const std::string& warning : warnings) {
        out.push_back(about + warning);
    }
}

/// The rigid props with the least and the greatest mass; null when there are none.
struct Extremes {
    const world::EntityType* light = nullptr;
    const world::EntityType* heavy = nullptr;
};

Extremes extremes_of(const world::TypeTable& types) {
    Extremes out;
    for (const world::EntityType& type : types) {
        if (type.kind != world::EntityKind::kProp || type.shape == world::TypeShape::kSoft) {
            continue;
        }
        if (out.light == nullptr || type.mass < out.light->mass) {
            out.light = &type;
        }
        if (out.heavy == nullptr || type.mass > out.heavy->mass) {
            out.heavy = &type;
        }
    }
    return out;
}

/// A body in the corner of the zone, in the zone's coordinates.
physics::BodyDef corner_of(const ZoneRegion& zone) {
    physics::BodyDef def;
    def.kind = physics::BodyKind::kStatic;
    def.position = Vec3(static_cast<float>(0.5 * (zone.max_x - zone.min_x)),
                        0.0F,
                        static_cast<float>(0.5 * (zone.max_z - zone.min_z)));
    return def;
}

std::vector<std::string> stability_warnings_of_surface(const SurfaceSettings& surface,
                                                       float error_budget_m) {
    if (surface.shape.kind == physics::ShapeKind::kHeightfield) {
        const assets::FieldSurvey figures = assets::survey(physics::field_of(surface.shape));
        return stability_warnings_of(figures, surface.level_m, error_budget_m);
    }
    return stability_warnings_of(assets::survey(physics::mesh_of(surface.shape), error_budget_m),
                                 error_budget_m);
}

/// Reports each geometry once, however often it is placed.
void add_surfaces(const Settings& settings, std::vector<std::string>& out) {
    std::vector<const physics::Geometry*> seen;
    for (const SurfaceSettings& surface : settings.surfaces) {
        const physics::Geometry* geometry = surface.shape.geometry.get();
        if (std::find(seen.begin(), seen.end(), geometry) == seen.end()) {
            seen.push_back(geometry);
            add(surface.path + " (" + surface.file + "): ",
                stability_warnings_of_surface(surface, settings.physics.error_budget_m),
                out);
        }
    }
}

}  // namespace

std::vector<std::string> stability_warnings_of(const Settings& settings) {
    const auto dt = static_cast<float>(1.0 / settings.tick_rate_hz);
    const physics::PhysicsSettings& physics = settings.physics;
    std::vector<std::string> out;
    add("physics: ", physics::stability_warnings_of(physics, dt), out);
    for (const world::EntityType& type : settings.types) {
        if (type.shape == world::TypeShape::kSoft) {
            continue;  // any stiffness is stable there
        }
        add("type '" + type.name + "': ",
            physics::stability_warnings_of(zone::body_of(type, settings.solids), physics, dt),
            out);
    }
    const Extremes extremes = extremes_of(settings.types);
    if (extremes.light != extremes.heavy) {
        add("type '" + extremes.heavy->name + "' on type '" + extremes.light->name + "': ",
            physics::stability_warnings_of_load(
                extremes.light->mass, extremes.heavy->mass, physics, dt),
            out);
    }
    for (const ZoneRegion& zone : settings.zones) {
        add("zone '" + zone.name + "': its corner ",
            physics::stability_warnings_of(corner_of(zone), physics, dt),
            out);
    }
    add_surfaces(settings, out);
    return out;
}

}  // namespace zoned::config
