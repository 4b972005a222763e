#include "server/zone/border/handoff.h"

#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/simulation/approaching_props.h"
#include "server/zone/simulation/soft_hull.h"
#include "server/zone/simulation/spawning.h"
#include "server/zone/simulation/zone_agents.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

/// Contact keeps an island together only this far beyond the border, m.
constexpr double kReach = 20.0;
/// An entity this far below the ground or outside the world has fallen out of it, m.
constexpr double kLost = 50.0;
constexpr double kWorldSlack = 4.0;

Vec3d world_position(const ZoneState& state, world::Row row) {
    return state.settings.region().origin() + state.entities.position[row].cast<double>();
}

/// The zone that a point lies in; none outside the world.
ZoneId zone_at(const ZoneState& state, const Vec3d& at) {
    for (const Region& region : state.settings.regions) {
        if (region.outside(at.x(), at.z()) == 0.0) {
            return region.id;
        }
    }
    return {};
}

bool is_owned_prop(const ZoneState& state, world::Row row) {
    return is_prop(state, row) && !state.entities.has(row, world::kGhost);
}

/// Rows of the owned props that touch `row` through contacts, itself included, of those that are
/// about to touch it, and of all that joints and riding hold to them.
std::vector<world::Row> island_rows(const ZoneState& state, world::Row row) {
    std::vector<world::Row> rows;
    if (!is_owned_prop(state, row) || !state.entities.body[row]) {
        rows.push_back(row);
        add_held_and_touching(state, rows);
        return rows;
    }
    std::vector<BodyId> bodies;
    state.scene.island_of(state.entities.body[row], bodies);
    for (const BodyId body : bodies) {
        const world::Row member = state.entities.find(EntityId(state.scene.user(body)));
        if (member != world::kNoRow && is_owned_prop(state, member)) {
            rows.push_back(member);
        }
    }
    for (const world::Row near : approached(state, row, false)) {
        if (std::find(rows.begin(), rows.end(), near) == rows.end()) {
            rows.push_back(near);
        }
    }
    add_held_and_touching(state, rows);
    return rows;
}

std::vector<world::Visible> heard_by(const ZoneState& state, ClientId client) {
    const world::Visibility& sets = matched_sets(state);
    const auto it = std::find_if(sets.begin(), sets.end(), [&](const world::VisibleSet& set) {
        return set.client == client;
    });
    return it != sets.end() ? it->visible : std::vector<world::Visible>();
}

/// The matcher of this zone goes on from the client's visible set in the zone before.
void continue_hearing(ZoneState& state, ClientId client, std::vector<world::Visible> visible) {
    world::Visibility& sets = matched_sets(state);
    const auto at = std::lower_bound(
        sets.begin(), sets.end(), client, [](const world::VisibleSet& set, ClientId wanted) {
            return set.client < wanted;
        });
    if (at != sets.end() && at->client == client) {
        at->visible = std::move(visible);
        at->stamp = 0;
        return;
    }
    world::VisibleSet set;
    set.client = client;
    set.visible = std::move(visible);
    sets.insert(at, std::move(set));
}

Handoff take(ZoneState& state, world::Row row, ZoneId to) {
    world::Entities& e = state.entities;
    step_up_soft(state, row);
    Handoff h;
    h.from = state.settings.id;
    h.to = to;
    h.state = read_entity(e, row);
    h.rules = state.rules->take_entity(h.state.id);
    h.timers = state.timers.take(h.state.id);
    if (state.agents.find(h.state.id) != nullptr) {
        if (!state.settings.ai.difficulty.levels.empty()) {
            wake_agent(state, row);  // it may go on by other brains
        }
        h.level = state.ai_update.difficulty().level;
        state.paths.release(state.agents.slot_of(h.state.id));
        h.agent = state.agents.take(h.state.id);
    }
    const int index = h.state.client ? find_client(state, h.state.client) : -1;
    if (index >= 0) {
        h.client = state.clients[static_cast<std::size_t>(index)];
        h.transfer = state.replicator.remove_client(h.state.client);
        h.visible = heard_by(state, h.state.client);
        state.clients.erase(state.clients.begin() + index);
    }
    h.soft = take_soft(state, h.state.id);
    if (const Rider* ride = ride_of(state, h.state.id)) {
        h.ride = *ride;
        take_ride(state, h.state.id);
    }
    remove_body(state, row);
    e.remove(row);
    state.grid_valid = false;
    return h;
}

