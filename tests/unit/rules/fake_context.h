// FakeContext: RulesContext on plain columns, without physics or network.
#pragma once

#include "server/zone/groups/party_book.h"
#include "server/zone/groups/rules_parties.h"
#include "server/zone/rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::rules::test {

inline constexpr float kDt = 1.0F / 30.0F;
inline constexpr TypeIndex kPlayer = 0;
inline constexpr TypeIndex kGuard = 1;
inline constexpr TypeIndex kBall = 2;
inline constexpr TypeIndex kCrate = 3;

/// The fields that characters declare: numbers, a choice, a flag and a text.
inline std::shared_ptr<const wire::FieldSchema> test_fields() {
    std::vector<wire::DeclaredField> fields(5);
    fields[0].name = "health";
    fields[0].most = 100;
    fields[0].initial[0] = 100;
    fields[1].name = "kills";
    fields[1].most = 1000;
    fields[2].name = "mood";
    fields[2].kind = wire::DeclaredKind::kEnum;
    fields[2].values = {"calm", "angry"};
    fields[3].name = "ready";
    fields[3].kind = wire::DeclaredKind::kBool;
    fields[4].name = "title";
    fields[4].kind = wire::DeclaredKind::kText;
    return *wire::FieldSchema::make(std::move(fields));
}

inline world::TypeTable test_types() {
    world::TypeTable types(4);
    types[kPlayer].fields = test_fields();
    types[kPlayer].name = "player";
    types[kPlayer].kind = world::EntityKind::kCharacter;
    types[kPlayer].mass = 80.0F;
    types[kGuard] = types[kPlayer];
    types[kGuard].name = "guard";
    types[kGuard].brain = 1;
    types[kBall].fields = test_fields();
    types[kBall].name = "ball";
    types[kBall].shape = world::TypeShape::kSphere;
    types[kBall].radius = 0.2F;
    types[kBall].mass = 2.0F;
    types[kCrate].name = "crate";
    types[kCrate].mass = 50.0F;
    return types;
}

/// The recipients of an event.
enum class Channel {
    kClient,
    kTopic,
    kViewers
};

struct Sent {
    Channel channel = Channel::kClient;
    ClientId client;
    std::string topic;
    EntityId source;
    zone::RulesEvent event;
    EventId id;
    Tick tick = 0;
};

struct Emitted {
    std::string system;
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    std::uint32_t count = 0;
};

struct Mail {
    EntityId target;
    zone::Bytes payload;
};

struct AddedJoint {
    EntityId a;
    EntityId b;
    zone::JointPlan plan;
};

/// Each zone of a test has rules of its own: see FakeZone.
class FakeContext : public zone::RulesContext {
  public:
    explicit FakeContext(std::uint16_t zone_number = 1, const Vec3d& zone_origin = Vec3d::Zero())
        : zone_(zone_number),
          origin_(zone_origin),
          next_id_(zone_number) {
        entities_.declare_fields(world::field_schemas(types_));
    }

    // ---- for tests ----

    EntityId put(TypeIndex type, const Vec3& position) {
        zone::SpawnDef def;
        def.type = type;
        def.position = position;
        return spawn(def);
    }

    /// A read-only copy of an entity of another zone.
    void show_ghost(const FakeContext& owner, EntityId entity) {
        const world::Row from = owner.entities_.find(entity);
        world::Row row = entities_.find(entity);
        if (row == world::kNoRow) {
            row = entities_.add(entity, owner.entities_.type[from]);
        }
        entities_.position[row] =
            owner.entities_.position[from] + (owner.origin_ - origin_).cast<float>();
        entities_.set_client(row, owner.entities_.client[from]);
        entities_.stance[row] = owner.entities_.stance[from];
        entities_.set(row, world::kGhost, true);
        entities_.set(row, world::kHidden, owner.entities_.has(from, world::kHidden));
    }

    [[nodiscard]] std::vector<Sent> of_kind(int kind) const {
        std::vector<Sent> found;
        for (const Sent& s : sent) {
            if (s.event.kind == kind) {
                found.push_back(s);
            }
        }
        return found;
    }

    template <class Message>
    [[nodiscard]] static Message parse(const Sent& s) {
        Message message;
        EXPECT_TRUE(message.ParseFromArray(s.event.payload.data(),
                                           static_cast<int>(s.event.payload.size())));
        return message;
    }

