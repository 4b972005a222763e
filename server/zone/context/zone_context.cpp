#include "server/zone/context/zone_context.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/motors.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/simulation/soft_hull.h"
#include "server/zone/simulation/spawning.h"
#include "server/zone/simulation/zone_agents.h"
#include "server/zone/simulation/zone_particles.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "server/zone/viewers/lag_compensation.h"
#include "shared/core/assert.h"
#include "shared/core/utf8.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::zone {

world::Row ZoneContext::owned(EntityId entity) const {
    const world::Row row = state_->entities.find(entity);
    return row != world::kNoRow && !state_->entities.has(row, world::kGhost) ? row : world::kNoRow;
}

EntityId ZoneContext::entity_named(std::string_view name) const {
    const auto at = state_->entity_names.find(name);
    return at != state_->entity_names.end() ? at->second : EntityId();
}

TypeIndex ZoneContext::type_named(std::string_view name) const {
    const world::TypeTable& table = types();
    const auto it = std::find_if(
        table.begin(), table.end(), [&](const world::EntityType& t) { return t.name == name; });
    ZONED_ASSERT(it != table.end(), "rules check the names of their types when they are made");
    return static_cast<TypeIndex>(it - table.begin());
}

EntityId ZoneContext::spawn(const SpawnDef& def) {
    return spawn_entity(*state_, def);
}

void ZoneContext::despawn(EntityId entity) {
    std::vector<EntityId> parts;
    parts_of(entity, parts);
    for (const EntityId part : parts) {
        const world::Row row = owned(part);
        if (row != world::kNoRow) {
            despawn_entity(*state_, row);
        }
    }
}

void ZoneContext::place(world::Row row, const Vec3& position, const Vec3& velocity) {
    world::Entities& e = state_->entities;
    e.position[row] = position;
    e.velocity[row] = velocity;
    e.angular_velocity[row].setZero();
    e.acceleration[row].setZero();
    e.discontinuity_tick[row] = state_->now;
    e.set(row, world::kAtRest, false);
    e.set(row, world::kGrounded, false);
    state_->grid_valid = false;
}

void ZoneContext::teleport(EntityId entity, const Vec3& position) {
    const world::Row row = owned(entity);
    if (row == world::kNoRow) {
        return;
    }
    wake_agent(*state_, row);
    step_up_soft(*state_, row);
    zone::dismount(*state_, entity);
    const world::Entities& e = state_->entities;
    const Vec3 shift = position - e.position[row];
    std::vector<world::Row> rows{row};
    add_held(*state_, rows);
    for (const world::Row held : rows) {
        place(held, held == row ? position : Vec3(e.position[held] + shift), Vec3::Zero());
        if (e.body[held]) {
            state_->scene.set_state(
                e.body[held],
                {e.position[held], e.orientation[held], Vec3::Zero(), Vec3::Zero(), false});
        }
    }
    place_soft(*state_, row);
}

void ZoneContext::add_velocity(EntityId entity, const Vec3& change) {
    const world::Row row = owned(entity);
    if (row == world::kNoRow) {
        return;
    }
    wake_agent(*state_, row);
    step_up_soft(*state_, row);
    world::Entities& e = state_->entities;
    e.set(row, world::kAtRest, false);
    const world::EntityType& type = types()[e.type[row]];
    if (type.kind == world::EntityKind::kCharacter) {
        e.velocity[row] += change;
        // Feet leave the ground, else friction would eat the knock within a tick.
        if (change.y() > 0.0F) {
            e.set(row, world::kGrounded, false);
        }
    } else if (e.body[row]) {
        const physics::BodyState body = state_->scene.state(e.body[row]);
        state_->scene.set_velocity(e.body[row], body.velocity + change, body.angular_velocity);
        state_->scene.wake(e.body[row]);
        e.velocity[row] = body.velocity + change;
    } else {
        push_soft(*state_, row, change);
    }
}

void ZoneContext::hide(EntityId entity) {
    const world::Row row = owned(entity);
    if (row == world::kNoRow) {
        return;
    }
    wake_agent(*state_, row);
    world::Entities& e = state_->entities;
    end_rides_of(*state_, entity);
    end_joints_of(*state_, entity);
    remove_body(*state_, row);
    e.set(row, world::kHidden, true);
    e.set(row, world::kAtRest, true);
    e.velocity[row].setZero();
    e.angular_velocity[row].setZero();
    e.acceleration[row].setZero();
}

