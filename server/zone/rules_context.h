// RulesContext: what the rules of a game see of their zone and do in it, during a call.
#pragma once

#include "server/mailbox/messages.h"
#include "server/world/entities.h"
#include "server/zone/assemblies/assembly_state.h"
#include "server/zone/context/rules_records.h"
#include "server/zone/context/spawn_points.h"
#include "shared/core/ids.h"
#include "shared/core/rng.h"
#include "shared/motion/input_command.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::zone {

class RulesInstances;
class RulesMatches;
class RulesParties;

/// The view and the actions of rules during a call. Changes to owned entities take effect at once;
/// entities of other zones (ghosts) are read-only: reach them by message().
class RulesContext {
  public:
    virtual ~RulesContext() = default;

    [[nodiscard]] virtual Tick now() const = 0;
    [[nodiscard]] virtual float dt() const = 0;
    [[nodiscard]] virtual ZoneId zone() const = 0;
    /// World coordinates of this zone's local (0, 0, 0), m. Rules keep a position that outlives
    /// handoffs (a spawn position, say) in world coordinates.
    [[nodiscard]] virtual Vec3d origin() const = 0;
    [[nodiscard]] virtual const world::Entities& entities() const = 0;
    [[nodiscard]] virtual const world::TypeTable& types() const = 0;
    /// Index of the type with this name; aborts when there is none (rules check their types in
    /// their constructor).
    [[nodiscard]] virtual TypeIndex type_named(std::string_view name) const = 0;
    [[nodiscard]] virtual core::Rng& rng() = 0;  ///< seeded per zone

    /// The present value of a shared clock or a shared variable of the config, the same in every
    /// zone and on every client; none where the world has neither of that name.
    [[nodiscard]] virtual std::optional<double> shared_value(std::string_view name) const {
        (void)name;
        return std::nullopt;
    }

    /// From `ahead_s` on (at least half a second, so that all clients know in time) the clock runs
    /// at this rate, in place of the rates announced for then and later. False where there is none
    /// of that name, or the numbers are not finite.
    virtual bool set_clock_rate(std::string_view name, double rate_per_s, double ahead_s) {
        (void)name;
        (void)rate_per_s;
        (void)ahead_s;
        return false;
    }

    /// Opens or shuts a door of the config that rules move (`door { moved_by: RULES }`), in
    /// whatever zone it is, from `ahead_s` on (at least half a second, so that all clients know in
    /// time), in place of what was asked for then and later. False where there is no such door,
    /// `ahead_s` is out of range, or the door has as many turns ahead as are kept
    /// (motion::DoorCourses).
    virtual bool set_door(std::string_view name, bool open, double ahead_s) {
        (void)name;
        (void)open;
        (void)ahead_s;
        return false;
    }

    /// Whether a door that rules move is open now; none where there is no such door.
    [[nodiscard]] virtual std::optional<bool> door_open(std::string_view name) const {
        (void)name;
        return std::nullopt;
    }

    /// Sends a platform of the config that rules move (`platform { moved_by: RULES }`) to a stop, 0
    /// being the first, in whatever zone it is, from `ahead_s` on (at least half a second), in
    /// place of what was asked for then and later. It turns round where it is and passes stops
    /// between without waiting. False where there is no such platform or stop, `ahead_s` is out of
    /// range, or as many courses are ahead as are kept (motion::PlatformCourses).
    virtual bool move_platform(std::string_view name, std::uint32_t stop, double ahead_s) {
        (void)name;
        (void)stop;
        (void)ahead_s;
        return false;
    }

    /// The stop at which a platform that rules move stands now; none where there is no such
    /// platform, or it is between stops.
    [[nodiscard]] virtual std::optional<std::uint32_t> platform_stop(std::string_view name) const {
        (void)name;
        return std::nullopt;
    }