    void pass_tick() { ++now_; }

    std::vector<zone::SpawnPoint> spawns;  ///< for tests

    [[nodiscard]] std::span<const zone::SpawnPoint> spawn_points() const override { return spawns; }

    /// The first of the team's.
    [[nodiscard]] const zone::SpawnPoint* freest_spawn(std::string_view team) const override {
        const auto points = zone::spawn_points_of(spawns, team);
        return points.empty() ? nullptr : points.front();
    }

    /// From now on the world has parties.
    void open_parties(const zone::PartySettings& settings) {
        book.emplace(settings);
        parties_.open(*book);
    }

    /// Carries out the orders of the rules; the changes are for their next call of on_party.
    std::vector<zone::PartyChange> carry_out_party_orders() {
        book->begin(++now_);
        for (const zone::PartyOrder& order : std::exchange(party_orders, {})) {
            book->apply(order, [this](EntityId avatar) -> std::optional<zone::PartyPlayer> {
                const world::Row row = entities_.find(avatar);
                if (row == world::kNoRow || !entities_.client[row]) {
                    return std::nullopt;
                }
                const ClientId client = entities_.client[row];
                return zone::PartyPlayer{
                    avatar, client, zone(), "account", "name" + std::to_string(client.value)};
            });
        }
        return {book->changes().begin(), book->changes().end()};
    }

    /// Due timers, in the order in which they were started; they are gone with it.
    std::vector<zone::DueTimer> take_due() {
        std::vector<zone::DueTimer> due;
        std::erase_if(timers, [&](const std::pair<Tick, zone::DueTimer>& timer) {
            if (timer.first <= now_) {
                due.push_back(timer.second);
            }
            return timer.first <= now_;
        });
        return due;
    }

    /// Chains what rules may change of the entities.
    void hash_columns(core::StateHash& hash) const {
        for (world::Row row = 0; row < entities_.size(); ++row) {
            hash.add(entities_.id[row].value);
            hash.add(entities_.flags[row]);
            for (int axis = 0; axis < 3; ++axis) {
                hash.add(entities_.position[row][axis]);
                hash.add(entities_.velocity[row][axis]);
            }
        }
    }

    [[nodiscard]] bool exists(EntityId entity) const {
        return entities_.find(entity) != world::kNoRow;
    }

    [[nodiscard]] bool hidden(EntityId entity) const {
        return entities_.has(entities_.find(entity), world::kHidden);
    }

    [[nodiscard]] Vec3& position(EntityId entity) {
        return entities_.position[entities_.find(entity)];
    }

    [[nodiscard]] Vec3 velocity(EntityId entity) const {
        return entities_.velocity[entities_.find(entity)];
    }

    std::map<EntityId, std::vector<EntityId>> seats;  ///< of vehicles: the riders, or none

    // ---- RulesContext ----

    [[nodiscard]] Tick now() const override { return now_; }

    [[nodiscard]] float dt() const override { return kDt; }

    [[nodiscard]] ZoneId zone() const override { return ZoneId(zone_); }

    [[nodiscard]] Vec3d origin() const override { return origin_; }

    [[nodiscard]] const world::Entities& entities() const override { return entities_; }

    [[nodiscard]] world::Entities& columns() { return entities_; }

    [[nodiscard]] const world::TypeTable& types() const override { return types_; }

    [[nodiscard]] TypeIndex type_named(std::string_view name) const override {
        for (TypeIndex i = 0; i < types_.size(); ++i) {
            if (types_[i].name == name) {
                return i;
            }
        }
        ADD_FAILURE() << "no type " << name;
        return 0;
    }

    [[nodiscard]] core::Rng& rng() override { return rng_; }

    EntityId spawn(const zone::SpawnDef& def) override {
        const EntityId id(next_id_);
        next_id_ += 4;
        const world::Row row = entities_.add(id, def.type);
        entities_.position[row] = def.position;
        entities_.velocity[row] = def.velocity;
        entities_.appearance[row] = def.appearance;
        entities_.set_client(row, def.client);
        return id;
    }

    void despawn(EntityId entity) override { entities_.remove(owned(entity)); }

    void teleport(EntityId entity, const Vec3& to) override {
        entities_.position[owned(entity)] = to;
    }

    void add_velocity(EntityId entity, const Vec3& change) override {
        EXPECT_TRUE(change.allFinite());
        entities_.velocity[owned(entity)] += change;
    }

