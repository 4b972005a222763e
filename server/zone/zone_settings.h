// ZoneSettings: the facts of the world, of one zone and of its neighbours that the zone needs.
#pragma once

#include "server/ai/agent/ai_settings.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "server/interest/interest_rule.h"
#include "server/physics/particles/particle_systems.h"
#include "server/physics/scene/scene.h"
#include "server/physics/soft/soft_def.h"
#include "server/replication/replication_settings.h"
#include "server/world/entity_type.h"
#include "server/zone/assemblies/assembly_def.h"
#include "server/zone/context/spawn_points.h"
#include "server/zone/context/triggers.h"
#include "server/zone/groups/first_state.h"
#include "shared/clock/shared_environment.h"
#include "shared/motion/burst.h"
#include "shared/motion/static_geometry.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::zone {

/// A rectangle of the world, m, world coordinates; half-open [min, max) except at the world's own
/// edge.
struct Region {
    ZoneId id;
    double min_x = 0.0;
    double min_z = 0.0;
    double max_x = 0.0;
    double max_z = 0.0;

    /// World coordinates of the zone's local (0, 0, 0).
    [[nodiscard]] Vec3d origin() const {
        return {0.5 * (min_x + max_x), 0.0, 0.5 * (min_z + max_z)};
    }

    /// How far a point lies outside, m; 0 inside.
    [[nodiscard]] double outside(double x, double z) const {
        const double dx = x < min_x ? min_x - x : (x > max_x ? x - max_x : 0.0);
        const double dz = z < min_z ? min_z - z : (z > max_z ? z - max_z : 0.0);
        return dx > dz ? dx : dz;
    }
};

/// The area in which agents of a zone plan paths, zone-local, m: its region and two cells more than
/// the distance at which a leaving agent passes to another zone.
inline ai::pathfinding::GroundRect paths_area(double wide_m,
                                              double deep_m,
                                              float hysteresis_m,
                                              float cell_m) {
    const float margin = hysteresis_m + 2.0F * cell_m;
    const float x = static_cast<float>(0.5 * wide_m) + margin;
    const float z = static_cast<float>(0.5 * deep_m) + margin;
    return {-x, -z, x, z};
}

struct AuditSettings {
    bool enabled = false;
    std::uint32_t period_ticks = 15;  ///< an audited client gets a record this often
};

/// A static surface from a file as a body; characters meet it in ZoneSettings::statics.
struct SurfaceBody {
    physics::Shape shape;  ///< a mesh or a heightfield
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
    physics::Material material;
};

/// A particle system that rules may ask about, for the whole world.
struct ParticleSource {
    physics::ParticleSystemDef def;  ///< without the solids to hit; a flock in world coordinates
    std::vector<motion::Emitter> emitters;   ///< but for their positions:
    std::vector<Vec3d> positions;            ///< of `emitters`, world coordinates, m
    std::optional<motion::BurstKind> burst;  ///< none: rules may not let any out
    std::uint32_t characters_met = 0;        ///< as balls, at most kernels::ZK_MOST_SPHERES
};

/// A cosmetic system whose bursts rules may emit. Clients that hear the place get one event each,
/// and nothing is simulated.
struct CosmeticBurst {
    std::string name;
    std::uint32_t system = 0;  ///< its number in the list that clients get at login
    motion::BurstKind kind;
    float aura_m = 50.0F;
    float events_per_s = 20.0F;  ///< of this zone; a second's worth may come at once
    bool line_of_sight = false;  ///< hidden from clients that do not see the place
};

/// The schedule of tests for types that conceal themselves.
struct VisibilityFilterSettings {
    std::uint32_t checks_per_tick = 2000;  ///< pairs
    std::uint32_t stale_ticks = 8;         ///< an answer counts so long
    std::uint32_t grace_ticks = 10;        ///< a known entity stays known so long
};

/// How far back the world may be set for a shot (viewers/lag_compensation.h).
struct RewindSettings {
    Tick most_ticks = 15;   ///< limit of the search back for the displayed state; >= 0
    float slack_m = 0.15F;  ///< how far a claim may be from its explanation
};

/// A door of the world.
struct DoorName {
    std::string name;
    bool by_rules = false;
    bool starts_open = false;  ///< one that rules move
    bool here = false;         ///< reaches into this zone: each instance has one of its name
};

/// A platform of the world that rules move.
struct PlatformName {
    std::string name;
    std::uint32_t platform = 0;  ///< its number in the world
    std::vector<Tick> stops;     ///< ticks along its way
    Tick start = 0;              ///< where it stands until rules move it
    bool here = false;           ///< reaches into this zone: each instance has one of its name
};

struct ZoneSettings {
    ZoneId id;
    std::vector<Region> regions;  ///< all zones of the world, index = ZoneId - 1
    float ghost_margin_m = 120.0F;
    float handoff_hysteresis_m = 2.0F;
    float dt = 1.0F / 30.0F;  ///< s
    std::uint64_t seed = 1;
    std::shared_ptr<const world::TypeTable> types;
    std::shared_ptr<const AssemblyTable> assemblies;  ///< may be null where no type is a part
    /// Joints between placed entities, by number.
    std::shared_ptr<const std::vector<std::shared_ptr<const JointPlan>>> placed_joints;
    std::shared_ptr<const FirstState> first_state;  ///< null: the zone is no copy for instances
    std::vector<physics::Shape> solids;  ///< hulls and compounds of types, by EntityType::solid
    std::vector<physics::Shape> outers;  ///< hulls around these, where a type asks for them
    /// Soft bodies of types, by EntityType::solid; about their centres of mass, shared by all
    /// zones.
    std::vector<std::shared_ptr<const physics::soft::SoftDef>> softs;
    std::shared_ptr<const motion::StaticGeometry> statics;    ///< zone-local
    std::vector<DoorName> doors;                              ///< of the whole world
    std::shared_ptr<const motion::DoorCourses> door_courses;  ///< of `doors`; null: rules move none
    std::vector<PlatformName> platforms;                      ///< of the whole world
    std::shared_ptr<const motion::PlatformCourses> platform_courses;  ///< null: rules move none
    std::vector<SpawnPoint> spawn_points;                             ///< of the whole world
    std::vector<Trigger> triggers;                                    ///< zone-local
    std::vector<SurfaceBody> surfaces;      ///< those of `statics`, zone-local
    std::vector<ParticleSource> particles;  ///< simulated ones, of all zones
    std::vector<CosmeticBurst> cosmetic_bursts;
    physics::PhysicsSettings physics;
    ai::AiSettings ai;
    interest::InterestSettings interest;
    VisibilityFilterSettings visibility_filter;
    RewindSettings rewind;
    std::vector<std::string> stances;  ///< the config's own, from kFirstNamedStance on
    replication::ReplicationSettings replication;
    std::shared_ptr<const clock::SharedEnvironment>
        environment;  ///< of the whole world; may be null
    AuditSettings audit;
    bool in_cluster = false;  ///< there are other worlds to go to
    bool maps_later = false;  ///< whoever makes the zone calls make_paths() before its first tick

    [[nodiscard]] const Region& region() const { return regions[id.value - 1U]; }

    /// The first zone whose region holds a point of the world; none outside.
    [[nodiscard]] ZoneId owner_of(double x, double z) const {
        for (const Region& r : regions) {
            if (r.outside(x, z) == 0.0) {
                return r.id;
            }
        }
        return ZoneId();
    }
};

}  // namespace zoned::zone
