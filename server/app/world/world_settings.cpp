#include "server/app/world/world_settings.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/zone_setup.h"
#include "shared/core/assert.h"
#include "shared/core/containers/union_find.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

namespace zoned::app {

namespace {

/// Whether a surface overlaps the region, grown by a margin for ghosts and reach.
bool reaches(const config::SurfaceSettings& surface, const zone::Region& region, double margin) {
    const Vec3d origin = region.origin();
    const motion::PlacedSurface placed(surface.around(origin));
    const Vec3d lower = origin + placed.bounds().lower.cast<double>();
    const Vec3d upper = origin + placed.bounds().upper.cast<double>();
    return upper.x() >= region.min_x - margin && lower.x() <= region.max_x + margin &&
           upper.z() >= region.min_z - margin && lower.z() <= region.max_z + margin;
}

bool reaches(const motion::StaticBox& box, const zone::Region& region, double margin) {
    return region.outside(box.centre.x(), box.centre.z()) <=
           margin + static_cast<double>(box.half_extents.norm());
}

/// Whether a platform ever comes within a margin of the region.
bool reaches(const motion::Platform& platform, const zone::Region& region, double margin) {
    Vec3 lower = platform.box.centre;
    Vec3 upper = lower;
    for (const motion::PlatformStop& stop : platform.path.stops) {
        lower = lower.cwiseMin(platform.box.centre + stop.offset);
        upper = upper.cwiseMax(platform.box.centre + stop.offset);
    }
    const double reach = margin + static_cast<double>(platform.box.half_extents.norm());
    return upper.x() >= region.min_x - reach && lower.x() <= region.max_x + reach &&
           upper.z() >= region.min_z - reach && lower.z() <= region.max_z + reach;
}

motion::StaticBox around(const motion::StaticBox& box, const Vec3d& origin) {
    motion::StaticBox moved = box;
    moved.centre = (box.centre.cast<double>() - origin).cast<float>();
    return moved;
}

/// Static boxes, doors, platforms and surfaces that can be touched from within the region: those
/// that overlap it, grown by a margin for ghosts and reach.
motion::StaticGeometry local_statics(const config::Settings& settings, const zone::Region& region) {
    const Vec3d origin = region.origin();
    const auto margin = static_cast<double>(settings.ghost_margin_m);
    std::vector<motion::StaticBox> local;
    for (const motion::StaticBox& box : settings.boxes) {
        if (reaches(box, region, margin)) {
            local.push_back(around(box, origin));
        }
    }
    std::vector<motion::Door> doors;
    for (const config::NamedDoor& named : settings.doors) {
        if (reaches(named.door.box, region, margin)) {
            motion::Door& door = doors.emplace_back(named.door);
            door.box = around(door.box, origin);
        }
    }
    std::vector<motion::Platform> platforms;
    for (const config::NamedPlatform& named : settings.platforms) {
        if (reaches(named.platform, region, margin)) {
            motion::Platform& platform = platforms.emplace_back(named.platform);
            platform.box = around(platform.box, origin);
        }
    }
    std::vector<motion::StaticSurface> surfaces;
    for (const config::SurfaceSettings& surface : settings.surfaces) {
        if (reaches(surface, region, margin)) {
            surfaces.push_back(surface.around(origin));
        }
    }
    return motion::StaticGeometry(std::move(local),
                                  settings.ground_height_m,
                                  motion::kStaticCell_m,
                                  surfaces,
                                  std::move(doors),
                                  std::move(platforms));
}

std::vector<zone::Trigger> local_triggers(const config::Settings& settings,
                                          const zone::Region& region) {
    std::vector<zone::Trigger> local;
    for (const zone::Trigger& trigger : settings.triggers) {
        if (reaches(trigger.box, region, static_cast<double>(settings.handoff_hysteresis_m))) {
            local.push_back({trigger.name, around(trigger.box, region.origin()), trigger.notices});
        }
    }
    return local;
}

/// The same surfaces as bodies.
std::vector<zone::SurfaceBody> local_surfaces(const config::Settings& settings,
                                              const zone::Region& region) {
    std::vector<zone::SurfaceBody> bodies;
    for (const config::SurfaceSettings& surface : settings.surfaces) {
        if (reaches(surface, region, static_cast<double>(settings.ghost_margin_m))) {
            const motion::StaticSurface placed = surface.around(region.origin());
            physics::Material material;
            material.friction = surface.friction;
            material.restitution = surface.restitution;
            bodies.push_back({surface.shape, placed.position, placed.orientation, material});
        }
    }
    return bodies;
}

std::size_t zone_holding(const std::vector<zone::Region>& regions, const Vec3d& place) {
    const auto region = std::find_if(regions.begin(), regions.end(), [&](const zone::Region& r) {
        return r.outside(place.x(), place.z()) == 0.0;
    });
    ZONED_ASSERT(region != regions.end(), "initial entities were checked to lie in the world");
    return static_cast<std::size_t>(region - regions.begin());
}

}  // namespace

std::vector<zone::Region> regions_of(const config::Settings& settings) {
    std::vector<zone::Region> regions;
    for (const config::ZoneRegion& z : settings.zones) {
        regions.push_back({z.id, z.min_x, z.min_z, z.max_x, z.max_z});
    }
    return regions;
}

zone::ZoneSettings zone_settings(const config::Settings& settings,
                                 ZoneId id,
                                 const std::shared_ptr<const world::TypeTable>& types,
                                 const std::shared_ptr<const motion::DoorCourses>& doors,
                                 const std::shared_ptr<const motion::PlatformCourses>& platforms) {
    zone::ZoneSettings z;
    z.id = id;
    z.regions = regions_of(settings);
    z.ghost_margin_m = settings.ghost_margin_m;
    z.handoff_hysteresis_m = settings.handoff_hysteresis_m;
    z.dt = static_cast<float>(1.0 / settings.tick_rate_hz);
    z.seed = settings.seed;
    z.types = types;
    z.assemblies = settings.assemblies;
    std::vector<std::shared_ptr<const zone::JointPlan>> placed;
    for (const config::PlacedJoint& joint : settings.placed_joints) {
        placed.push_back(joint.plan);
    }
    z.placed_joints = std::make_shared<const std::vector<std::shared_ptr<const zone::JointPlan>>>(
        std::move(placed));
    if (const auto first = settings.first_states.find(id); first != settings.first_states.end()) {
        z.first_state = first->second;
    }
    z.solids = settings.solids;
    z.outers = settings.outers;
    z.softs = settings.softs;
    z.statics = std::make_shared<const motion::StaticGeometry>(
        local_statics(settings, z.region()).with_courses(doors, platforms));
    z.door_courses = doors;
    z.platform_courses = platforms;
    for (const config::NamedPlatform& named : settings.platforms) {
        const motion::PlatformPath& path = named.platform.path;
        if (path.by_rules) {
            zone::PlatformName& name = z.platforms.emplace_back();
            name.name = named.name;
            name.platform = *path.by_rules;
            name.start = path.start;
            name.here = reaches(named.platform, z.region(), 0.0);
            for (const motion::PlatformStop& stop : path.stops) {
                name.stops.push_back(stop.at);
            }
        }
    }
    for (const config::NamedDoor& named : settings.doors) {
        z.doors.push_back({named.name,
                           named.door.by_rules.has_value(),
                           !named.door.times.open.empty(),
                           reaches(named.door.box, z.region(), 0.0)});
    }
    z.triggers = local_triggers(settings, z.region());
    z.spawn_points = settings.spawn_points;
    z.surfaces = local_surfaces(settings, z.region());
    z.particles = settings.particles;
    z.cosmetic_bursts = settings.cosmetic_bursts;
    z.physics = settings.physics;
    // Each sleeping entity has its pair with the ground. Their number must leave room for the pairs
    // of those that are awake.
    z.physics.max_pairs =
        std::max(z.physics.max_pairs, static_cast<std::uint32_t>(2 * settings.initial.size()));
    z.ai = settings.ai;
    z.interest = settings.interest;
    z.visibility_filter = settings.visibility_filter;
    z.rewind = settings.rewind;
    z.in_cluster = !settings.server.cluster.name.empty();
    z.stances = settings.stances;
    z.replication = settings.replication;
    z.audit = settings.audit;
    return z;
}

std::string paths_defect(const config::Settings& settings) {
    if (settings.ai.pathfinding.map != ai::PathMapKind::kNavmesh) {
        return {};  // other maps tell when they are baked; the settings of zones cost time
    }
    const auto types = std::make_shared<const world::TypeTable>(settings.types);
    for (const config::ZoneRegion& zone : settings.zones) {
        const std::string defect =
            zone::paths_defect(zone_settings(settings, zone.id, types, nullptr, nullptr));
        if (!defect.empty()) {
            return "zone " + std::to_string(zone.id.value) + ": " + defect;
        }
    }
    return {};
}

void populate(const config::Settings& settings,
              const std::vector<zone::Region>& regions,
              std::span<const std::unique_ptr<zone::Zone>> zones) {
    // Entities that joints hold together begin in one zone: that of the first of them.
    core::UnionFind groups;
    groups.reset(settings.initial.size());
    for (const config::PlacedJoint& joint : settings.placed_joints) {
        if (joint.a.entity >= 0) {
            groups.join(static_cast<std::uint32_t>(joint.a.entity),
                        static_cast<std::uint32_t>(joint.b.entity));
        }
    }
    std::vector<std::size_t> zone_of(settings.initial.size(), regions.size());
    std::vector<EntityId> spawned;
    for (std::size_t i = 0; i < settings.initial.size(); ++i) {
        const config::InitialEntity& initial = settings.initial[i];
        std::size_t& home = zone_of[groups.root(static_cast<std::uint32_t>(i))];
        if (home == regions.size()) {
            home = zone_holding(regions, initial.position);
        }
        zone::SpawnDef def;
        def.type = initial.type;
        def.position = (initial.position - regions[home].origin()).cast<float>();
        def.orientation = initial.orientation;
        def.yaw = initial.yaw;
        def.asleep = initial.asleep;
        spawned.push_back(zones[home]->spawn(def));
    }
    std::map<std::string, EntityId, std::less<>> names;
    for (std::size_t i = 0; i < spawned.size(); ++i) {
        if (!settings.initial[i].name.empty()) {
            names.emplace(settings.initial[i].name, spawned[i]);
        }
    }
    for (const auto& zone : zones) {
        zone->name_entities(names);
    }
    for (std::size_t j = 0; j < settings.placed_joints.size(); ++j) {
        const config::PlacedJoint& joint = settings.placed_joints[j];
        const auto b = static_cast<std::uint32_t>(joint.b.entity);
        zone::Zone& home = *zones[zone_of[groups.root(b)]];
        const auto entity_of = [&](const config::JointEnd& end) {
            return end.entity < 0
                       ? EntityId()
                       : zone::part_id(
                             home.state(), spawned[static_cast<std::size_t>(end.entity)], end.part);
        };
        const auto made =
            home.join_placed(entity_of(joint.a), entity_of(joint.b), static_cast<std::uint16_t>(j));
        ZONED_ASSERT(made.ok(), "placed joints were checked when the config was read");
    }
}

}  // namespace zoned::app
