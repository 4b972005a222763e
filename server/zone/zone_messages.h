// Zone messages: the messages between zones and to the world between the two halves of a tick:
// handoffs, messages of the rules, events to resolve.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/mailbox/messages.h"
#include "server/physics/joints/joint_state.h"
#include "server/physics/scene/scene.h"
#include "server/physics/soft/soft_bodies.h"
#include "server/replication/replication_settings.h"
#include "server/world/visibility.h"
#include "server/zone/assemblies/assembly_state.h"
#include "server/zone/context/rules_timers.h"
#include "server/zone/entity_serialization.h"
#include "server/zone/input_ring.h"
#include "shared/core/ids.h"
#include "shared/motion/burst.h"
#include "shared/motion/door_courses.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace zoned::zone {

/// A client whose avatar lives in the zone.
struct ZoneClient {
    ClientId client;
    EntityId avatar;
    std::uint32_t rights = 0;
    InputRing inputs;
    replication::OwnInput own;
    bool audit_due = false;
    std::uint16_t buttons_before = 0;  ///< of the tick before
    std::string account;               ///< empty: it cannot be known again
    std::string name;
};

/// A player is to go to another world of the cluster.
struct TravelWish {
    ClientId client;
    std::string world;
    std::string arrival;  ///< a place of that world; empty: where the character stood there last
};

/// A joint in transfer to another zone.
struct JointTransfer {
    EntityJoint joint;
    physics::JointState state;
};

/// An entity in transfer to another zone: all of its state.
struct Handoff {
    ZoneId from;
    ZoneId to;
    EntityState state;
    std::optional<ai::Agent> agent;
    std::uint16_t level = 0;         ///< of difficulty, by whose brains the agent lived
    physics::soft::SoftParcel soft;  ///< all nodes of a soft body; empty for others
    // With the last entity of an island, those of all:
    std::vector<JointTransfer> joints;
    std::vector<std::pair<EntityId, physics::BodyHistory>> histories;
    std::optional<Rider> ride;
    std::vector<std::uint8_t> rules;
    std::vector<RulesTimer> timers;  ///< of the entity
    std::optional<ZoneClient> client;
    std::vector<world::Visible> visible;   ///< the client's visible set, so that hysteresis goes on
    replication::ClientTransfer transfer;  ///< where client is set
};

/// A message of the rules to an entity, wherever it lives, or to a zone.
struct RulesMessage {
    EntityId target;
    std::vector<std::uint8_t> payload;
    std::optional<ZoneId> zone{};  ///< in place of `target`; a zone that is none: all of them
    EntityId user{};  ///< in place of a payload: uses `target`, which is a lever; none: a message
};

/// A number of the rules for the metrics.
struct RulesFigure {
    std::string name;
    double value = 0.0;
    bool counts = false;  ///< is added to what it was
};

enum class Audience : std::uint8_t {
    kClient,
    kTopic,
    kViewers
};

/// An event whose recipients the world resolves once all zones have stepped.
struct PendingEvent {
    mailbox::EventOut event;
    Audience audience = Audience::kClient;
    EntityId source;  ///< kViewers
};

/// Cosmetic particles that rules emitted. Clients whose nimbus reaches the place are notified when
/// all zones have stepped.
struct BurstOut {
    std::uint32_t system = 0;  ///< its number in the list that clients get at login
    motion::Burst burst;       ///< its position is in world coordinates
    float aura_m = 0.0F;
    bool line_of_sight = false;
};

/// Rules change the rate of a shared clock from a later tick on.
struct ClockChange {
    std::size_t clock = 0;
    Tick from = 0;
    double rate_per_s = 0.0;
};

/// Rules open or shut a door from a later tick on.
struct DoorChange {
    std::uint32_t door = 0;  ///< of the world
    motion::DoorCourse course;
};

/// Rules send a platform to a stop from a later tick on.
struct PlatformChange {
    std::uint32_t platform = 0;  ///< of the world
    Tick from = 0;
    Tick to = 0;  ///< ticks along its way
};

struct TopicChange {
    ClientId client;
    std::string topic;
    bool subscribe = true;
};

}  // namespace zoned::zone
