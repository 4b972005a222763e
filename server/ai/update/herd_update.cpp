#include "server/ai/update/herd_update.h"

#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/desired_velocity.h"
#include "server/ai/steering/steering.h"

#include <algorithm>
#include <utility>

namespace zoned::ai {

HerdDrift drift_of(const AiContext& ai, const AiTurn& turn) {
    // Twice the drift: an animal that has to wait for its turn walks on meanwhile.
    return {ai.agents, turn.slot_hints, ai.now, ai.dt, kHerdStale_m + 2.0F * turn.drift_m};
}

/// All animals look around before any of them walks on.
void HerdUpdate::head_herds(const AiContext& ai, AiTurn& turn) {
    if (!has_herds(ai.settings)) {
        return;
    }
    herds_.clear();
    turn.slot_hints.resize(std::max<std::size_t>(turn.slot_hints.size(), ai.entities.size()));
    for (DueAgent& due : turn.due) {
        Agent& agent = ai.agents.at(due.slot);
        const CompiledBrain& brain = brain_of(agent, ai.settings);
        if (due.tier != Tier::kSuspended || !roams_on(agent, brain, ai.now)) {
            continue;
        }
        const BrainState& state = brain.states[agent.current_action];
        const Surroundings around = surroundings_of(ai, agent, due.row, due.slot);
        if (std::exchange(agent.entered, false)) {
            begin_action(agent, state, around);
        }
        get_unstuck(agent, state, around);
        turn.slot_hints[due.row] = due.slot;
        due.roams = true;
        herds_.add(due.slot, due.row, ai.entities.position[due.row]);
    }
    for (const HerdStep& stepper : turn.herd_steps) {
        turn.slot_hints[stepper.row] = stepper.slot;
        herds_.add(stepper.slot, stepper.row, ai.agents.at(stepper.slot).target);
    }
    const HerdDrift drift = drift_of(ai, turn);
    herds_.step(ai, drift);
    std::size_t n = 0;
    for (DueAgent& due : turn.due) {
        if (due.roams) {
            due.end = herds_.end(n++);
        }
    }
    for (HerdStep& stepper : turn.herd_steps) {
        stepper.end = herds_.end(n++);
    }
}

void HerdUpdate::walk_herd_steps(const AiContext& ai, AiTurn& turn) {
    turn.in_lanes(
        ai.team, turn.herd_steps.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                HerdStep& stepper = turn.herd_steps[i];
                Agent& agent = ai.agents.at(stepper.slot);
                const CompiledBrain& brain = brain_of(agent, ai.settings);
                const Vec3 from = agent.target;
                take_step(agent, brain, ai, from, stepper.end);
                const Vec2 here(from.x(), from.z());
                // Of entities beyond the border only the positions in rows are known. This covers
                // those that the animal may notice, and those that may notice it.
                const float known_m = brain.states[agent.current_action].radius_m + kHerdStale_m;
                const bool at_border = ((ai.half_size - here.cwiseAbs()).array() < known_m).any();
                if (at_border || !stepper.end.stands ||
                    (here - agent.placed).norm() >= kHerdStale_m) {
                    ai.entities.position[stepper.row] = from;
                    ai.entities.discontinuity_tick[stepper.row] = ai.now;
                    agent.placed = here;
                }
                restart_progress(agent, from, ai.now);
                lane.drift_m = std::max(lane.drift_m, step_of(agent));
                agent.next_event =
                    std::min(agent.next_decision, std::max(agent.again_at, ai.now + 1));
                stepper.left = std::max(left_at(agent, ai), ai.now + 1);
            }
        });
}

/// Schedules the next steps of the animals.
void HerdUpdate::settle_herd_steps(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    for (const HerdStep& stepper : turn.herd_steps) {
        const world::Row row = stepper.row;
        schedule_event(ai, stepper.slot);
        meetings.settle(ai, turn, stepper.slot, stepper.left);
        if (ai.entities.discontinuity_tick[row] == ai.now) {
            ai.entities.touch(row);
            turn.report.moved = true;
        }
        if (!stepper.end.stands) {
            turn.waking.push_back(stepper.slot);
        }
        ++turn.report.events;
    }
}

/// Sets an active agent on its first step, from the position of its body. False: the step would
/// leave the ground.
bool HerdUpdate::set_roaming(Agent& agent, const DueAgent& due, const AiContext& ai, AiTurn& turn) {
    const CompiledBrain& brain = brain_of(agent, ai.settings);
    start_segment(agent, surroundings_of(ai, agent, due.row, due.slot));
    const Vec3 from = ai.entities.position[due.row];
    agent.timed = roam(agent, brain, ai, due.row, from, path_ahead(agent, brain, ai, due.row));
    agent.placed = Vec2(from.x(), from.z());
    turn.drift_m = std::max(turn.drift_m, step_of(agent));
    return agent.timed;
}

}  // namespace zoned::ai
