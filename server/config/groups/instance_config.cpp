#include "server/config/groups/instance_config.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace zoned::config {

namespace {

/// Places of the world have this limit in configs too, m.
constexpr double kFarthest_m = 50'000.0;
constexpr std::size_t kMostZones = 1024;
/// Copies lie on a grid of so many metres: their coordinates as floats lose little.
constexpr double kGrid_m = 16.0;

struct Area {
    const proto::config::Instance* from = nullptr;
    std::string path;

    [[nodiscard]] const proto::config::Region& region() const { return from->area(); }

    [[nodiscard]] double wide_m() const { return region().max_x_m() - region().min_x_m(); }

    [[nodiscard]] double deep_m() const { return region().max_z_m() - region().min_z_m(); }

    template <class Point>
    [[nodiscard]] bool holds(const Point& at) const {
        return at.x() >= region().min_x_m() && at.x() < region().max_x_m() &&
               at.z() >= region().min_z_m() && at.z() < region().max_z_m();
    }
};

/// The cells beyond the world in which the copies lie.
struct Grid {
    double begin_x = 0.0;
    double begin_z = 0.0;
    double cell_x = 0.0;
    double cell_z = 0.0;
    std::size_t columns = 1;

    [[nodiscard]] Vec3d corner(std::size_t n) const {
        return {begin_x + cell_x * static_cast<double>(n % columns),
                0.0,
                begin_z + cell_z * static_cast<double>(n / columns)};
    }
};

bool overlap(const Area& a, const Area& b) {
    return a.region().min_x_m() < b.region().max_x_m() &&
           b.region().min_x_m() < a.region().max_x_m() &&
           a.region().min_z_m() < b.region().max_z_m() &&
           b.region().min_z_m() < a.region().max_z_m();
}

bool lies_in(const Area& area, const ZoneRegion& zone) {
    const proto::config::Region& r = area.region();
    return r.min_x_m() >= zone.min_x && r.max_x_m() <= zone.max_x && r.min_z_m() >= zone.min_z &&
           r.max_z_m() <= zone.max_z;
}

/// Empty where there is a mistake.
std::vector<Area> checked_areas(const proto::config::Config& config,
                                const Settings& settings,
                                Diagnostics& diagnostics) {
    const std::size_t before = diagnostics.size();
    std::vector<Area> areas;
    std::set<std::string> names;
    for (int i = 0; i < config.instance_size(); ++i) {
        const Area area{&config.instance(i), join_path("", "instance", i)};
        const std::string& name = area.from->name();
        if (check_name(name, "an instance", area.path, diagnostics) && !names.insert(name).second) {
            diagnostics.add(area.path + ".name", "'" + name + "' is the name of another instance");
        }
        if (!area.from->has_area() || !(area.wide_m() > 0.0 && area.deep_m() > 0.0)) {
            diagnostics.add(area.path, "an instance has an area with a minimum below its maximum");
            continue;
        }
        const bool in_one = std::ranges::any_of(
            settings.zones, [&](const ZoneRegion& zone) { return lies_in(area, zone); });
        if (!in_one) {
            diagnostics.add(area.path + ".area", "must lie within one zone");
        }
        for (const Area& other : areas) {
            if (overlap(area, other)) {
                diagnostics.add(area.path + ".area",
                                "overlaps the area of instance '" + other.from->name() + "'");
            }
        }
        if (std::ranges::none_of(settings.spawn_points, [&](const zone::SpawnPoint& point) {
                return area.holds(point.position);
            })) {
            diagnostics.add(area.path, "has no entrance: no spawn point lies in its area");
        }
        areas.push_back(area);
    }
    return diagnostics.size() == before ? areas : std::vector<Area>();
}

Grid grid_of(const std::vector<Area>& areas,
             const proto::config::World& world,
             double margin_m,
             std::size_t copies) {
    const auto up = [](double m) {
        return kGrid_m * std::ceil(m / kGrid_m);
    };
    // Nothing reaches across a border that is farther than the margin; a box of the statics does
    // not reach so far either, or its neighbours would not meet it today.
    const double gap = 2.0 * margin_m;
    Grid grid;
    for (const Area& area : areas) {
        grid.cell_x = std::max(grid.cell_x, up(area.wide_m() + gap));
        grid.cell_z = std::max(grid.cell_z, up(area.deep_m() + gap));
    }
    grid.begin_x = up(world.max_x_m() + gap);
    grid.begin_z = up(world.min_z_m());
    grid.columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
    return grid;
}

/// Copies of all that lies in an area, moved.
class Copier {
  public:
    Copier(const Area& area, Settings& settings)
        : area_(area),
          settings_(settings),
          boxes_(settings.boxes),
          doors_(settings.doors),
          platforms_(settings.platforms),
          triggers_(settings.triggers),
          surfaces_(settings.surfaces) {}

