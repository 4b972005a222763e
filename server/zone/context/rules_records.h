// Records that pass between the rules of a game and their zone: events, contacts, readings,
// requests.
#pragma once

#include "server/world/entities.h"
#include "server/zone/assemblies/assembly_state.h"
#include "shared/core/ids.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::zone {

using Bytes = std::vector<std::uint8_t>;

/// Event kinds below this belong to the server (see proto/session.proto, CoreEventKind), the others
/// to the rules.
inline constexpr std::uint16_t kFirstRulesEvent = 16;

/// Free-form settings of the rules from the config (`rules { name: "..." value: "..." }`).
using RulesSettings = std::vector<std::pair<std::string, std::string>>;

/// Of the stances that every world has.
inline constexpr std::array<std::string_view, world::kFirstNamedStance> kStanceNames = {"normal",
                                                                                        "idle",
                                                                                        "running",
                                                                                        "riding"};

/// The entity to spawn. Positions are zone-local, m.
struct SpawnDef {
    TypeIndex type = 0;
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();
    Vec3 angular_velocity = Vec3::Zero();
    std::uint16_t yaw = 0;  ///< characters
    std::uint16_t appearance = 0;
    ClientId client;      ///< the client whose avatar it shall be, or none
    bool asleep = false;  ///< props: starts at rest
};

/// Two entities touch, or one touches the static world (its other side is none). Neither began nor
/// ended: it lasts.
struct EntityContact {
    EntityId a;
    EntityId b;
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitY();  ///< from a to b
    float impulse = 0.0F;         ///< of this step, N s
    float approach_speed = 0.0F;  ///< m/s
    bool began = false;
    /// They parted, or one of them is gone from this zone's bodies (despawned, hidden, handed off,
    /// teleported): its id may name nobody any more.
    bool ended = false;
};

// Entities that are soft bodies (their type has soft { ... }): position is the centre of mass of
// their nodes. near() finds them; ray_cast() goes through them, and their touches are not reported
// as contacts. The other rules for them stand below.

/// The contacts that rules are notified of, besides those that begin and those with an impulse of
/// more than physics::PhysicsSettings::event_impulse_ns.
struct ContactWish {
    bool lasts = false;  ///< in each step after the first, while one of the two is awake
    bool ends = false;
};

/// A joint as it is after the last step.
struct JointReading {
    EntityId a;  ///< none: the world
    EntityId b;
    /// Angle of a hinge, rad in (-pi, pi]; shift of a slider, m; length of a distance or spring, m;
    /// gap of a ball or fixed joint, m.
    float position = 0.0F;
    float force_n = 0.0F;  ///< of the last step
    bool motor = false;
    float target = 0.0F;  ///< of the motor: rad/s or rad, m/s or m
};

/// An entity's centre came into a trigger of the config, or left it: by moving, or because the
/// entity is gone from this zone (despawned, hidden, handed off).
struct TriggerEvent {
    std::string_view trigger;  ///< its name
    EntityId entity;
    bool entered = false;
};

/// A player has used a lever (`type { lever { } }`), which has turned.
struct LeverUse {
    EntityId lever;
    EntityId user;    ///< the avatar; may be another zone's
    bool on = false;  ///< as it is now
};

/// An agent as it is after its last decision. The names are the config's, and good during the call.
struct AgentReading {
    std::string_view brain;
    std::string_view state;
    std::string_view action;  ///< the state itself, or what it chose
    Vec3 home = Vec3::Zero();
    EntityId target;  ///< the entity that it noticed or remembers; none: nobody
};

/// A joint that pulled harder than it bears.
struct BrokenJoint {
    EntityJointId joint;
    EntityId a;  ///< none: the world
    EntityId b;
    EntityId root;     ///< of the assembly that it held together; none: of none
    std::string name;  ///< of the config
    float force_n = 0.0F;
};

/// A call that rules asked for, (counter << 16) | zone.
using TimerId = StrongId<struct TimerTag, std::uint64_t>;

/// Of a zone, beyond which rules can add none: a loop of theirs that never ends one meets an end.
inline constexpr std::size_t kMostJoints = 10'000;
inline constexpr std::size_t kMostLogLines = 100;
inline constexpr std::size_t kMostLogBytes = 1024;
inline constexpr std::size_t kMostRulesFigures = 100;

/// A timer that is due.
struct DueTimer {
    TimerId id;
    EntityId entity;  ///< none: the zone's own
    std::uint16_t kind = 0;
    Bytes payload;
};

/// A reliable event of the rules.
struct RulesEvent {
    std::uint16_t kind = kFirstRulesEvent;  ///< >= kFirstRulesEvent
    Bytes payload;
    bool confirm = false;  ///< each recipient must confirm; on_confirm is called when it does
    /// Kept in the store, and sent when that and all that the zones wrote up to this tick is
    /// durable: what it tells, no crash undoes. Other events may overtake it.
    bool durable = false;
};

struct RayResult {
    bool hit = false;
    EntityId entity;  ///< none when the static world was hit
    float distance = 0.0F;
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitY();
};

/// An entity as a client says that its view displayed it.
struct SeenEntity {
    EntityId entity;
    Vec3 position = Vec3::Zero();  ///< where, zone-local, m
    Tick publication = -1;         ///< a view of the present: whose prediction it was
};

/// The state that a client says its view displayed when it acted. Hostile.
struct Seen {
    enum class DisplayedTime : std::uint8_t {
        kPresent,  ///< predicted from publications to `tick`
        kPast,     ///< interpolated
    };

    DisplayedTime view = DisplayedTime::kPresent;
    Tick tick = 0;                         ///< that was displayed of others
    float fraction = 0.0F;                 ///< of the tick after it, 0..1
    EntityId aimed;                        ///< the entity that the ray hit there; none: nothing
    std::span<const SeenEntity> entities;  ///< those near the ray
};

struct SeenHit : RayResult {
    float rewound_s = 0.0F;   ///< by how much entities were set back
    bool cut = false;         ///< the displayed tick was beyond the bound, or in the future
    bool doubted = false;     ///< an entity near the ray was not where it was said to be displayed
    bool aimed_near = false;  ///< the ray passed Seen::aimed within about 2 m of its surface
};

}  // namespace zoned::zone