void ZoneContext::show(EntityId entity, const Vec3& position, const Vec3& velocity) {
    const world::Row row = owned(entity);
    if (row == world::kNoRow) {
        return;
    }
    wake_agent(*state_, row);
    world::Entities& e = state_->entities;
    end_rides_of(*state_, entity);
    end_joints_of(*state_, entity);
    e.set(row, world::kHidden, false);
    remove_body(*state_, row);
    place(row, position, velocity);
    add_body(*state_, row, false);
}

void ZoneContext::set_appearance(EntityId entity, std::uint16_t appearance) {
    const world::Row row = owned(entity);
    if (row != world::kNoRow) {
        state_->entities.appearance[row] = appearance;
        state_->entities.touch(row);
    }
}

void ZoneContext::set_stance(EntityId entity, world::Stance stance) {
    ZONED_ASSERT(static_cast<int>(stance) < world::kStances, "a stance has radii");
    const world::Row row = owned(entity);
    if (row != world::kNoRow) {
        state_->entities.stance[row] = static_cast<std::uint8_t>(stance);
        state_->entities.touch(row);
    }
}

wire::FieldOutcome ZoneContext::set_field(EntityId entity,
                                          wire::FieldId id,
                                          const wire::FieldValue& value) {
    world::Entities& e = state_->entities;
    const world::Row row = owned(entity);
    const wire::FieldSchema* schema =
        row != world::kNoRow ? e.fields().schema(e.type[row]) : nullptr;
    const wire::DeclaredField* field = schema != nullptr ? schema->find(id) : nullptr;
    std::array<std::uint32_t, wire::kTextWords> words{};
    const wire::FieldOutcome outcome =
        field != nullptr ? wire::put_value(*field, value, words) : wire::FieldOutcome::kRefused;
    if (outcome == wire::FieldOutcome::kRefused) {
        ++state_->report.fields_refused;
        return outcome;
    }
    state_->report.fields_clamped += outcome == wire::FieldOutcome::kClamped ? 1 : 0;
    e.put_field(
        row, *field, std::span<const std::uint32_t>(words).first(field->words), state_->now);
    return outcome;
}

std::optional<world::Stance> ZoneContext::stance_named(std::string_view name) const {
    const std::vector<std::string>& own = state_->settings.stances;
    const auto it = std::find(own.begin(), own.end(), name);
    return it == own.end()
               ? RulesContext::stance_named(name)
               : static_cast<world::Stance>(world::kFirstNamedStance + (it - own.begin()));
}

std::string_view ZoneContext::stance_name(world::Stance stance) const {
    const auto at = static_cast<std::size_t>(stance);
    const std::size_t own = at - world::kFirstNamedStance;
    return at >= world::kFirstNamedStance && own < state_->settings.stances.size()
               ? std::string_view(state_->settings.stances[own])
               : RulesContext::stance_name(stance);
}

RayResult ZoneContext::ray_cast(const Vec3& origin,
                                const Vec3& direction,
                                float max_distance,
                                EntityId ignore) const {
    physics::RayHit hit;
    RayResult result;
    result.hit = state_->scene.ray_cast(origin, direction, max_distance, ignore.value, hit);
    if (result.hit) {
        result.entity = EntityId(hit.user);
        result.distance = hit.distance;
        result.point = hit.point;
        result.normal = hit.normal;
    }
    return result;
}

SeenHit ZoneContext::ray_cast_as_seen(ClientId client,
                                      const Seen& seen,
                                      const Vec3& origin,
                                      const Vec3& direction,
                                      float max_distance,
                                      EntityId ignore) const {
    return zone::ray_cast_as_seen(*state_, client, seen, origin, direction, max_distance, ignore);
}

std::optional<Vec3> ZoneContext::position_after(EntityId entity, Tick tick) const {
    const world::Row row = owned(entity);
    if (row == world::kNoRow || state_->entities.discontinuity_tick[row] > tick) {
        return std::nullopt;
    }
    if (tick == state_->now - 1) {
        return state_->entities.position[row];
    }
    if (tick < state_->now - 1 - state_->settings.rewind.most_ticks) {
        return std::nullopt;
    }
    const std::optional<Pose> pose = state_->history.at(entity, tick, 0.0F);
    return pose ? std::optional<Vec3>(pose->position) : std::nullopt;
}