    /// The entity that the config placed under this name (`entity { name: "..." }`), in whatever
    /// zone it is by now; none where there is no such name. It may be gone: ids are never reused.
    [[nodiscard]] virtual EntityId entity_named(std::string_view name) const {
        (void)name;
        return {};
    }

    /// The spawn points of the config, of all zones.
    [[nodiscard]] virtual std::span<const SpawnPoint> spawn_points() const { return {}; }

    /// Of a team's points (zone::spawn_points_of) the one that is farthest from all players: of
    /// this zone, or of the world where the team has none here. nullptr: there is no point at all.
    [[nodiscard]] virtual const SpawnPoint* freest_spawn(std::string_view team) const {
        (void)team;
        return nullptr;
    }

    /// Zone-local coordinates of a place of the world.
    [[nodiscard]] Vec3 local(const Vec3d& place) const { return (place - origin()).cast<float>(); }

    /// A type of several bodies comes with all its parts; the id is that of the root.
    virtual EntityId spawn(const SpawnDef& def) = 0;
    /// With the root of an assembly go all its parts that this zone owns.
    virtual void despawn(EntityId entity) = 0;
    /// At rest, and so is all that joints hold to it and rides on it, which comes along. A soft
    /// body comes whole, as deformed as it is; pinned nodes hold where they come to.
    virtual void teleport(EntityId entity, const Vec3& position) = 0;
    /// Props: impulse / mass, of soft ones for each node that is not pinned; characters: a knock
    /// that apply_input starts from. m/s.
    virtual void add_velocity(EntityId entity, const Vec3& change) = 0;
    /// Takes an entity out of the world (no body, no viewer hears of it; its joints and rides end)
    /// or puts it back at `position`. A soft body comes back as its type defines it: tears are
    /// whole again, plastic set is gone.
    virtual void hide(EntityId entity) = 0;
    virtual void show(EntityId entity, const Vec3& position, const Vec3& velocity) = 0;
    virtual void set_appearance(EntityId entity, std::uint16_t appearance) = 0;
    virtual void set_stance(EntityId entity, world::Stance stance) = 0;

    // Declared fields (`type { field { ... } }`): what clients that hear of an entity know of it
    // beside its motion. A field holds the value that clients get, rounded to its quantum.

    /// The field of that name, for entities of any type that declares it; none where no type does.
    /// Rules ask once, when they start.
    [[nodiscard]] std::optional<wire::FieldId> field_named(std::string_view name) const {
        const wire::FieldId id = wire::field_id(name);
        for (const world::EntityType& type : types()) {
            if (type.fields != nullptr && type.fields->find(id) != nullptr) {
                return id;
            }
        }
        return std::nullopt;
    }

    /// The value of an entity of this zone or a ghost; a text is good until the entity changes.
    /// None where there is no such entity, or its type does not declare the field.
    [[nodiscard]] std::optional<wire::FieldValue> field(EntityId entity, wire::FieldId id) const {
        const world::Entities& e = entities();
        const world::Row row = e.find(entity);
        const wire::FieldSchema* schema =
            row != world::kNoRow ? e.fields().schema(e.type[row]) : nullptr;
        const wire::DeclaredField* field = schema != nullptr ? schema->find(id) : nullptr;
        if (field == nullptr) {
            return std::nullopt;
        }
        return wire::value_of(*field, wire::words_of(*field, e.field_values(row)));
    }

    /// Of an owned entity. A number beyond the range is clamped; anything else that the field
    /// cannot hold is refused, and so are other zones' entities. Both are counted (StepReport).
    virtual wire::FieldOutcome set_field(EntityId entity,
                                         wire::FieldId id,
                                         const wire::FieldValue& value) = 0;

    /// The stance of that name: one of the four that every world has, or of those that the
    /// config names.
    [[nodiscard]] virtual std::optional<world::Stance> stance_named(std::string_view name) const {
        for (std::size_t i = 0; i < kStanceNames.size(); ++i) {
            if (kStanceNames[i] == name) {
                return static_cast<world::Stance>(i);
            }
        }
        return std::nullopt;
    }

