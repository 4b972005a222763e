// ZoneContext: the interface of the rules to a zone, implemented over the zone's state.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

class ZoneContext final : public RulesContext {
  public:
    explicit ZoneContext(ZoneState& state) : state_(&state) {}

    [[nodiscard]] Tick now() const override { return state_->now; }

    [[nodiscard]] float dt() const override { return state_->settings.dt; }

    [[nodiscard]] ZoneId zone() const override { return state_->settings.id; }

    [[nodiscard]] Vec3d origin() const override { return state_->settings.region().origin(); }

    [[nodiscard]] const world::Entities& entities() const override { return state_->entities; }

    [[nodiscard]] const world::TypeTable& types() const override { return *state_->settings.types; }

    [[nodiscard]] TypeIndex type_named(std::string_view name) const override;

    [[nodiscard]] core::Rng& rng() override { return state_->rng; }

    [[nodiscard]] EntityId entity_named(std::string_view name) const override;
    EntityId spawn(const SpawnDef& def) override;
    void despawn(EntityId entity) override;
    void teleport(EntityId entity, const Vec3& position) override;
    void add_velocity(EntityId entity, const Vec3& change) override;
    void hide(EntityId entity) override;
    void show(EntityId entity, const Vec3& position, const Vec3& velocity) override;
    void set_appearance(EntityId entity, std::uint16_t appearance) override;
    void set_stance(EntityId entity, world::Stance stance) override;
    wire::FieldOutcome set_field(EntityId entity,
                                 wire::FieldId id,
                                 const wire::FieldValue& value) override;
    [[nodiscard]] std::optional<double> shared_value(std::string_view name) const override;
    bool set_clock_rate(std::string_view name, double rate_per_s, double ahead_s) override;
    bool set_door(std::string_view name, bool open, double ahead_s) override;
    [[nodiscard]] std::optional<bool> door_open(std::string_view name) const override;
    bool move_platform(std::string_view name, std::uint32_t stop, double ahead_s) override;
    [[nodiscard]] std::optional<std::uint32_t> platform_stop(std::string_view name) const override;

    [[nodiscard]] std::span<const SpawnPoint> spawn_points() const override {
        return state_->settings.spawn_points;
    }

    [[nodiscard]] const SpawnPoint* freest_spawn(std::string_view team) const override {
        return spawn_points().empty() ? nullptr : &freest_spawn_point(*state_, team);
    }

    [[nodiscard]] std::optional<world::Stance> stance_named(std::string_view name) const override;
    [[nodiscard]] std::string_view stance_name(world::Stance stance) const override;

    void parts_of(EntityId root, std::vector<EntityId>& out) const override;
    [[nodiscard]] EntityId assembly_root(EntityId part) const override;
    [[nodiscard]] EntityJointId joint_named(EntityId root, std::string_view name) const override;
    EntityJointId add_joint(EntityId a, EntityId b, const JointPlan& plan) override;
    void remove_joint(EntityJointId joint) override;
    [[nodiscard]] std::optional<JointReading> joint(EntityJointId joint) const override;
    [[nodiscard]] bool has_joints(EntityId entity) const override;
    bool set_motor_target(EntityJointId joint, float target) override;
    void apply_force(EntityId entity, const Vec3& force, const Vec3& point) override;
    void apply_torque(EntityId entity, const Vec3& torque) override;
    void apply_impulse(EntityId entity, const Vec3& impulse, const Vec3& point) override;
    bool mount(EntityId rider, EntityId root, std::size_t seat) override;
    void dismount(EntityId rider, const Vec3& position) override;
    [[nodiscard]] EntityId carrier_of(EntityId rider) const override;
    [[nodiscard]] std::size_t seats_of(EntityId root) const override;

    [[nodiscard]] RayResult ray_cast(const Vec3& origin,
                                     const Vec3& direction,
                                     float max_distance,
                                     EntityId ignore) const override;
    [[nodiscard]] SeenHit ray_cast_as_seen(ClientId client,
                                           const Seen& seen,
                                           const Vec3& origin,
                                           const Vec3& direction,
                                           float max_distance,
                                           EntityId ignore) const override;
    [[nodiscard]] std::optional<Vec3> position_after(EntityId entity, Tick tick) const override;
    void near(const Vec3& point, float radius, std::vector<EntityId>& out) const override;

    [[nodiscard]] std::uint32_t particles_near(std::string_view system,
                                               const Vec3& point,
                                               float radius) const override;
    bool emit(std::string_view system,
              const Vec3& position,
              const Vec3& velocity,
              std::uint32_t count) override;

    EventId send(ClientId client, const RulesEvent& event) override;
    EventId publish(std::string_view topic, const RulesEvent& event) override;
    EventId announce(EntityId source, const RulesEvent& event) override;
    void subscribe(ClientId client, std::string_view topic) override;
    void unsubscribe(ClientId client, std::string_view topic) override;
    void inside(std::string_view trigger, std::vector<EntityId>& out) const override;
    void message(EntityId target, Bytes payload) override;
    void message_zone(ZoneId zone, Bytes payload) override;
    void log(std::string_view line) override;
    void count(std::string_view name, double amount) override;
    void gauge(std::string_view name, double value) override;
    TimerId start_timer(EntityId entity,
                        double seconds,
                        std::uint16_t kind,
                        Bytes payload) override;
    void stop_timer(TimerId timer) override;
    void reset_view(ClientId client) override;
    void note_outcome(bool player_succeeded) override;
    [[nodiscard]] RulesParties* parties() const override;
    [[nodiscard]] RulesInstances* instances() const override;
    [[nodiscard]] RulesMatches* matches() const override;
    [[nodiscard]] std::optional<AgentReading> agent(EntityId entity) const override;
    [[nodiscard]] std::optional<double> agent_variable(EntityId entity,
                                                       std::string_view name) const override;
    bool set_agent_variable(EntityId entity, std::string_view name, double value) override;
    bool set_agent_home(EntityId entity, const Vec3& home) override;
    void kick(ClientId client, std::string_view reason) override;
    bool travel(ClientId client, std::string_view world, std::string_view arrival) override;
    std::uint64_t store_get(EntityId target, const mailbox::StoreKey& key) override;
    std::uint64_t store_put(EntityId target, const mailbox::StoreKey& key, Bytes value) override;
    std::uint64_t store_remove(EntityId target, const mailbox::StoreKey& key) override;
    /// Where the client's character stands, for when it comes back.
    void store_stand(const ZoneClient& client);

  private:
    /// Row of an entity that this zone owns, or kNoRow.
    [[nodiscard]] world::Row owned(EntityId entity) const;
    /// The agent of an owned entity, awake and about to decide; null: it has none.
    ai::Agent* commanded(EntityId entity);
    PendingEvent& queue_event(const RulesEvent& event, Audience audience);
    std::uint64_t ask_store(mailbox::StoreAct act,
                            EntityId target,
                            const mailbox::StoreKey& key,
                            Bytes value);
    /// A durable event is a record as well: of one account, or of a topic.
    void store_event(const mailbox::EventOut& event, const std::string& account);
    /// The rigid body of an owned, visible prop, or none.
    [[nodiscard]] BodyId prop_body(EntityId entity) const;
    /// Moves a row to rest at `position`, and its body there.
    void place(world::Row row, const Vec3& position, const Vec3& velocity);

    ZoneState* state_;
};

/// Whether a request has names and a value that the store takes, and the tick has room for it.
[[nodiscard]] bool may_ask_store(const StepOutput& out,
                                 const mailbox::StoreKey& key,
                                 const Bytes& value);

}  // namespace zoned::zone
