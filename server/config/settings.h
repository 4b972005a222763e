// Settings: the checked config as plain structs, in the form that each stage needs.
#pragma once

#include "server/ai/agent/ai_settings.h"
#include "server/config/server_settings.h"
#include "server/interest/interest_rule.h"
#include "server/physics/method_selection/method_choice.h"
#include "server/physics/scene/scene.h"
#include "server/physics/soft/soft_def.h"
#include "server/replication/replicator.h"
#include "server/scripting/script_settings.h"
#include "server/world/entity_type.h"
#include "server/zone/groups/first_state.h"
#include "server/zone/groups/instance.h"
#include "server/zone/groups/match.h"
#include "server/zone/groups/party.h"
#include "server/zone/rules.h"
#include "server/zone/zone_settings.h"
#include "shared/clock/shared_environment.h"
#include "shared/motion/burst.h"
#include "shared/motion/static_geometry.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}

namespace zoned::config {

/// The rectangle of a zone, world coordinates, m. Local (0, 0, 0) is its centre at y = 0.
struct ZoneRegion {
    ZoneId id;
    std::string name;
    double min_x = 0.0;
    double min_z = 0.0;
    double max_x = 0.0;
    double max_z = 0.0;

    [[nodiscard]] Vec3d origin() const {
        return {0.5 * (min_x + max_x), 0.0, 0.5 * (min_z + max_z)};
    }
};

/// A surface that the config places. Uses of the same file with the same options share shape and
/// surface.
struct SurfaceSettings {
    std::string path;     ///< of the setting, e.g. "statics.surface[2]"
    std::string file;     ///< as opened
    std::string content;  ///< hex SHA-256 of its baked form: the geometry itself
    physics::Shape shape;
    std::shared_ptr<const motion::Surface> surface;  ///< refers to the tables of `shape`
    float level_m = 0.0F;            ///< height of one step of the image; 0: not from an image
    Vec3d position = Vec3d::Zero();  ///< world coordinates, m
    Quat orientation = Quat::Identity();
    float friction = 0.6F;
    float restitution = 0.0F;
    bool replicated = true;

