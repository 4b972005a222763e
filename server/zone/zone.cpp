#include "server/zone/zone.h"

#include "server/zone/assemblies/assembly_spawning.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/assemblies/motors.h"
#include "server/zone/assemblies/riding.h"
#include "server/zone/border/ghosts.h"
#include "server/zone/border/handoff.h"
#include "server/zone/census.h"
#include "server/zone/context/levers.h"
#include "server/zone/context/stop_context.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/inbox.h"
#include "server/zone/simulation/character_movement.h"
#include "server/zone/simulation/character_pushes.h"
#include "server/zone/simulation/copy_from_physics.h"
#include "server/zone/simulation/moving/zone_doors.h"
#include "server/zone/simulation/moving/zone_platforms.h"
#include "server/zone/simulation/representation.h"
#include "server/zone/simulation/zone_agents.h"
#include "server/zone/simulation/zone_particles.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "server/zone/viewers/audit.h"
#include "server/zone/viewers/beyond_states.h"
#include "server/zone/viewers/lag_compensation.h"
#include "server/zone/viewers/visibility_filter.h"
#include "server/zone/zone_hash.h"
#include "server/zone/zone_setup.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace zoned::zone {

namespace {

void start_rules(ZoneState& state) {
    if (!std::exchange(state.rules_started, true)) {
        ZoneContext context(state);
        state.rules->on_start(context);
    }
}

/// Timers of entities that are gone by now concern nobody.
void run_timers(ZoneState& state, ZoneContext& context) {
    while (const std::optional<DueTimer> timer = state.timers.next(state.now)) {
        const world::Row row = state.entities.find(timer->entity);
        if (!timer->entity || (row != world::kNoRow && !state.entities.has(row, world::kGhost))) {
            state.rules->on_timer(context, *timer);
        }
    }
}

/// Due timers, then the commands of players, then the rules' own tick.
std::uint32_t run_rules(ZoneState& state) {
    ZoneContext context(state);
    run_timers(state, context);
    for (std::size_t i = 0; i < state.clients.size(); ++i) {
        const ZoneClient& client = state.clients[i];
        const world::Row row = state.entities.find(client.avatar);
        if (row == world::kNoRow) {
            continue;
        }
        const motion::InputCommand command = state.entities.command[row];
        const auto pressed =
            static_cast<std::uint16_t>(command.buttons & ~state.clients[i].buttons_before);
        state.clients[i].buttons_before = command.buttons;
        state.rules->on_input(context, client.avatar, command, pressed);
        use_lever(state, context, state.clients[i].avatar, pressed);
    }
    state.rules->on_tick(context);
    return static_cast<std::uint32_t>(state.clients.size());
}

/// Where characters stand is worth so much: a crash sets them back by no more.
constexpr float kStandEvery_s = 10.0F;

void store_stands(ZoneState& state) {
    const auto period = std::max<Tick>(1, std::lround(kStandEvery_s / state.settings.dt));
    ZoneContext context(state);
    for (const ZoneClient& client : state.clients) {
        if ((state.now + client.client.value) % period == 0) {
            context.store_stand(client);
        }
    }
}

void collect_viewers(ZoneState& state) {
    state.viewers.clear();
    for (const ZoneClient& client : state.clients) {
        state.viewers.push_back({client.client, client.avatar});
    }
}

std::uint32_t audit_clients(ZoneState& state) {
    std::uint32_t records = 0;
    const ZoneContext context(state);
    follow_radii(state);
    for (ZoneClient& client : state.clients) {
        if (audit_due(state, client) && state.replicator.reaches(client.client)) {
            state.out.messages.emplace_back(audit(state, context, client));
            client.audit_due = false;
            ++records;
        }
    }
    return records;
}

}  // namespace

Zone::Zone(ZoneSettings settings, std::unique_ptr<Rules> rules, Stopwatch stopwatch)
    : state_(std::make_unique<ZoneState>(std::move(settings), std::move(rules))),
      stopwatch_(stopwatch) {
    const std::string wrong = ai::bind_code(state_->settings.ai, state_->rules->coded_machines());
    if (!wrong.empty()) {
        throw std::runtime_error(wrong);
    }
    set_up(*state_);
}