    void hide(EntityId entity) override { entities_.set(owned(entity), world::kHidden, true); }

    [[nodiscard]] std::size_t seats_of(EntityId root) const override {
        const auto at = seats.find(root);
        return at != seats.end() ? at->second.size() : 0;
    }

    bool mount(EntityId rider, EntityId root, std::size_t seat) override {
        EntityId& on = seats.at(root)[seat];
        if (on || carrier_of(rider)) {
            return false;
        }
        on = rider;
        entities_.set(owned(rider), world::kCarried, true);
        return true;
    }

    void dismount(EntityId rider, const Vec3& place) override {
        for (auto& [root, riders] : seats) {
            std::replace(riders.begin(), riders.end(), rider, EntityId());
        }
        entities_.set(owned(rider), world::kCarried, false);
        teleport(rider, place);
    }

    [[nodiscard]] EntityId carrier_of(EntityId rider) const override {
        for (const auto& [root, riders] : seats) {
            if (std::find(riders.begin(), riders.end(), rider) != riders.end()) {
                return root;
            }
        }
        return {};
    }

    void show(EntityId entity, const Vec3& at, const Vec3& velocity) override {
        const world::Row row = owned(entity);
        EXPECT_TRUE(entities_.has(row, world::kHidden));
        entities_.set(row, world::kHidden, false);
        entities_.position[row] = at;
        entities_.velocity[row] = velocity;
    }

    void set_appearance(EntityId entity, std::uint16_t appearance) override {
        entities_.appearance[owned(entity)] = appearance;
    }

    wire::FieldOutcome set_field(EntityId entity,
                                 wire::FieldId id,
                                 const wire::FieldValue& value) override {
        const world::Row row = entities_.find(entity);
        const wire::FieldSchema* schema = types_[entities_.type[row]].fields.get();
        const wire::DeclaredField* field = schema != nullptr ? schema->find(id) : nullptr;
        std::array<std::uint32_t, wire::kTextWords> words{};
        const wire::FieldOutcome outcome =
            field != nullptr ? wire::put_value(*field, value, words) : wire::FieldOutcome::kRefused;
        if (outcome != wire::FieldOutcome::kRefused) {
            entities_.put_field(
                row, *field, std::span<const std::uint32_t>(words).first(field->words), now());
        }
        return outcome;
    }

    [[nodiscard]] std::optional<world::Stance> stance_named(std::string_view name) const override {
        const auto it = std::find(stances.begin(), stances.end(), name);
        return it == stances.end()
                   ? RulesContext::stance_named(name)
                   : static_cast<world::Stance>(world::kFirstNamedStance + (it - stances.begin()));
    }

    void set_stance(EntityId entity, world::Stance stance) override {
        entities_.stance[owned(entity)] = static_cast<std::uint8_t>(stance);
    }

    /// Every entity is a ball of 0.9 m, the static world is a wall at x = wall_x.
    [[nodiscard]] zone::RayResult ray_cast(const Vec3& from,
                                           const Vec3& direction,
                                           float max_distance,
                                           EntityId ignore) const override {
        EXPECT_NEAR(direction.norm(), 1.0F, 1e-5F);
        zone::RayResult best;
        best.distance = max_distance;
        if (direction.x() > 0.0F && (wall_x - from.x()) / direction.x() < best.distance) {
            best.hit = true;
            best.distance = (wall_x - from.x()) / direction.x();
        }
        for (world::Row row = 0; row < entities_.size(); ++row) {
            const Vec3 to = entities_.position[row] - from;
            const float along = to.dot(direction);
            if (entities_.id[row] != ignore && !entities_.has(row, world::kHidden) &&
                along > 0.0F && along < best.distance && (to - direction * along).norm() < 0.9F) {
                best.hit = true;
                best.distance = along;
                best.entity = entities_.id[row];
            }
        }
        best.point = from + direction * best.distance;
        best.normal = -direction;
        return best;
    }

    /// The ray of the present, with what as_seen says of it; the claim is kept.
    [[nodiscard]] zone::SeenHit ray_cast_as_seen(ClientId client,
                                                 const zone::Seen& seen,
                                                 const Vec3& origin,
                                                 const Vec3& direction,
                                                 float max_distance,
                                                 EntityId ignore) const override {
        (void)client;
        claims.assign(seen.entities.begin(), seen.entities.end());
        zone::SeenHit hit = as_seen;
        static_cast<zone::RayResult&>(hit) = ray_cast(origin, direction, max_distance, ignore);
        return hit;
    }