    /// In zone-local coordinates around `origin`, or in the world's.
    [[nodiscard]] motion::StaticSurface around(const Vec3d& origin) const {
        return {surface, (position - origin).cast<float>(), orientation};
    }
};

/// An entity that exists when the world begins (scatter entries of the config are expanded to these
/// by seed).
struct InitialEntity {
    TypeIndex type = 0;
    Vec3d position = Vec3d::Zero();  ///< world coordinates, m
    Quat orientation = Quat::Identity();
    std::uint16_t yaw = 0;
    bool asleep = false;  ///< props: sleeps until it is touched
    std::string name;     ///< by which joints refer to it; may be empty
};

/// A body that a placed joint holds.
struct JointEnd {
    int entity = -1;         ///< in Settings::initial; -1: the world
    std::uint16_t part = 0;  ///< of its assembly
};

/// A joint between entities of the world's beginning.
struct PlacedJoint {
    std::shared_ptr<const zone::JointPlan> plan;
    JointEnd a;
    JointEnd b;
};

/// A door of the config, world coordinates (float: worlds are some km).
struct NamedDoor {
    std::string name;
    motion::Door door;
};

/// A platform of the config, world coordinates.
struct NamedPlatform {
    std::string name;
    motion::Platform platform;
};

/// Cosmetic particles: only clients receive their description.
struct CosmeticSystem {
    std::string name;
    Vec3 gravity = Vec3::Zero();             ///< m/s2
    float drag = 0.0F;                       ///< 1/s
    Vec3 wind = Vec3::Zero();                ///< m/s
    std::vector<motion::Emitter> emitters;   ///< world coordinates (float: worlds are some km)
    std::optional<motion::BurstKind> burst;  ///< none: no event emits any
};

/// The method that moves a part of the world, and the reason.
struct MethodPlan {
    std::string subject;  ///< "bodies", "particles", "soft type curtain"
    std::string used;     ///< "default x 1"; empty: there is nothing to move
    std::string reason;
    std::optional<physics::method_selection::MethodChoice>
        choice;  ///< where a budget asked for one
};

/// Error budgets of the whole world; 0: none.
struct WorldBudgets {
    double position_m = 0.0;
    double orientation_rad = 0.0;
    double time_s = 0.0;
    double bytes_per_client_s = 0.0;
    double cpu_us_per_tick = 0.0;
};

/// The value of a behaviour's parameter for a type, and its origin. A behaviour without parameters
/// has one entry without a name.
struct ParameterChoice {
    std::string type;
    std::string behaviour;
    std::string parameter;
    double value = 0.0;
    std::string reason;
};

/// Everything that a server needs to know, checked.
struct Settings {
    /// As read, after --set, with the SHA-256 of each surface's file; types are complete, and
    /// brains stand for their behaviours. Null for settings made without a config.
    std::shared_ptr<const proto::config::Config> config;
    std::string world_name = "world";
    std::string digest;  ///< hex SHA-256 of the canonical form of the parts that clients depend on
    std::string text;    ///< canonical text form of the whole config as read, for recordings
    double tick_rate_hz = 30.0;
    std::uint64_t seed = 1;
    world::TypeTable types;  ///< of the config, then parts of assemblies
    std::shared_ptr<const zone::AssemblyTable> assemblies =
        std::make_shared<const zone::AssemblyTable>();
    std::vector<physics::Shape> solids;  ///< hulls and compounds of types, by EntityType::solid
    std::vector<physics::Shape> outers;  ///< hulls around these, where a type asks for them
    /// Soft bodies of types, by EntityType::solid; about their centres of mass, shared by all
    /// zones.
    std::vector<std::shared_ptr<const physics::soft::SoftDef>> softs;
    std::vector<ZoneRegion> zones;  ///< index = ZoneId - 1
    float ghost_margin_m = 120.0F;
    float handoff_hysteresis_m = 2.0F;
    std::vector<motion::StaticBox> boxes;  ///< world coordinates (float: worlds are some km)
    std::vector<NamedDoor> doors;
    std::vector<NamedPlatform> platforms;
    std::vector<zone::Trigger> triggers;
    std::vector<SurfaceSettings> surfaces;
    float ground_height_m = 0.0F;
    std::vector<InitialEntity> initial;
    std::vector<PlacedJoint> placed_joints;
    std::vector<zone::SpawnPoint> spawn_points;   ///< at least one; players are spread over them; y
                                                  ///< is where the centre of the tallest character
                                                  ///< without an agent stands
    std::vector<zone::ParticleSource> particles;  ///< simulated ones
    std::vector<CosmeticSystem> cosmetics;
    std::vector<zone::CosmeticBurst> cosmetic_bursts;  ///< of the systems with a burst
    physics::PhysicsSettings physics;
    WorldBudgets budgets;
    /// Origin of the methods in `physics` and `softs`, and of settings that `budgets` decide.
    std::vector<MethodPlan> methods;
    std::vector<ParameterChoice> parameters;  ///< in the order of types and precedence
    std::vector<std::string> stances;  ///< of the config's own, from world::kFirstNamedStance on
    ai::AiSettings ai;
    interest::InterestSettings interest;
    replication::ReplicationSettings replication;
    clock::EnvironmentDefs environment;
    zone::VisibilityFilterSettings visibility_filter;
    zone::RewindSettings rewind;
    zone::AuditSettings audit{false, 30};
    std::optional<zone::PartySettings> parties;
    std::optional<zone::InstanceSettings> instances;
    std::optional<zone::MatchSettings> matches;
    std::map<ZoneId, std::shared_ptr<const zone::FirstState>> first_states;  ///< of the copies
    zone::RulesSettings rules;
    std::optional<scripting::ScriptSettings> script;  ///< none: the linked rules
    ServerSettings server;
};

}  // namespace zoned::config