EntityId Zone::spawn(const SpawnDef& def) {
    return spawn_entity(*state_, def);
}

core::Result<EntityJointId> Zone::join_placed(EntityId a, EntityId b, std::uint16_t number) {
    const world::Entities& e = state_->entities;
    const world::Row row_b = e.find(b);
    ZONED_ASSERT(row_b != world::kNoRow, "placed entities were spawned in this zone");
    return join(*state_,
                a,
                b,
                (*state_->settings.placed_joints)[number],
                present_frame(e, a ? e.find(a) : world::kNoRow, row_b),
                {EntityId(), number});
}

template <class Work>
void Zone::pass(Pass which, Work&& work) {
    if (!state_->report.plan.has(which)) {
        return;
    }
    PassReport& report = state_->report.passes[static_cast<std::size_t>(which)];
    const std::uint64_t begin = stopwatch_ != nullptr ? stopwatch_() : 0;
    state_->running = which;
    report.count += work();
    state_->running.reset();
    report.ran = true;
    report.ns += stopwatch_ != nullptr ? stopwatch_() - begin : 0;
}

void Zone::simulate(Tick now, std::span<const mailbox::InboxItem> inbox) {
    ZoneState& s = *state_;
    s.now = now;
    s.out.clear();
    s.report = StepReport{};
    s.report.tick = now;
    start_rules(s);
    s.report.census = take_census(s, inbox.size());
    // Messages may freeze the world or bring the first viewer, so the plan is compiled again after
    // they were read.
    s.report.plan = plan_for(s.report.census);
    pass(Pass::kDoors, [&] { return turn_doors(s); });
    if (!s.paths.empty()) {
        s.paths.follow_doors(now);
    }
    pass(Pass::kInbox, [&] { return apply_inbox(s, inbox); });
    if (s.report.plan.has(Pass::kInbox)) {
        const std::uint32_t turned = s.report.census.turning_doors;
        s.report.census = take_census(s, inbox.size());
        s.report.census.turning_doors = turned;
        s.report.plan = plan_for(s.report.census);
    }
    store_stands(s);
    if (!s.frozen) {
        take_inputs(s);
    }
    pass(Pass::kRules, [&] { return run_rules(s); });
    if (!s.frozen) {
        follow_players(s);
    }
    pass(Pass::kAgents, [&] { return update_agents(s); });
    pass(Pass::kMovement, [&] { return move_characters(s); });
    pass(Pass::kRepresentation, [&] { return choose_representations(s); });
    pass(Pass::kSoft, [&] { return step_soft(s); });
    pass(Pass::kMotors, [&] { return follow_motors(s); });
    pass(Pass::kPlatforms, [&] { return steer_platforms(s); });
    pass(Pass::kPhysics, [&] {
        s.report.physics = s.scene.step(s.settings.dt);
        push_characters(s);
        const std::uint32_t moved = copy_moved_bodies(s);
        return moved + carry_riders(s);
    });
    pass(Pass::kParticles, [&] { return step_particles(s); });
    pass(Pass::kContacts, [&] {
        ZoneContext context(s);
        const std::uint32_t contacts = report_contacts(s, context);
        return contacts + report_breaks(s, context);
    });
    if (!s.frozen) {
        ZoneContext context(s);
        report_triggers(s, context);
    }
    pass(Pass::kHandoff, [&] { return s.report.handoffs_out = hand_off(s); });
}

void Zone::accept_handoff(Handoff& handoff) {
    accept(*state_, handoff);
}

void Zone::publish_ghosts() {
    const StepReport& r = state_->report;
    const bool changed = r.plan.has(Pass::kMovement) || r.plan.has(Pass::kPhysics) ||
                         r.plan.has(Pass::kInbox) || r.plan.has(Pass::kRules) || r.ai.moved ||
                         r.handoffs_out > 0 || state_->accepted || state_->now <= 1;
    state_->accepted = false;
    pass(Pass::kGhosts, [&] {
        export_ghosts(*state_, changed);
        return 0U;
    });
}

