#include "server/ai/ai_update.h"
#include "server/ai/ai_update_lookup.h"
#include "server/ai/steering/desired_velocity.h"
#include "server/ai/steering/steering.h"

#include <algorithm>
#include <utility>

namespace zoned::ai {

namespace {

bool forages(const Agent& agent, const AiSettings& settings) {
    const CompiledBrain& brain = settings.compiled[agent.brain];
    // Who has just turned to it begins when it steers.
    return brain.forages && !agent.entered &&
           brain.states[agent.current_action].action == ActionKind::kForage;
}

}  // namespace

/// Where a door has turned, those whom nobody sees look up as well.
void AiUpdate::call_foragers(AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings) {
    for (std::size_t n = 0; nests_.turned() && n < agents.size(); ++n) {
        const Slot slot = agents.nth(n);
        Agent& agent = agents.at(slot);
        if (agent.tier == Tier::kSuspended && forages(agent, settings)) {
            agent.next_event = world.now;
            plan(agents, slot, world, settings);
        }
    }
}

/// Where those who look for food go next.
void AiUpdate::forage(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    nests_.clear();
    const std::span<const Slot> active = agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = agents.at(active[i]);
        if (rows_[i] != world::kNoRow && forages(agent, settings)) {
            nests_.add({agent.entity, rows_[i], active[i]});
        }
    }
    for (const DueAgent& due : due_) {
        if (due.tier == Tier::kSuspended && forages(agents.at(due.slot), settings)) {
            nests_.add({due.entity, due.row, due.slot});
        }
    }
    nests_.step(agents,
                {world.entities,
                 world.types,
                 world.points_of_interest,
                 world.statics,
                 settings.compiled,
                 world.half_size,
                 world.now,
                 world.dt});
    report_.delivered = nests_.delivered();
}

// ---------------------------------------------------------------- herds that nobody sees

HerdDrift AiUpdate::drift_of(const AgentStore& agents, const AiContext& world) const {
    // Twice: who has to wait for its turn walks on meanwhile.
    return {agents, slot_hints_, world.now, world.dt, kHerdStale_m + 2.0F * drift_m_};
}

/// All look around before any of them walks on.
void AiUpdate::head_herds(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    if (!has_herds(settings)) {
        return;
    }
    herds_.clear();
    slot_hints_.resize(std::max<std::size_t>(slot_hints_.size(), world.entities.size()));
    const OffscreenContext in = offscreen(world);
    for (DueAgent& due : due_) {
        Agent& agent = agents.at(due.slot);
        const CompiledBrain& brain = brain_of(agent, settings);
        if (due.tier != Tier::kSuspended || !roams_on(agent, brain, world.now)) {
            continue;
        }
        const BrainState& state = brain.states[agent.current_action];
        const Surroundings around = in.around(agent, due.row, due.slot);
        if (std::exchange(agent.entered, false)) {
            begin_action(agent, state, around);
        }
        get_unstuck(agent, state, around);
        slot_hints_[due.row] = due.slot;
        due.roams = true;
        herds_.add(due.slot, due.row, world.entities.position[due.row]);
    }
    for (const HerdStep& stepper : herd_steps_) {
        slot_hints_[stepper.row] = stepper.slot;
        herds_.add(stepper.slot, stepper.row, agents.at(stepper.slot).target);
    }
    const HerdDrift drift = drift_of(agents, world);
    herds_.step(agents,
                {world.entities,
                 world.types,
                 world.points_of_interest,
                 world.statics,
                 settings.compiled,
                 drift,
                 settings.reduce_far,
                 world.now,
                 world.dt});
    std::size_t n = 0;
    for (DueAgent& due : due_) {
        if (due.roams) {
            due.end = herds_.end(n++);
        }
    }
    for (HerdStep& stepper : herd_steps_) {
        stepper.end = herds_.end(n++);
    }
}

