#include "server/config/expand/world_warnings.h"

#include "server/config/settings.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace zoned::config {

namespace {

/// A character steps over so much.
constexpr double kStep_m = 0.3;

std::string figures(const char* format, double a, double b, double c = 0.0) {
    char text[200];
    std::snprintf(text, sizeof(text), format, a, b, c);
    return text;
}

void warn_of_silent_types(const Settings& settings, std::vector<std::string>& out) {
    for (const world::EntityType& type : settings.types) {
        const bool heard = std::any_of(
            type.aura_m.begin(), type.aura_m.end(), [](float radius) { return radius > 0.0F; });
        if (heard || (type.assembly != 0 && type.part != 0)) {
            continue;
        }
        out.push_back("type '" + type.name +
                      "': it has no aura, so no viewer ever hears of such an entity: set aura_m { "
                      "normal: ... }");
    }
}

/// The edge sample of a heightfield that stands highest above the ground, within the world.
struct OpenEdge {
    double height_m = 0.0;
    Vec3d at = Vec3d::Zero();
};

bool inside_world(const Settings& settings, const Vec3d& at) {
    // An edge on the border of the world is where nobody comes.
    return std::any_of(settings.zones.begin(), settings.zones.end(), [&](const ZoneRegion& z) {
        return at.x() >= z.min_x && at.x() <= z.max_x && at.z() >= z.min_z && at.z() <= z.max_z;
    });
}

bool meets_another(const Settings& settings, const SurfaceSettings& own, const Vec3d& at) {
    return std::any_of(
        settings.surfaces.begin(), settings.surfaces.end(), [&](const SurfaceSettings& other) {
            if (&other == &own) {
                return false;
            }
            const Vec3d local =
                other.orientation.conjugate().cast<double>() * (at - other.position);
            const Aabb& box = other.surface->box();
            return local.x() >= static_cast<double>(box.lower.x()) - kStep_m &&
                   local.x() <= static_cast<double>(box.upper.x()) + kStep_m &&
                   local.z() >= static_cast<double>(box.lower.z()) - kStep_m &&
                   local.z() <= static_cast<double>(box.upper.z()) + kStep_m;
        });
}

std::optional<OpenEdge> open_edge_of(const Settings& settings, const SurfaceSettings& surface) {
    const motion::HeightGrid& grid = surface.surface->grid();
    std::optional<OpenEdge> out;
    const auto look = [&](std::uint32_t i, std::uint32_t k) {
        const double x = (i - 0.5 * (grid.columns - 1.0)) * static_cast<double>(grid.spacing_x);
        const double z = (k - 0.5 * (grid.rows - 1.0)) * static_cast<double>(grid.spacing_z);
        const double y = static_cast<double>(grid.heights[std::size_t{k} * grid.columns + i]);
        const Vec3d at = surface.position + surface.orientation.cast<double>() * Vec3d(x, y, z);
        const double height = at.y() - static_cast<double>(settings.ground_height_m);
        if (height > kStep_m && (!out || height > out->height_m) && inside_world(settings, at) &&
            !meets_another(settings, surface, at)) {
            out = OpenEdge{height, at};
        }
    };
    for (std::uint32_t i = 0; i < grid.columns; ++i) {
        look(i, 0);
        look(i, grid.rows - 1);
    }
    for (std::uint32_t k = 1; k + 1 < grid.rows; ++k) {
        look(0, k);
        look(grid.columns - 1, k);
    }
    return out;
}

void warn_of_open_edges(const Settings& settings, std::vector<std::string>& out) {
    for (const SurfaceSettings& surface : settings.surfaces) {
        if (!surface.surface->is_grid()) {
            continue;
        }
        if (const auto edge = open_edge_of(settings, surface)) {
            out.push_back(surface.path + " (" + surface.file + "): its edge stands " +
                          figures("%.3g m above the ground at x %.4g, z %.4g",
                                  edge->height_m,
                                  edge->at.x(),
                                  edge->at.z()) +
                          ": whatever goes beyond it falls; lead the edge down to the ground, or "
                          "end the world there");
        }
    }
}

void warn_of_falls(const Settings& settings, std::vector<std::string>& out) {
    // From the highest thing that stands to the ground.
    double top = 0.0;
    for (const motion::StaticBox& box : settings.boxes) {
        top = std::max(top, static_cast<double>(box.centre.y() + box.half_extents.norm()));
    }
    for (const SurfaceSettings& surface : settings.surfaces) {
        top = std::max(
            top, surface.position.y() + static_cast<double>(surface.surface->box().upper.y()));
    }
    const double gravity = std::abs(static_cast<double>(settings.physics.gravity.y()));
    const double fall = std::sqrt(
        2.0 * gravity * std::max(0.0, top - static_cast<double>(settings.ground_height_m)));
    const auto most = static_cast<double>(settings.replication.quantization.max_speed_mps);
    if (fall > most) {
        out.push_back(
            "replication.quantization.max_speed_mps: " +
            figures("a fall from the highest static ends at %.3g m/s, the wire carries %g",
                    fall,
                    most));
    }
}

/// Speed of the fastest platform, m/s.
double fastest_platform(const Settings& settings) {
    double fastest = 0.0;
    for (const NamedPlatform& named : settings.platforms) {
        const motion::PlatformPath& path = named.platform.path;
        const auto& stops = path.stops;
        const auto travel = [&](const Vec3& way, Tick ticks) {
            const double s = static_cast<double>(ticks) / settings.tick_rate_hz;
            fastest = std::max(fastest, s > 0.0 ? static_cast<double>(way.norm()) / s : 0.0);
        };
        for (std::size_t i = 1; i < stops.size(); ++i) {
            travel(stops[i].offset - stops[i - 1].offset, stops[i].at - stops[i - 1].at);
        }
        travel(stops.back().offset, path.back);
    }
    return fastest;
}

/// A wall stops a character at once, also one that a platform carries.
void warn_of_sudden_stops(const Settings& settings, std::vector<std::string>& out) {
    const double carried = fastest_platform(settings);
    for (const world::EntityType& type : settings.types) {
        const double fastest =
            carried + static_cast<double>(type.character.speed) *
                          std::max(1.0, static_cast<double>(type.character.sprint_factor));
        const auto most = static_cast<double>(type.max_velocity_jump_mps);
        if (type.kind == world::EntityKind::kCharacter && fastest > most) {
            out.push_back(
                "type '" + type.name + "'.max_velocity_jump_mps: " +
                figures("a wall stops it at once from %.3g m/s, on the fastest platform, and "
                        "clients are promised that its velocity jumps by %g at most",
                        fastest,
                        most));
        }
    }
}

}  // namespace

std::vector<std::string> world_warnings_of(const Settings& settings) {
    std::vector<std::string> out;
    warn_of_silent_types(settings, out);
    warn_of_open_edges(settings, out);
    warn_of_falls(settings, out);
    warn_of_sudden_stops(settings, out);
    return out;
}

std::vector<std::string> testing_faults_of(const Settings& settings) {
    std::vector<std::string> out;
    if (settings.config) {
        const proto::config::Testing& testing = settings.config->testing();
        std::vector<const google::protobuf::FieldDescriptor*> fields;
        testing.GetReflection()->ListFields(testing, &fields);
        for (const auto* field : fields) {
            out.push_back(field->name());
        }
    }
    return out;
}

}  // namespace zoned::config