    void copy(const Vec3d& shift) {
        const Vec3 moved = shift.cast<float>();
        for (motion::StaticBox box : boxes_) {
            if (area_.holds(box.centre)) {
                box.centre += moved;
                settings_.boxes.push_back(box);
            }
        }
        for (NamedDoor door : doors_) {
            if (area_.holds(door.door.box.centre)) {
                door.door.box.centre += moved;
                if (door.door.by_rules) {
                    door.door.by_rules = static_cast<std::uint32_t>(settings_.doors.size());
                }
                settings_.doors.push_back(door);
            }
        }
        for (NamedPlatform platform : platforms_) {
            if (area_.holds(platform.platform.box.centre)) {
                platform.platform.box.centre += moved;
                if (platform.platform.path.by_rules) {
                    platform.platform.path.by_rules =
                        static_cast<std::uint32_t>(settings_.platforms.size());
                }
                settings_.platforms.push_back(platform);
            }
        }
        for (zone::Trigger trigger : triggers_) {
            if (area_.holds(trigger.box.centre)) {
                trigger.box.centre += moved;
                settings_.triggers.push_back(trigger);
            }
        }
        for (SurfaceSettings surface : surfaces_) {
            if (area_.holds(surface.position)) {
                surface.position += shift;
                settings_.surfaces.push_back(surface);
            }
        }
    }