void AiUpdate::walk_herd_steps(AgentStore& agents,
                               const AiContext& world,
                               const AiSettings& settings) {
    in_lanes(world.team, herd_steps_.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            HerdStep& stepper = herd_steps_[i];
            Agent& agent = agents.at(stepper.slot);
            const CompiledBrain& brain = brain_of(agent, settings);
            const Vec3 from = agent.target;
            take_step(agent, brain, offscreen(world), from, stepper.end);
            const Vec2 here(from.x(), from.z());
            // Of those beyond the border whom it may come to know of, and who may come to know of
            // it, rows are all that is known.
            const float known_m = brain.states[agent.current_action].radius_m + kHerdStale_m;
            const bool at_border = ((world.half_size - here.cwiseAbs()).array() < known_m).any();
            if (at_border || !stepper.end.stands || (here - agent.placed).norm() >= kHerdStale_m) {
                world.entities.position[stepper.row] = from;
                world.entities.discontinuity_tick[stepper.row] = world.now;
                agent.placed = here;
            }
            restart_progress(agent, from, world.now);
            lane.drift_m = std::max(lane.drift_m, step_of(agent));
            agent.next_event =
                std::min(agent.next_decision, std::max(agent.again_at, world.now + 1));
            stepper.left = std::max(left_at(agent, world), world.now + 1);
        }
    });
}

/// Their next steps.
void AiUpdate::settle_herd_steps(AgentStore& agents,
                                 const AiContext& world,
                                 const AiSettings& settings) {
    for (const HerdStep& stepper : herd_steps_) {
        const world::Row row = stepper.row;
        plan(agents, stepper.slot, world, settings);
        settle(agents, stepper.slot, stepper.left, world);
        if (world.entities.discontinuity_tick[row] == world.now) {
            world.entities.touch(row);
            report_.moved = true;
        }
        if (!stepper.end.stands) {
            waking_.push_back(stepper.slot);
        }
        ++report_.events;
    }
}

/// An active one, from where its body is. False: it would leave the ground.
bool AiUpdate::set_roaming(Agent& agent,
                           const DueAgent& due,
                           const AiContext& world,
                           const AiSettings& settings) {
    const OffscreenContext in = offscreen(world);
    const CompiledBrain& brain = brain_of(agent, settings);
    start_segment(agent, in.around(agent, due.row, due.slot));
    const Vec3 from = world.entities.position[due.row];
    agent.timed = roam(agent, brain, in, due.row, from, path_ahead(agent, brain, in, due.row));
    agent.placed = Vec2(from.x(), from.z());
    drift_m_ = std::max(drift_m_, step_of(agent));
    return agent.timed;
}

/// When something may happen next to one that nobody sees. Of who took no decision the forecast of
/// the last one holds, whichever way its herd goes.
Tick AiUpdate::event_after(Agent& agent,
                           const DueAgent& due,
                           const AiContext& world,
                           const AiSettings& settings) const {
    if (due.roams && !due.decides) {
        return std::min(agent.next_decision, std::max(agent.again_at, world.now + 1));
    }
    const CompiledBrain& brain = brain_of(agent, settings);
    return due.decides || due.waited || due.changed
               ? next_event(agent, brain, offscreen(world))
               : next_event_undecided(agent, brain, offscreen(world));
}

// ---------------------------------------------------------------- formations, avoidance

/// Where those who form up around somebody are to be now.
void AiUpdate::formation_following(AgentStore& agents,
                                   const AiContext& world,
                                   const AiSettings& settings) {
    formations_.clear();
    const std::span<const Slot> active = agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = agents.at(active[i]);
        const CompiledBrain& brain = settings.compiled[agent.brain];
        if (rows_[i] == world::kNoRow || !brain.forms_up || !agent.ward ||
            brain.states[agent.current_action].action != ActionKind::kFormUp) {
            continue;
        }
        const world::Row captain = world.entities.find(agent.ward);
        if (captain != world::kNoRow) {
            formations_.add({agent.ward, agent.entity, captain, rows_[i], active[i]});
        }
    }
    if (!formations_.empty()) {
        formations_.place(agents,
                          world.entities,
                          world.types,
                          settings.compiled,
                          walls_.of(world.statics),
                          world.now);
    }
}

/// Whoever would meet somebody avoids it; what it wants stays its aim.
void AiUpdate::local_avoidance(AgentStore& agents,
                               const AiContext& world,
                               const AiSettings& settings) {
    if (!settings.avoidance) {
        return;
    }
    walkers_.clear();
    const std::span<const Slot> active = agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        if (rows_[i] != world::kNoRow) {
            const Agent& agent = agents.at(active[i]);
            const BrainState& state = settings.compiled[agent.brain].states[agent.current_action];
            const Vec3& at = world.entities.position[rows_[i]];
            walkers_.push_back(
                {rows_[i],
                 path_left(agent, state, world.points_of_interest, Vec2(at.x(), at.z()))});
        }
    }
    report_.avoidance = local_avoidance_.step(
        walkers_,
        {world.entities, world.types, world.statics, walls_, world.team, world.now, world.dt},
        *settings.avoidance);
}

}  // namespace zoned::ai