    /// The name of a stance; empty: the world has no such one.
    [[nodiscard]] virtual std::string_view stance_name(world::Stance stance) const {
        const auto at = static_cast<std::size_t>(stance);
        return at < kStanceNames.size() ? kStanceNames[at] : std::string_view();
    }

    // Joints, assemblies and riders. Zones own what hangs together as a whole.

    /// The parts of an assembly that this zone owns, the root first; of another entity itself.
    virtual void parts_of(EntityId root, std::vector<EntityId>& out) const { out.assign(1, root); }

    /// The root of the assembly that an entity is a part of, where this zone knows it; of another
    /// entity itself.
    [[nodiscard]] virtual EntityId assembly_root(EntityId part) const { return part; }

    /// The joint of that name in an assembly of this zone; with no root, between placed entities.
    /// None where there is no such joint, or it is gone.
    [[nodiscard]] virtual EntityJointId joint_named(EntityId root, std::string_view name) const {
        (void)root;
        (void)name;
        return {};
    }

    /// Joins two entities of this zone as they are, or `b` and the world (`a` none). At least one
    /// is a prop, neither is soft, hidden or has an agent. None where that is not so, a number is
    /// out of range, or the zone has kMostJoints.
    virtual EntityJointId add_joint(EntityId a, EntityId b, const JointPlan& plan) {
        (void)a;
        (void)b;
        (void)plan;
        return {};
    }

    virtual void remove_joint(EntityJointId joint) { (void)joint; }

    [[nodiscard]] virtual std::optional<JointReading> joint(EntityJointId joint) const {
        (void)joint;
        return std::nullopt;
    }

    [[nodiscard]] virtual bool has_joints(EntityId entity) const {
        (void)entity;
        return false;
    }

    /// The target of a joint's motor from now on, in place of what the config says: rad/s or rad,
    /// m/s or m. False where it has no motor, or the number is not finite or too large.
    virtual bool set_motor_target(EntityJointId joint, float target) {
        (void)joint;
        (void)target;
        return false;
    }

    /// Rigid props, in the coming step: force in N at a zone-local point, and torque in N m.
    /// Several add up.
    virtual void apply_force(EntityId entity, const Vec3& force, const Vec3& point) {
        (void)entity;
        (void)force;
        (void)point;
    }

    virtual void apply_torque(EntityId entity, const Vec3& torque) {
        (void)entity;
        (void)torque;
    }

    /// Rigid props, at once: impulse in N s at a zone-local point.
    virtual void apply_impulse(EntityId entity, const Vec3& impulse, const Vec3& point) {
        (void)entity;
        (void)impulse;
        (void)point;
    }

    /// A character gets onto the seat of an assembly (0: it drives). The next step carries it.
    /// False where either is not here, the seat is taken or not there, or the character rides
    /// already or has an agent.
    virtual bool mount(EntityId rider, EntityId root, std::size_t seat) {
        (void)rider;
        (void)root;
        (void)seat;
        return false;
    }

    /// It walks again from `position`.
    virtual void dismount(EntityId rider, const Vec3& position) {
        (void)rider;
        (void)position;
    }

    /// The part that carries a character; none: nothing.
    [[nodiscard]] virtual EntityId carrier_of(EntityId rider) const {
        (void)rider;
        return {};
    }

    /// How many seats an assembly has.
    [[nodiscard]] virtual std::size_t seats_of(EntityId root) const {
        (void)root;
        return 0;
    }

    /// Nearest thing along a ray, entities (ghosts too) and static world; `ignore` is passed
    /// through.
    [[nodiscard]] virtual RayResult ray_cast(const Vec3& origin,
                                             const Vec3& direction,
                                             float max_distance,
                                             EntityId ignore) const = 0;

