#include "server/zone/zone_state.h"

#include "server/zone/simulation/zone_particles.h"
#include "server/zone/type_body.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

constexpr float kGridCell = 32.0F;

void add_static_bodies(ZoneState& state) {
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = physics::Shape::plane();
    ground.position = Vec3(0.0F, state.settings.statics->ground_height(), 0.0F);
    ground.material.friction = 0.6F;
    const auto added = state.scene.add(ground);
    ZONED_ASSERT(added.ok(), "the ground is a valid body");
    for (const motion::StaticBox& box : state.settings.statics->boxes()) {
        physics::BodyDef def;
        def.kind = physics::BodyKind::kStatic;
        def.shape = physics::Shape::box(box.half_extents);
        def.position = box.centre;
        def.orientation = box.orientation;
        def.material = {box.friction, box.restitution};
        const auto body = state.scene.add(def);
        ZONED_ASSERT(body.ok(), "static boxes were checked when the config was read");
    }
    for (const SurfaceBody& surface : state.settings.surfaces) {
        physics::BodyDef def;
        def.kind = physics::BodyKind::kStatic;
        def.shape = surface.shape;
        def.position = surface.position;
        def.orientation = surface.orientation;
        def.material = surface.material;
        const auto body = state.scene.add(def);
        ZONED_ASSERT(body.ok(), "surfaces were checked when the config was read");
    }
}

void list_rows(const world::RowSet& a, const world::RowSet& b, std::vector<world::Row>& out) {
    out.clear();
    world::for_each_row(a, b, [&](world::Row row) { out.push_back(row); });
}

void build_grid(ZoneState& state) {
    // So many that doze may have been touched before they are kept anew.
    constexpr std::size_t kTouchedShare = 16;
    world::Entities& e = state.entities;
    const std::size_t stirring = e.stirring().count();
    if (stirring == e.size()) {
        state.grid.build(e.position, kGridCell);
        return;
    }
    list_rows(e.stirring(), e.touched(world::Reader::kGrid), state.grid_rows);
    if (state.grid_rows.size() - stirring > e.size() / kTouchedShare) {
        state.grid_rows.clear();
        for (world::Row row = 0; row < e.size(); ++row) {
            if (!e.stirring().has(row)) {
                state.grid_rows.push_back(row);
            }
        }
        state.grid.keep(e.position, state.grid_rows, kGridCell);
        e.forget_touched(world::Reader::kGrid);
        list_rows(e.stirring(), e.stirring(), state.grid_rows);
    }
    state.grid.follow(e.position, state.grid_rows, kGridCell);
}

/// Predictions of what falls end where characters stand as well.
replication::ReplicationSettings with_ground(const ZoneSettings& settings) {
    replication::ReplicationSettings out = settings.replication;
    out.ground = settings.statics;
    return out;
}

}  // namespace

void StepOutput::clear() {
    packets.clear();
    messages.clear();
    events.clear();
    bursts.clear();
    clocks.clear();
    topics.clear();
    rules_messages.clear();
    handoffs.clear();
    departed.clear();
}

ZoneState::ZoneState(ZoneSettings zone_settings, std::unique_ptr<Rules> game_rules)
    : settings(std::move(zone_settings)),
      scene(settings.physics),
      rules(std::move(game_rules)),
      rng(settings.seed, settings.id.value),
      replicator(with_ground(settings)) {
    const Vec3d origin = settings.region().origin();
    points_of_interest = ai::PointsOfInterest(
        settings.ai.points_of_interest, Vec2d(origin.x(), origin.z()), settings.dt);
    ai_update.difficulty() = ai::first_of(settings.ai.difficulty);
    filters_visibility = std::any_of(
        settings.types->begin(), settings.types->end(), [](const world::EntityType& type) {
            return type.visibility_filter != world::VisibilityFilter::kNothing;
        });
    const bool rewinds = std::any_of(settings.types->begin(),
                                     settings.types->end(),
                                     [](const world::EntityType& type) { return type.rewindable; });
    if (rewinds) {
        // The present is one of them, and the tick that is being made replaces one.
        history.resize(settings.rewind.most_ticks + 2);
    }
    add_static_bodies(*this);
    add_doors(*this);
    add_particle_systems(*this);
    const Region& region = settings.region();
    paths = ai::PathService(settings.ai.pathfinding,
                            *settings.statics,
                            paths_area(region.max_x - region.min_x,
                                       region.max_z - region.min_z,
                                       settings.handoff_hysteresis_m,
                                       settings.ai.pathfinding.cell_m),
                            *settings.types,
                            now,
                            origin);
}