void rest_at(ZoneState& state, world::Row row, const Vec3& place) {
    world::Entities& e = state.entities;
    e.position[row] = place;
    e.velocity[row].setZero();
    e.angular_velocity[row].setZero();
    e.discontinuity_tick[row] = state.now;
    e.set(row, world::kAtRest, false);
    if (e.body[row]) {
        state.scene.set_state(e.body[row],
                              {place, e.orientation[row], Vec3::Zero(), Vec3::Zero(), false});
    }
}

/// An entity that fell out of the world is put back on the ground, just inside, and all that joints
/// hold to it with it.
void put_back(ZoneState& state, world::Row row) {
    step_up_soft(state, row);
    world::Entities& e = state.entities;
    const Region& region = state.settings.region();
    const Vec3d origin = region.origin();
    const auto half_x = static_cast<float>(region.max_x - origin.x()) - 2.0F;
    const auto half_z = static_cast<float>(region.max_z - origin.z()) - 2.0F;
    Vec3 p = e.position[row];
    p.x() = std::clamp(p.x(), -half_x, half_x);
    p.z() = std::clamp(p.z(), -half_z, half_z);
    p.y() = state.settings.statics->floor_at(p.x(), p.z()) + 2.0F;
    const Vec3 shift = p - e.position[row];
    std::vector<world::Row> rows{row};
    add_held(state, rows);
    for (const world::Row held : rows) {
        rest_at(state, held, held == row ? p : Vec3(e.position[held] + shift));
    }
    place_soft(state, row);
    state.grid_valid = false;
    ++state.report.out_of_world;
}

bool is_lost(const ZoneState& state, const Vec3d& at) {
    if (!at.allFinite() || at.y() < state.settings.statics->ground_height() - kLost) {
        return true;
    }
    for (const Region& region : state.settings.regions) {
        if (region.outside(at.x(), at.z()) <= kWorldSlack) {
            return false;
        }
    }
    return true;
}

/// The zone that the island of `row` has to go to, or none.
ZoneId destination(const ZoneState& state,
                   const std::vector<world::Row>& island,
                   ZoneId ghost_owner) {
    Vec3d mean = Vec3d::Zero();
    for (const world::Row row : island) {
        mean += world_position(state, row);
    }
    mean /= static_cast<double>(island.size());
    const double outside = state.settings.region().outside(mean.x(), mean.z());
    if (ghost_owner && ghost_owner < state.settings.id &&
        state.settings.regions[ghost_owner.value - 1U].outside(mean.x(), mean.z()) < kReach) {
        return ghost_owner;
    }
    return outside > state.settings.handoff_hysteresis_m ? zone_at(state, mean) : ZoneId();
}

std::vector<std::pair<EntityId, physics::BodyHistory>> histories_of(
    const ZoneState& state,
    const std::vector<EntityId>& entities) {
    std::vector<std::pair<EntityId, physics::BodyHistory>> histories;
    for (const EntityId entity : entities) {
        const BodyId body = state.entities.body[state.entities.find(entity)];
        if (body) {
            histories.emplace_back(entity, state.scene.history(body));
        }
    }
    return histories;
}

void leave_together(ZoneState& state, const std::vector<world::Row>& island, ZoneId to) {
    std::vector<EntityId> ids;
    for (const world::Row row : island) {
        ids.push_back(state.entities.id[row]);
    }
    std::sort(ids.begin(), ids.end());
    std::vector<std::pair<EntityId, physics::BodyHistory>> histories = histories_of(state, ids);
    std::vector<JointTransfer> joints = take_joints(state, ids);
    for (const EntityId id : ids) {
        state.out.handoffs.push_back(take(state, state.entities.find(id), to));
    }
    // With the last of them all ends are there. In the order of their ids, the next zone solves
    // them as this one did.
    std::sort(joints.begin(), joints.end(), [](const JointTransfer& a, const JointTransfer& b) {
        return a.joint.id < b.joint.id;
    });
    state.out.handoffs.back().joints = std::move(joints);
    state.out.handoffs.back().histories = std::move(histories);
}

/// A collision is solved in one zone, else each would treat the other's body as immovable: an
/// entity that is about to touch a ghost counts as touching it.
void note_approaches(ZoneState& state) {
    for (std::size_t i = 0; i < state.ghost_ids.size(); ++i) {
        const world::Row ghost = state.entities.find(state.ghost_ids[i]);
        if (state.settings.id < state.ghost_owners[i] || ghost == world::kNoRow ||
            !state.entities.has(ghost, world::kGhost) || !state.entities.body[ghost] ||
            !is_prop(state, ghost)) {
            continue;
        }
        for (const world::Row row : approached(state, ghost, false)) {
            state.ghost_contacts.push_back({state.entities.id[row], state.ghost_owners[i]});
        }
    }
}