void ZoneContext::near(const Vec3& point, float radius, std::vector<EntityId>& out) const {
    out.clear();
    const world::Entities& e = state_->entities;
    current_grid(*state_).for_each_within(
        point.x(), point.z(), radius, [&](std::uint32_t row, float) {
            if (!e.has(row, world::kHidden)) {
                out.push_back(e.id[row]);
            }
        });
    std::sort(out.begin(), out.end());
}

std::uint32_t ZoneContext::particles_near(std::string_view system,
                                          const Vec3& point,
                                          float radius) const {
    return zone::particles_near(*state_, system, point, radius);
}

bool ZoneContext::emit(std::string_view system,
                       const Vec3& position,
                       const Vec3& velocity,
                       std::uint32_t count) {
    return emit_particles(*state_, system, position, velocity, count);
}

PendingEvent& ZoneContext::queue_event(const RulesEvent& event, Audience audience) {
    ZONED_ASSERT(event.kind >= kFirstRulesEvent, "kinds below belong to the server");
    PendingEvent& pending = state_->out.events.emplace_back();
    pending.event.event = EventId((++state_->next_event << 16U) | state_->settings.id.value);
    pending.event.tick = state_->now;
    pending.event.kind = event.kind;
    pending.event.confirm = event.confirm;
    pending.event.durable = event.durable;
    pending.event.payload = event.payload;
    pending.audience = audience;
    return pending;
}

EventId ZoneContext::send(ClientId client, const RulesEvent& event) {
    PendingEvent& pending = queue_event(event, Audience::kClient);
    pending.event.recipients.push_back(client);
    const EventId id = pending.event.event;
    if (event.durable) {
        const int index = find_client(*state_, client);
        const std::string account =
            index < 0 ? std::string() : state_->clients[static_cast<std::size_t>(index)].account;
        store_event(pending.event, account);
    }
    return id;
}

EventId ZoneContext::publish(std::string_view topic, const RulesEvent& event) {
    PendingEvent& pending = queue_event(event, Audience::kTopic);
    pending.event.topic = topic;
    if (event.durable) {
        store_event(pending.event, std::string());
    }
    return pending.event.event;
}

EventId ZoneContext::announce(EntityId source, const RulesEvent& event) {
    PendingEvent& pending = queue_event(event, Audience::kViewers);
    pending.source = source;
    if (event.durable) {
        store_event(pending.event, std::string());
    }
    return pending.event.event;
}

void ZoneContext::subscribe(ClientId client, std::string_view topic) {
    state_->out.topics.push_back({client, std::string(topic), true});
}

void ZoneContext::unsubscribe(ClientId client, std::string_view topic) {
    state_->out.topics.push_back({client, std::string(topic), false});
}

void ZoneContext::inside(std::string_view trigger, std::vector<EntityId>& out) const {
    for (std::size_t i = 0; i < state_->triggers.inside.size(); ++i) {
        if (state_->settings.triggers[i].name == trigger) {
            const std::vector<EntityId>& there = state_->triggers.inside[i];
            out.insert(out.end(), there.begin(), there.end());
        }
    }
}

void ZoneContext::message(EntityId target, Bytes payload) {
    state_->out.rules_messages.push_back({target, std::move(payload)});
}

void ZoneContext::message_zone(ZoneId zone, Bytes payload) {
    state_->out.rules_messages.push_back({EntityId(), std::move(payload), zone});
}

void ZoneContext::log(std::string_view line) {
    std::vector<std::string>& lines = state_->out.lines;
    if (lines.size() < kMostLogLines) {
        lines.emplace_back(line.substr(0, kMostLogBytes));
    }
}

void ZoneContext::count(std::string_view name, double amount) {
    state_->out.figures.push_back({std::string(name), amount, true});
}

void ZoneContext::gauge(std::string_view name, double value) {
    state_->out.figures.push_back({std::string(name), value, false});
}

TimerId ZoneContext::start_timer(EntityId entity,
                                 double seconds,
                                 std::uint16_t kind,
                                 Bytes payload) {
    constexpr double kLongest_ticks = 1e15;  // farther than any world lives
    const double ticks = std::max(1.0, std::round(seconds / static_cast<double>(dt())));
    if (!(seconds >= 0.0 && ticks <= kLongest_ticks) ||
        (entity && owned(entity) == world::kNoRow)) {
        return {};
    }
    return state_->timers.start(state_->settings.id,
                                state_->now + static_cast<Tick>(ticks),
                                entity,
                                kind,
                                std::move(payload));
}

