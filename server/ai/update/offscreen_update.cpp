#include "server/ai/update/offscreen_update.h"

#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/path_following.h"
#include "server/ai/update/herd_update.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// The next tick at which something may happen to a suspended agent. For an agent that took no
/// decision the forecast of its last decision still holds, wherever its herd goes.
Tick event_after(Agent& agent, const DueAgent& due, const AiContext& ai) {
    if (due.roams && !due.decides) {
        return std::min(agent.next_decision, std::max(agent.again_at, ai.now + 1));
    }
    const CompiledBrain& brain = brain_of(agent, ai.settings);
    return due.decides || due.waited || due.changed ? next_event(agent, brain, ai)
                                                    : next_event_undecided(agent, brain, ai);
}

/// Where a platform comes by it may take an agent along, which happens to simulated ones alone.
bool beside_platform(const AiContext& ai, world::Row row) {
    if (ai.platforms == nullptr) {
        return false;
    }
    const motion::CharacterLimits& body = ai.types[ai.entities.type[row]].character;
    const float reach = body.radius + body.half_segment + body.step_down;
    const Vec3& at = ai.entities.position[row];
    const auto count = static_cast<std::uint32_t>(ai.platforms->platforms().size());
    for (std::uint32_t platform = 0; platform < count; ++platform) {
        if (ai.platforms->platform_bounds(platform).grown(reach).contains(at)) {
            return true;
        }
    }
    return false;
}

}  // namespace

void OffscreenUpdate::clear() {
    suspended_.clear();
    resumed_.clear();
}

void OffscreenUpdate::resume_waking(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    std::sort(turn.waking.begin(), turn.waking.end(), [&](Slot a, Slot b) {
        return ai.agents.at(a).entity < ai.agents.at(b).entity;
    });
    for (const Slot slot : turn.waking) {
        Agent& agent = ai.agents.at(slot);
        // Some agents were added since the last tick.
        const world::Row row = row_of(ai.entities, agent.entity);
        if (!agent.entity || agent.tier != Tier::kSuspended || row == world::kNoRow) {
            continue;
        }
        resume(agent, brain_of(agent, ai.settings), ai, row);
        ai.agents.resume(slot);
        meetings.forget(slot);
        resumed_.push_back(agent.entity);
        turn.report.moved = true;
    }
    turn.waking.clear();
}

/// Ends or begins the path segments of suspended agents that have an event now.
void OffscreenUpdate::advance_suspended(const AiContext& ai, AiTurn& turn) {
    turn.in_lanes(ai.team, turn.due.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            DueAgent& due = turn.due[i];
            if (due.tier != Tier::kSuspended) {
                continue;
            }
            Agent& agent = ai.agents.at(due.slot);
            const CompiledBrain& brain = brain_of(agent, ai.settings);
            if (due.roams) {
                const Vec3 from = ai.entities.position[due.row];
                take_step(agent, brain, ai, from, due.end);
                agent.placed = Vec2(from.x(), from.z());
                lane.drift_m = std::max(lane.drift_m, step_of(agent));
            } else if (!roams(agent, brain) && walk_on(agent, brain, ai, due.row, due.slot)) {
                lane.asking.push_back(due.slot);
            }
            std::uint8_t& stance = ai.entities.stance[due.row];
            due.moved = due.moved || stance != brain.states[agent.current_action].stance;
            stance = brain.states[agent.current_action].stance;
        }
    });
}

/// Schedules the next event of suspended agents that have had one now.
void OffscreenUpdate::go_on(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    turn.in_lanes(ai.team, turn.due.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            DueAgent& due = turn.due[i];
            if (due.tier == Tier::kSuspended) {
                Agent& agent = ai.agents.at(due.slot);
                due.next_event = event_after(agent, due, ai);
                due.left = std::max(left_at(agent, ai), ai.now + 1);
            }
        }
    });
    for (const DueAgent& due : turn.due) {
        if (due.tier == Tier::kSuspended) {
            Agent& agent = ai.agents.at(due.slot);
            agent.next_event = due.next_event;
            schedule_event(ai, due.slot);
            meetings.settle(ai, turn, due.slot, due.left);
            if (due.moved) {
                ai.entities.touch(due.row);
                turn.report.moved = true;
            }
            if (!due.end.stands || !can_suspend(agent, brain_of(agent, ai.settings))) {
                turn.waking.push_back(due.slot);
            }
            ++turn.report.events;
        }
        turn.report.decisions += due.decides ? 1U : 0U;
    }
}

/// Suspends active agents that have decided, once they have been off screen for a while.
void OffscreenUpdate::suspend_unseen(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    const Tick calm = static_cast<Tick>(std::ceil(ai.settings.suspend_after_s / ai.dt));
    for (const DueAgent& due : turn.due) {
        Agent& agent = ai.agents.at(due.slot);
        if (due.tier == Tier::kSuspended || agent.offscreen_since == kNever ||
            ai.now - agent.offscreen_since < calm ||
            !can_suspend(agent, brain_of(agent, ai.settings)) ||
            !ai.entities.has(due.row, world::kGrounded) || beside_platform(ai, due.row)) {
            continue;
        }
        const CompiledBrain& brain = brain_of(agent, ai.settings);
        // An active agent with a blend follows no segment, however settled its blend is.
        const bool blends = brain.choices[agent.state_machine.leaf].blend >= 0;
        if (blends ? ai.now < agent.detour_until
                   : !agent.timed && goes_by_segments(agent, brain.states[agent.current_action])) {
            continue;  // on a detour
        }
        if (!meetings.meets_nobody(ai, turn, due, calm)) {
            agent.offscreen_since = ai.now;  // a meeting counts like a viewer
            continue;
        }
        if (roams(agent, brain) && !HerdUpdate::set_roaming(agent, due, ai, turn)) {
            continue;  // its step would leave the ground
        }
        suspend(agent, brain, ai, due.row);
        if (agent.next_proximity_check != kNever) {
            meetings.add(ai, due.slot, due.row);
        }
        agent.next_event = next_event(agent, brain, ai);
        ai.agents.suspend(due.slot);
        schedule_event(ai, due.slot);
        meetings.settle(ai, turn, due.slot, std::max(left_at(agent, ai), ai.now + 1));
        suspended_.push_back(agent.entity);
    }
    std::sort(suspended_.begin(), suspended_.end());
}

}  // namespace zoned::ai