    /// The same through the world as a client saw it when it acted
    /// (server/zone/viewers/lag_compensation.h): an entity of a rewindable type stands where it was
    /// displayed, within the configured bounds.
    [[nodiscard]] virtual SeenHit ray_cast_as_seen(ClientId client,
                                                   const Seen& seen,
                                                   const Vec3& origin,
                                                   const Vec3& direction,
                                                   float max_distance,
                                                   EntityId ignore) const {
        (void)client;
        (void)seen;
        SeenHit hit;
        static_cast<RayResult&>(hit) = ray_cast(origin, direction, max_distance, ignore);
        return hit;
    }

    /// Where an owned entity of a rewindable type was after a tick; none when that is longer ago
    /// than the configured bound, or in the future, or it has jumped since.
    [[nodiscard]] virtual std::optional<Vec3> position_after(EntityId entity, Tick tick) const {
        (void)entity;
        (void)tick;
        return std::nullopt;
    }

    /// Entities within `radius` m of a point (horizontally), not hidden, ascending by id; ghosts
    /// too.
    virtual void near(const Vec3& point, float radius, std::vector<EntityId>& out) const = 0;

    /// Particles of a simulated system of the config within `radius` m of a point, in this zone
    /// alone; 0 where it has no such system. Looks at every particle of the system: some
    /// microseconds per thousand, so ask for a few points a tick.
    [[nodiscard]] virtual std::uint32_t particles_near(std::string_view system,
                                                       const Vec3& point,
                                                       float radius) const = 0;
    /// Emits `count` particles of a system with a `burst` at `position` with about `velocity`
    /// (m/s). Particles of a simulated system are born in the next tick, at most `most` of them,
    /// and no client is notified. A cosmetic system simulates nothing. Each client whose nimbus and
    /// the burst's aura reach the place gets one reliable event, and computes the particles itself.
    /// At most 1000 particles and `events_per_s` events. False where the world has no such system,
    /// it has no `burst`, or the numbers are not finite or too large.
    virtual bool emit(std::string_view system,
                      const Vec3& position,
                      const Vec3& velocity,
                      std::uint32_t count) = 0;

    virtual EventId send(ClientId client, const RulesEvent& event) = 0;
    /// To all subscribers of a topic, in all zones.
    virtual EventId publish(std::string_view topic, const RulesEvent& event) = 0;
    /// To all clients that hear of `source` now, and to its own client.
    virtual EventId announce(EntityId source, const RulesEvent& event) = 0;
    virtual void subscribe(ClientId client, std::string_view topic) = 0;
    virtual void unsubscribe(ClientId client, std::string_view topic) = 0;

    /// Appends the entities of this zone within the trigger of that name, ascending.
    virtual void inside(std::string_view trigger, std::vector<EntityId>& out) const {
        (void)trigger;
        (void)out;
    }

    /// Delivered to Rules::on_message of the zone that owns `target`, next tick. Lost (and counted)
    /// when nobody owns it.
    virtual void message(EntityId target, Bytes payload) = 0;

    /// The same to the rules of one zone (none: of all, this one too), with no target: for what
    /// zones have to know of each other.
    virtual void message_zone(ZoneId zone, Bytes payload) {
        (void)zone;
        (void)payload;
    }

    // For operators. None of it is state: a replay and a recovered zone are silent.

    /// A line of the server's log; the first kMostLogLines of a tick and kMostLogBytes of each.
    virtual void log(std::string_view line) { (void)line; }

    /// Adds to the metric `zoned_rules_total{name=...}`. A zone server keeps kMostRulesFigures of
    /// these and of gauges; names are letters, digits and _.
    virtual void count(std::string_view name, double amount) {
        (void)name;
        (void)amount;
    }

    /// Sets the metric `zoned_rules_value{name=..., zone=...}`.
    virtual void gauge(std::string_view name, double value) {
        (void)name;
        (void)value;
    }