void Zone::stop() {
    state_->out.clear();
    StopContext context(*state_);
    state_->rules->on_stop(context);
}

void Zone::stand_still() {
    rest_all(*state_);
    export_ghosts(*state_, true);
}

void Zone::follow_ghosts(std::span<ZoneState* const> zones) {
    pass(Pass::kGhosts, [&] { return import_ghosts(*state_, zones); });
}

void Zone::publish() {
    ZoneState& s = *state_;
    // A handoff may have brought the first viewer or taken the last one.
    const auto viewers = static_cast<std::uint32_t>(s.clients.size());
    if (viewers != s.report.census.viewers) {
        s.report.census = take_census(s, 0);
        const StepPlan plan = plan_for(s.report.census);
        for (const Pass p : {Pass::kInterest,
                             Pass::kVisibilityFilter,
                             Pass::kReplication,
                             Pass::kHistory,
                             Pass::kAudit}) {
            const auto i = static_cast<std::size_t>(p);
            s.report.plan.runs[i] = plan.runs[i];
            s.report.plan.reason[i] = plan.reason[i];
        }
    }
    collect_viewers(s);
    pass(Pass::kInterest, [&] {
        mark_beyond_states(s);
        s.report.interest = s.matcher.step(
            s.entities, *s.settings.types, s.viewers, s.settings.interest, matched_sets(s));
        s.entities.forget_touched(world::Reader::kInterest);
        return s.report.interest.visible_pairs;
    });
    pass(Pass::kVisibilityFilter, [&] { return filter_visibility(s, ZoneContext(s)); });
    pass(Pass::kReplication, [&] { return replicate(s.visibility); });
    pass(Pass::kHistory, [&] { return record_history(s); });
    pass(Pass::kAudit, [&] { return audit_clients(s); });
    pass(Pass::kHash, [&] { return hash_tick(s); });
}

std::uint32_t Zone::replicate(const world::Visibility& sets) {
    ZoneState& s = *state_;
    std::vector<replication::OwnInput>& own = s.own_inputs;
    own.clear();
    for (const ZoneClient& client : s.clients) {
        own.push_back(client.own);
    }
    s.report.replication = s.replicator.step(
        s.now, s.settings.id, s.entities, *s.settings.types, sets, own, s.out.packets);
    return s.report.replication.packets;
}

void Zone::recipients_of(EntityId source, std::vector<ClientId>& out) const {
    for (std::size_t i = 0; i < state_->visibility.size(); ++i) {
        const world::VisibleSet& set = state_->visibility[i];
        const auto it =
            std::lower_bound(set.visible.begin(),
                             set.visible.end(),
                             source,
                             [](const world::Visible& v, EntityId id) { return v.entity < id; });
        if (it != set.visible.end() && it->entity == source &&
            find_client(*state_, set.client) >= 0) {
            out.push_back(set.client);
        }
    }
    for (const ZoneClient& client : state_->clients) {
        if (client.avatar == source) {
            out.push_back(client.client);
        }
    }
}

void Zone::recipients_near(const Vec3d& place,
                           float aura_m,
                           bool line_of_sight,
                           std::vector<ClientId>& out) const {
    const world::Entities& e = state_->entities;
    const Vec3 here = (place - state_->settings.region().origin()).cast<float>();
    for (const ZoneClient& client : state_->clients) {
        const world::Row row = e.find(client.avatar);
        if (row == world::kNoRow) {
            continue;
        }
        const world::EntityType& type = (*state_->settings.types)[e.type[row]];
        const Vec3 d = here - e.position[row];
        if (interest::hears(d.x(),
                            d.z(),
                            type.nimbus_m[e.stance[row]],
                            interest::view_cone(e, *state_->settings.types, row, 0.0F),
                            aura_m,
                            false,
                            0.0F) &&
            (!line_of_sight || sees_place(*state_, row, here))) {
            out.push_back(client.client);
        }
    }
}

bool Zone::owns(EntityId entity) const {
    const world::Row row = state_->entities.find(entity);
    return row != world::kNoRow && !state_->entities.has(row, world::kGhost);
}

}  // namespace zoned::zone