world::Visibility& matched_sets(ZoneState& state) {
    return state.filters_visibility ? state.filtered.heard : state.visibility;
}

const world::Visibility& matched_sets(const ZoneState& state) {
    return state.filters_visibility ? state.filtered.heard : state.visibility;
}

int find_client(const ZoneState& state, ClientId client) {
    const auto it = std::lower_bound(
        state.clients.begin(), state.clients.end(), client, [](const ZoneClient& c, ClientId id) {
            return c.client < id;
        });
    return it != state.clients.end() && it->client == client
               ? static_cast<int>(it - state.clients.begin())
               : -1;
}

EntityId next_entity_id(ZoneState& state) {
    const auto zones = static_cast<std::uint32_t>(state.settings.regions.size());
    const std::uint32_t id = state.settings.id.value + zones * state.next_entity++;
    return EntityId(id);
}

void add_body(ZoneState& state, world::Row row, bool asleep) {
    world::Entities& e = state.entities;
    if (is_soft(state, row)) {
        // Soft bodies do not meet each other: a rigid ghost of one, that nothing can push, would
        // throw another about.
        if (!e.has(row, world::kGhost)) {
            add_soft(state, row, asleep);
        }
        return;
    }
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    physics::BodyDef def = body_of(type, state.settings.solids);
    if (e.has(row, world::kGhost)) {
        def.kind = physics::BodyKind::kKinematic;  // its owner moves it
    }
    def.position = e.position[row];
    def.orientation = e.orientation[row];
    def.velocity = e.velocity[row];
    def.angular_velocity = e.angular_velocity[row];
    def.user = e.id[row].value;
    if (type.rewindable) {
        def.filter.category = kRewindableCategory;
    }
    def.asleep = asleep && def.kind == physics::BodyKind::kDynamic;
    const ContactWish wish = state.rules->contact_wish(e.type[row]);
    def.events = static_cast<std::uint8_t>((wish.lasts ? physics::kTellPersist : 0) |
                                           (wish.ends ? physics::kTellEnd : 0));
    const auto body = state.scene.add(def);
    ZONED_ASSERT(body.ok(), "entity types and states are valid bodies");
    e.body[row] = *body;
}

void remove_body(ZoneState& state, world::Row row) {
    state.entities.representation[row] = 0;
    if (state.entities.body[row]) {
        state.scene.remove(state.entities.body[row]);
        state.entities.body[row] = BodyId();
    }
    if (state.soft != nullptr) {
        remove_soft(state, state.entities.id[row]);
    }
}

void add_agent(ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    if (type.brain == 0) {
        return;
    }
    ai::Agent agent;
    agent.entity = e.id[row];
    const std::vector<std::uint16_t>& of_type = state.settings.ai.brain_of_type;
    agent.brain =
        static_cast<std::uint16_t>((of_type.empty() ? type.brain : of_type[e.type[row]]) - 1);
    ai::begin(agent, state.settings.ai.compiled[agent.brain], state.now);
    agent.home = e.position[row];
    agent.target = e.position[row];
    agent.rng = core::Rng(state.settings.seed, e.id[row].value);
    state.agents.add(agent);
}

EntityId spawn_entity(ZoneState& state, const SpawnDef& def) {
    const EntityId id = next_entity_id(state);
    world::Entities& e = state.entities;
    const world::Row row = e.add(id, def.type);
    const bool character = (*state.settings.types)[def.type].kind == world::EntityKind::kCharacter;
    e.position[row] = def.position;
    e.orientation[row] = character ? motion::orientation_from_yaw(def.yaw) : def.orientation;
    e.velocity[row] = def.velocity;
    e.angular_velocity[row] = def.angular_velocity;
    e.yaw[row] = def.yaw;
    e.command[row].yaw = def.yaw;
    e.appearance[row] = def.appearance;
    e.set_client(row, def.client);
    e.discontinuity_tick[row] = state.now;
    e.set(row, world::kAtRest, def.asleep && !character);
    add_body(state, row, def.asleep);
    add_agent(state, row);
    state.grid_valid = false;
    return id;
}

void despawn_entity(ZoneState& state, world::Row row) {
    remove_body(state, row);
    if (state.agents.find(state.entities.id[row]) != nullptr) {
        state.paths.release(state.agents.slot_of(state.entities.id[row]));
        state.agents.take(state.entities.id[row]);
    }
    state.entities.remove(row);
    state.grid_valid = false;
}

const spatial::PointGrid& current_grid(ZoneState& state) {
    if (!state.grid_valid) {
        build_grid(state);
        state.grid_valid = true;
    }
    return state.grid;
}

}  // namespace zoned::zone