    /// Rules::on_timer is called in `seconds` (at least one tick) in the zone that owns `entity`
    /// then; nobody is where it is gone. With no entity: in this zone. Timers belong to the state
    /// of a zone: snapshots hold them, and they run although nobody moves or watches. None where
    /// seconds is not finite or negative, the entity is not of this zone, or the zone has
    /// kMostTimers.
    virtual TimerId start_timer(EntityId entity,
                                double seconds,
                                std::uint16_t kind,
                                Bytes payload = {}) {
        (void)entity;
        (void)seconds;
        (void)kind;
        (void)payload;
        return {};
    }

    /// Of this zone, and not yet due; anything else is no mistake.
    virtual void stop_timer(TimerId timer) { (void)timer; }

    /// Everything that the client knows of the world is sent to it anew: for a client that has been
    /// found to hold something else.
    virtual void reset_view(ClientId client) { (void)client; }

    /// A player has succeeded, or failed, at a task that agents of this zone make difficult (has
    /// beaten one, or was beaten). Difficulty follows where the config says so (`ai.adaptation`),
    /// else nothing happens. Agents change after the rules of this tick at the earliest.
    virtual void note_outcome(bool player_succeeded) { (void)player_succeeded; }

    /// Groups of players (groups/rules_parties.h); null: the config has no `parties`.
    [[nodiscard]] virtual RulesParties* parties() const { return nullptr; }

    /// Players who play for a result or wait for it (groups/rules_matches.h); null: the config has
    /// no `match`.
    [[nodiscard]] virtual RulesMatches* matches() const { return nullptr; }

    /// Copies of parts of the map (groups/rules_instances.h); null: the config has none.
    [[nodiscard]] virtual RulesInstances* instances() const { return nullptr; }

    // Agents. Their variables are senses of their brains: a rule that sets one commands all brains
    // that react to it.

    /// The present doing of an agent; none where the entity has no agent in this zone.
    [[nodiscard]] virtual std::optional<AgentReading> agent(EntityId entity) const {
        (void)entity;
        return std::nullopt;
    }

    /// A variable of its brain as it is now; none: there is no such agent or variable.
    [[nodiscard]] virtual std::optional<double> agent_variable(EntityId entity,
                                                               std::string_view name) const {
        (void)entity;
        (void)name;
        return std::nullopt;
    }

    /// Sets it, within the variable's range, and lets the agent decide in this tick. False where
    /// there is no such agent or variable, or the value is not finite.
    virtual bool set_agent_variable(EntityId entity, std::string_view name, double value) {
        (void)entity;
        (void)name;
        (void)value;
        return false;
    }

    /// From now on it wanders around `home`, guards it, patrols it or returns to it, as its state
    /// says.
    virtual bool set_agent_home(EntityId entity, const Vec3& home) {
        (void)entity;
        (void)home;
        return false;
    }

    virtual void kick(ClientId client, std::string_view reason) = 0;

    /// The player goes to another world of the cluster, to its `arrival` (empty: where it stood
    /// there last). False where this server is in no cluster, or the client's avatar is not in this
    /// zone. True promises a try alone: a player without an account, or whose way is closed, is
    /// told so and stays. Who goes is told by Rules::on_leave.
    virtual bool travel(ClientId client, std::string_view world, std::string_view arrival) {
        (void)client;
        (void)world;
        (void)arrival;
        return false;
    }

    // The durable store. Rules::on_store is told of each result some ticks later, in the zone that
    // owns `target` then (none: in this zone). A number names the request; 0: it was refused at
    // once, because a name or the value is too long, or too many requests were made in this tick.

    virtual std::uint64_t store_get(EntityId target, const mailbox::StoreKey& key) {
        (void)target;
        (void)key;
        return 0;
    }

    virtual std::uint64_t store_put(EntityId target, const mailbox::StoreKey& key, Bytes value) {
        (void)target;
        (void)key;
        (void)value;
        return 0;
    }

    virtual std::uint64_t store_remove(EntityId target, const mailbox::StoreKey& key) {
        (void)target;
        (void)key;
        return 0;
    }
};

}  // namespace zoned::zone