  private:
    const Area& area_;
    Settings& settings_;
    // As they were before the first copy.
    std::vector<motion::StaticBox> boxes_;
    std::vector<NamedDoor> doors_;
    std::vector<NamedPlatform> platforms_;
    std::vector<zone::Trigger> triggers_;
    std::vector<SurfaceSettings> surfaces_;
};

std::shared_ptr<const zone::FirstState> first_state_of(const Area& area,
                                                       const Vec3d& centre,
                                                       const Settings& settings,
                                                       Diagnostics& diagnostics) {
    auto first = std::make_shared<zone::FirstState>();
    std::vector<int> place(settings.initial.size(), -1);
    for (std::size_t i = 0; i < settings.initial.size(); ++i) {
        const InitialEntity& from = settings.initial[i];
        if (!area.holds(from.position)) {
            continue;
        }
        place[i] = static_cast<int>(first->entities.size());
        zone::FirstState::FirstEntity& to = first->entities.emplace_back();
        to.name = from.name;
        to.def.type = from.type;
        to.def.position = (from.position - centre).cast<float>();
        to.def.orientation = from.orientation;
        to.def.yaw = from.yaw;
        to.def.asleep = from.asleep;
    }
    const auto place_of = [&](const JointEnd& end) {
        return end.entity < 0 ? -1 : place[static_cast<std::size_t>(end.entity)];
    };
    for (std::size_t j = 0; j < settings.placed_joints.size(); ++j) {
        const PlacedJoint& joint = settings.placed_joints[j];
        const int a = place_of(joint.a);
        const int b = place_of(joint.b);
        if (b < 0 ? a >= 0 : a < 0 && joint.a.entity >= 0) {
            diagnostics.add(area.path + ".area", "a joint leads out of it");
        } else if (b >= 0) {
            first->joints.push_back(
                {{a, joint.a.part}, {b, joint.b.part}, static_cast<std::uint16_t>(j)});
        }
    }
    return first;
}

zone::InstanceKind expand_kind(const Area& area,
                               const Grid& grid,
                               std::size_t first_cell,
                               Settings& settings,
                               Diagnostics& diagnostics) {
    const proto::config::Region& r = area.region();
    const Vec3d corner(r.min_x_m(), 0.0, r.min_z_m());
    const Vec3d centre = corner + 0.5 * Vec3d(area.wide_m(), 0.0, area.deep_m());
    zone::InstanceKind kind;
    kind.name = area.from->name();
    kind.close_ticks = std::lround(area.from->close_s() * settings.tick_rate_hz);
    for (const zone::SpawnPoint& point : settings.spawn_points) {
        if (area.holds(point.position)) {
            kind.entrances.push_back(point.position - centre);
        }
    }
    const auto first = first_state_of(area, centre, settings, diagnostics);
    Copier copier(area, settings);
    for (std::uint32_t n = 0; n < area.from->copies(); ++n) {
        const Vec3d shift = grid.corner(first_cell + n) - corner;
        copier.copy(shift);
        ZoneRegion& zone = settings.zones.emplace_back();
        zone.id = ZoneId(static_cast<std::uint16_t>(settings.zones.size()));
        zone.name = kind.name + "." + std::to_string(n + 1);
        zone.min_x = r.min_x_m() + shift.x();
        zone.min_z = r.min_z_m() + shift.z();
        zone.max_x = r.max_x_m() + shift.x();
        zone.max_z = r.max_z_m() + shift.z();
        kind.copies.push_back({zone.id, zone.origin()});
        settings.first_states.emplace(zone.id, first);
    }
    return kind;
}

}  // namespace

void expand_instances(const proto::config::Config& config,
                      Settings& settings,
                      Diagnostics& diagnostics) {
    settings.instances.reset();
    settings.first_states.clear();
    const std::vector<Area> areas = checked_areas(config, settings, diagnostics);
    if (areas.empty()) {
        return;
    }
    std::size_t copies = 0;
    for (const Area& area : areas) {
        copies += area.from->copies();
    }
    if (settings.zones.size() + copies > kMostZones) {
        diagnostics.add(areas.front().path,
                        std::to_string(copies) + " copies and " +
                            std::to_string(settings.zones.size()) + " zones are more than " +
                            std::to_string(kMostZones));
        return;
    }
    const Grid grid =
        grid_of(areas, config.world(), static_cast<double>(settings.ghost_margin_m), copies);
    const Vec3d farthest = grid.corner(grid.columns * grid.columns - 1);
    if (farthest.x() + grid.cell_x > kFarthest_m || farthest.z() + grid.cell_z > kFarthest_m) {
        diagnostics.add(areas.front().path,
                        "the copies reach beyond 50 km: fewer, smaller, or a smaller "
                        "zones.ghost_margin_m");
        return;
    }
    zone::InstanceSettings out;
    std::size_t cell = 0;
    for (const Area& area : areas) {
        out.kinds.push_back(expand_kind(area, grid, cell, settings, diagnostics));
        cell += area.from->copies();
    }
    std::erase_if(settings.spawn_points, [&](const zone::SpawnPoint& point) {
        return std::ranges::any_of(areas,
                                   [&](const Area& area) { return area.holds(point.position); });
    });
    if (settings.spawn_points.empty()) {
        diagnostics.add(areas.front().path, "leaves no spawn point for the world itself");
        return;
    }
    out.home = settings.spawn_points.front().position;
    settings.instances = std::move(out);
}

}  // namespace zoned::config