    /// Entities of this zone take any joint.
    zone::EntityJointId add_joint(EntityId a, EntityId b, const zone::JointPlan& plan) override {
        const auto is_owned = [this](EntityId entity) {
            const world::Row row = entities_.find(entity);
            return row != world::kNoRow && !entities_.has(row, world::kGhost);
        };
        if (!is_owned(b) || (a && !is_owned(a))) {
            return {};
        }
        joints.push_back({a, b, plan});
        return zone::EntityJointId(static_cast<std::uint32_t>(joints.size()));
    }

    void near(const Vec3& point, float radius, std::vector<EntityId>& out) const override {
        for (world::Row row = 0; row < entities_.size(); ++row) {
            const Vec3 offset = entities_.position[row] - point;
            if (!entities_.has(row, world::kHidden) &&
                Vec2(offset.x(), offset.z()).norm() <= radius) {
                out.push_back(entities_.id[row]);
            }
        }
        std::sort(out.begin(), out.end());
    }

    [[nodiscard]] zone::RulesParties* parties() const override {
        return book ? &parties_ : nullptr;
    }

    EventId send(ClientId client, const zone::RulesEvent& event) override {
        return note({Channel::kClient, client, "", EntityId(), event, EventId(), now_});
    }

    EventId publish(std::string_view topic, const zone::RulesEvent& event) override {
        return note(
            {Channel::kTopic, ClientId(), std::string(topic), EntityId(), event, EventId(), now_});
    }

    std::uint32_t particles_near(std::string_view system,
                                 const Vec3& /*point*/,
                                 float /*radius*/) const override {
        return system == "hail" ? hail_near : 0;
    }

    bool emit(std::string_view system,
              const Vec3& position,
              const Vec3& velocity,
              std::uint32_t count) override {
        emitted.push_back({std::string(system), position, velocity, count});
        return true;
    }

    EventId announce(EntityId source, const zone::RulesEvent& event) override {
        static_cast<void>(owned(source));
        return note({Channel::kViewers, ClientId(), "", source, event, EventId(), now_});
    }

    void subscribe(ClientId client, std::string_view topic) override {
        topics.emplace_back("+" + std::to_string(client.value) + " " + std::string(topic));
    }

    void unsubscribe(ClientId client, std::string_view topic) override {
        topics.emplace_back("-" + std::to_string(client.value) + " " + std::string(topic));
    }

    void message(EntityId target, zone::Bytes payload) override {
        outbox.push_back({target, std::move(payload)});
    }

    std::uint64_t store_get(EntityId target, const mailbox::StoreKey& key) override {
        return ask(mailbox::StoreAct::kGet, target, key, {});
    }

    std::uint64_t store_put(EntityId target,
                            const mailbox::StoreKey& key,
                            zone::Bytes value) override {
        return ask(mailbox::StoreAct::kPut, target, key, std::move(value));
    }

    void message_zone(ZoneId zone, zone::Bytes payload) override {
        zone_mail.emplace_back(zone, std::move(payload));
    }

    void log(std::string_view line) override { lines.emplace_back(line); }

    void count(std::string_view name, double amount) override {
        figures[std::string(name)] += amount;
    }

    void gauge(std::string_view name, double value) override { figures[std::string(name)] = value; }

    [[nodiscard]] EntityId entity_named(std::string_view name) const override {
        const auto at = names.find(std::string(name));
        return at != names.end() ? at->second : EntityId();
    }

    zone::TimerId start_timer(EntityId entity,
                              double seconds,
                              std::uint16_t kind,
                              zone::Bytes payload) override {
        if (!(seconds >= 0.0)) {
            return {};
        }
        const zone::TimerId id(++started_timers_);
        const double ticks = std::max(1.0, std::round(seconds / static_cast<double>(kDt)));
        timers.push_back({now_ + static_cast<Tick>(ticks), {id, entity, kind, std::move(payload)}});
        return id;
    }

    void inside(std::string_view trigger, std::vector<EntityId>& out) const override {
        const auto at = held.find(std::string(trigger));
        if (at != held.end()) {
            out = at->second;
        }
    }