void ZoneContext::stop_timer(TimerId timer) {
    state_->timers.stop(timer);
}

void ZoneContext::reset_view(ClientId client) {
    state_->replicator.reset_view(client);
}

void ZoneContext::note_outcome(bool player_succeeded) {
    ai::note_outcome(
        state_->ai_update.difficulty(), state_->settings.ai.difficulty, player_succeeded);
}

RulesParties* ZoneContext::parties() const {
    return state_->parties.book() != nullptr ? &state_->parties : nullptr;
}

RulesInstances* ZoneContext::instances() const {
    return state_->instances.book() != nullptr ? &state_->instances : nullptr;
}

RulesMatches* ZoneContext::matches() const {
    return state_->matches.book() != nullptr ? &state_->matches : nullptr;
}

void ZoneContext::kick(ClientId client, std::string_view reason) {
    state_->out.messages.emplace_back(mailbox::Kick{client, std::string(reason)});
}

bool ZoneContext::travel(ClientId client, std::string_view world, std::string_view arrival) {
    if (!state_->settings.in_cluster || find_client(*state_, client) < 0 || world.empty()) {
        return false;
    }
    state_->out.travels.push_back({client, std::string(world), std::string(arrival)});
    return true;
}

bool may_ask_store(const StepOutput& out, const mailbox::StoreKey& key, const Bytes& value) {
    return core::is_clean_utf8(key.account) && core::is_clean_utf8(key.character) &&
           core::is_clean_utf8(key.key) && mailbox::has_good_lengths(key) &&
           value.size() <= mailbox::kMaxStoreValueBytes &&
           out.store.size() < mailbox::kMaxStoreRequests;
}

std::uint64_t ZoneContext::ask_store(mailbox::StoreAct act,
                                     EntityId target,
                                     const mailbox::StoreKey& key,
                                     Bytes value) {
    if (!may_ask_store(state_->out, key, value)) {
        return 0;
    }
    mailbox::StoreRequest& request = state_->out.store.emplace_back();
    request.act = act;
    request.number = (++state_->next_store_request << 16U) | state_->settings.id.value;
    request.zone = state_->settings.id;
    request.target = target;
    request.key = key;
    request.value = std::move(value);
    return request.number;
}

std::uint64_t ZoneContext::store_get(EntityId target, const mailbox::StoreKey& key) {
    return ask_store(mailbox::StoreAct::kGet, target, key, {});
}

std::uint64_t ZoneContext::store_put(EntityId target, const mailbox::StoreKey& key, Bytes value) {
    return ask_store(mailbox::StoreAct::kPut, target, key, std::move(value));
}

std::uint64_t ZoneContext::store_remove(EntityId target, const mailbox::StoreKey& key) {
    return ask_store(mailbox::StoreAct::kRemove, target, key, {});
}

void ZoneContext::store_stand(const ZoneClient& client) {
    const world::Row row = state_->entities.find(client.avatar);
    if (client.account.empty() || row == world::kNoRow ||
        state_->entities.has(row, world::kGhost) || state_->entities.has(row, world::kHidden)) {
        return;
    }
    mailbox::StoreRequest& request = state_->out.store.emplace_back();
    request.act = mailbox::StoreAct::kStand;
    request.zone = state_->settings.id;
    request.key = {mailbox::StoreScope::kCharacter, client.account, client.name, {}};
    // By the next login the instance may have ended.
    const Vec3d at = state_->instances.return_place(client.client)
                         .value_or(origin() + state_->entities.position[row].cast<double>());
    for (int axis = 0; axis < 3; ++axis) {
        request.position[axis] = at[axis];
    }
}

void ZoneContext::store_event(const mailbox::EventOut& event, const std::string& account) {
    mailbox::StoreRequest& request = state_->out.store.emplace_back();
    request.act = mailbox::StoreAct::kEvent;
    request.zone = state_->settings.id;
    request.key.account = account;
    request.key.key = event.topic;
    request.kind = event.kind;
    request.value = event.payload;
}

}  // namespace zoned::zone