/// True when a ghost prop that is about to touch `row` will come over to this zone for it.
bool expects_company(const ZoneState& state, world::Row row) {
    if (!is_owned_prop(state, row) || !state.entities.body[row]) {
        return false;
    }
    const std::vector<world::Row> ghosts = approached(state, row, true);
    return std::any_of(ghosts.begin(), ghosts.end(), [&](world::Row ghost) {
        const auto it = std::lower_bound(
            state.ghost_ids.begin(), state.ghost_ids.end(), state.entities.id[ghost]);
        return it != state.ghost_ids.end() && *it == state.entities.id[ghost] &&
               state.settings.id <
                   state.ghost_owners[static_cast<std::size_t>(it - state.ghost_ids.begin())];
    });
}

/// Props that touch a ghost of a zone with a lower number, or soon will: their island belongs
/// there.
void follow_ghost_contacts(ZoneState& state) {
    for (const GhostContact& contact : state.ghost_contacts) {
        const world::Row row = state.entities.find(contact.prop);
        if (row == world::kNoRow || !is_owned_prop(state, row)) {
            continue;
        }
        const std::vector<world::Row> island = island_rows(state, row);
        const ZoneId to = destination(state, island, contact.owner);
        if (to && to != state.settings.id) {
            leave_together(state, island, to);
        }
    }
    state.ghost_contacts.clear();
}

}  // namespace

std::uint32_t hand_off(ZoneState& state) {
    note_approaches(state);
    follow_ghost_contacts(state);
    const world::Entities& e = state.entities;
    // Another row fills the gap of an entity that leaves, and comes next.
    for (world::Row row = e.moving().next(0); row != world::kNoRow; row = e.moving().next(row)) {
        if (e.has(row, world::kGhost) || e.has(row, world::kHidden)) {
            ++row;
            continue;
        }
        const Vec3d at = world_position(state, row);
        if (is_lost(state, at)) {
            put_back(state, row);
        } else if (state.settings.region().outside(at.x(), at.z()) >
                       state.settings.handoff_hysteresis_m &&
                   !expects_company(state, row)) {
            const std::vector<world::Row> island = island_rows(state, row);
            const ZoneId to = destination(state, island, ZoneId());
            if (to && to != state.settings.id) {
                leave_together(state, island, to);
                continue;
            }
        }
        ++row;
    }
    return static_cast<std::uint32_t>(state.out.handoffs.size());
}

void accept(ZoneState& state, Handoff& handoff) {
    world::Entities& e = state.entities;
    const EntityId id = handoff.state.id;
    const Vec3 shift = (state.settings.regions[handoff.from.value - 1U].origin() -
                        state.settings.region().origin())
                           .cast<float>();
    const world::Row ghost = e.find(id);
    if (ghost != world::kNoRow) {
        ZONED_ASSERT(e.has(ghost, world::kGhost), "an entity has one owner");
        remove_body(state, ghost);
        e.remove(ghost);
    }
    const world::Row row = e.add(id, handoff.state.type);
    write_entity(handoff.state, shift, e, row);
    e.set(row, world::kGhost, false);
    if (!handoff.soft.empty()) {
        give_soft(state, row, std::move(handoff.soft), shift);
    } else if (!e.has(row, world::kHidden)) {
        add_body(state, row, e.has(row, world::kAtRest));
    }
    if (handoff.agent) {
        ai::shift(*handoff.agent, shift);
        ai::migrate_from_level(
            *handoff.agent, state.settings.ai, handoff.level, state.now, state.settings.dt);
        state.agents.add(*handoff.agent);
    }
    if (handoff.client) {
        const auto at = std::lower_bound(
            state.clients.begin(),
            state.clients.end(),
            handoff.client->client,
            [](const ZoneClient& c, ClientId wanted) { return c.client < wanted; });
        e.command[row] = handoff.client->inputs.last();
        state.clients.insert(at, *handoff.client);
        state.replicator.add_client(handoff.transfer);
        continue_hearing(state, handoff.client->client, std::move(handoff.visible));
    }
    for (JointTransfer& joint : handoff.joints) {
        give_joint(state, std::move(joint), shift);
    }
    for (const auto& [entity, history] : handoff.histories) {
        const BodyId body = e.body[e.find(entity)];
        if (body) {  // a soft body left its rigid form behind
            state.scene.set_history(body, history);
        }
    }
    if (handoff.ride) {
        give_ride(state, *handoff.ride);
    }
    state.rules->load_entity(id, handoff.rules);
    state.timers.give(std::move(handoff.timers));
    state.accepted = true;
    state.grid_valid = false;
}

}  // namespace zoned::zone