    void stop_timer(zone::TimerId timer) override {
        std::erase_if(timers, [&](const auto& started) { return started.second.id == timer; });
    }

    /// Agents have one variable, `fear`, and live by the brain `guard`.
    [[nodiscard]] std::optional<zone::AgentReading> agent(EntityId entity) const override {
        const auto at = homes.find(entity);
        return at != homes.end() ? std::optional<zone::AgentReading>(
                                       {"guard", "watch", "stand", at->second, EntityId()})
                                 : std::nullopt;
    }

    [[nodiscard]] std::optional<double> agent_variable(EntityId entity,
                                                       std::string_view name) const override {
        return homes.contains(entity) && name == "fear" ? std::optional<double>(fear)
                                                        : std::nullopt;
    }

    bool set_agent_variable(EntityId entity, std::string_view name, double value) override {
        const bool known = agent_variable(entity, name).has_value();
        fear = known ? value : fear;
        return known;
    }

    bool set_agent_home(EntityId entity, const Vec3& home) override {
        const auto at = homes.find(entity);
        if (at == homes.end()) {
            return false;
        }
        at->second = home;
        return true;
    }

    void reset_view(ClientId client) override { resets.push_back(client); }

    void note_outcome(bool player_succeeded) override { outcomes.push_back(player_succeeded); }

    void kick(ClientId /*client*/, std::string_view /*reason*/) override {}

    bool travel(ClientId client, std::string_view world, std::string_view arrival) override {
        travels.push_back(std::to_string(client.value) + " " + std::string(world) + " " +
                          std::string(arrival));
        return in_cluster;
    }

    std::vector<std::string> travels;
    bool in_cluster = true;

  private:
    /// Rules may change only entities that this zone owns.
    [[nodiscard]] world::Row owned(EntityId entity) const {
        const world::Row row = entities_.find(entity);
        EXPECT_NE(row, world::kNoRow);
        EXPECT_FALSE(entities_.has(row, world::kGhost));
        return row;
    }

    std::uint64_t ask(mailbox::StoreAct act,
                      EntityId target,
                      const mailbox::StoreKey& key,
                      zone::Bytes value) {
        mailbox::StoreRequest& request = asked.emplace_back();
        request.act = act;
        request.number = asked.size();
        request.target = target;
        request.key = key;
        request.value = std::move(value);
        return request.number;
    }

    EventId note(Sent s) {
        EXPECT_GE(s.event.kind, zone::kFirstRulesEvent);
        s.id = EventId((++events_ << 16) | zone_);
        sent.push_back(s);
        return s.id;
    }

    world::TypeTable types_ = test_types();

  public:
    std::vector<Sent> sent;
    std::vector<Mail> outbox;
    std::vector<mailbox::StoreRequest> asked;  ///< of the store
    std::vector<Emitted> emitted;
    std::uint32_t hail_near = 0;       ///< particles of "hail" near any point that is queried
    std::vector<std::string> stances;  ///< the world's own
    std::vector<std::string> topics;
    std::vector<ClientId> resets;
    std::vector<bool> outcomes;  ///< reported to difficulty: whether a player succeeded
    float wall_x = 1e6F;
    zone::SeenHit as_seen;                         ///< but for the hit
    mutable std::vector<zone::SeenEntity> claims;  ///< of the last ray_cast_as_seen
    std::vector<AddedJoint> joints;
    std::vector<std::pair<Tick, zone::DueTimer>> timers;
    std::vector<std::pair<ZoneId, zone::Bytes>> zone_mail;
    std::vector<std::string> lines;         ///< of the log
    std::map<std::string, double> figures;  ///< of the metrics
    std::map<std::string, EntityId> names;
    std::map<std::string, std::vector<EntityId>> held;  ///< by triggers
    std::map<EntityId, Vec3> homes;                     ///< of agents
    double fear = 0.0;                                  ///< of all of them
    std::optional<zone::PartyBook> book;
    std::vector<zone::PartyOrder> party_orders;

  private:
    std::uint64_t started_timers_ = 0;
    std::uint16_t zone_;
    Vec3d origin_;
    std::uint32_t next_id_;
    std::uint64_t events_ = 0;
    Tick now_ = 100;
    core::Rng rng_;
    world::Entities entities_;
    mutable zone::RulesParties parties_{ZoneId(zone_), party_orders};
};

}  // namespace zoned::rules::test
