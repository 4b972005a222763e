#include "server/ai/update/decision_update.h"

#include "server/ai/agent/whereabouts.h"
#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/perception/perception.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Keeps to the budgets of decisions and of rays. An agent with line of sight reserves as many rays
/// as it may need.
void keep_to_budgets(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    const std::size_t budget = std::max<std::size_t>(1, ai.settings.max_decisions_per_tick);
    std::uint32_t rays = std::max(ai.settings.max_sight_rays_per_tick, kRaysPerLook);
    std::size_t kept = 0;
    for (const DueAgent& due : turn.due) {
        const bool looks = due.tier == Tier::kActive &&
                           brain_of(ai.agents.at(due.slot), ai.settings).perception.line_of_sight;
        const bool blind = looks && rays < kRaysPerLook;
        if (kept < budget && !blind) {
            rays -= looks ? kRaysPerLook : 0U;
            if (&turn.due[kept] != &due) {
                turn.due[kept] = due;
            }
            ++kept;
            continue;
        }
        if (due.tier == Tier::kSuspended) {
            ai.agents.at(due.slot).next_event = due.since;
            ai.agents.schedule(due.slot, 1);  // not waiting for stock
            const Tick left = left_at(ai.agents.at(due.slot), ai, true);
            meetings.settle(ai, turn, due.slot, std::max(left, ai.now + 1), true);
        }
        turn.report.blinded += kept < budget ? 1U : 0U;
        ++turn.report.postponed;
    }
    turn.due.resize(kept);
}

void decide_one(DueAgent& due,
                const AiContext& ai,
                const AiTurn& turn,
                const PerceptionRanges& ranges,
                const ViewerUpdate& viewers,
                AiLane& lane) {
    Agent& agent = ai.agents.at(due.slot);
    const CompiledBrain& brain = brain_of(agent, ai.settings);
    const world::Entities& e = ai.entities;
    const bool active = due.tier == Tier::kActive;
    const Timetables timetables{ai.agents, turn.slot_hints};
    const Percept percept = active ? perceive(ai,
                                              due.row,
                                              agent,
                                              brain,
                                              &viewers.players(),
                                              ranges.any() ? &timetables : nullptr)
                                   : Percept::none();
    const Vec2 body(e.position[due.row].x(), e.position[due.row].z());
    const Vec2 here = whereabouts(agent, body, ai.now, ai.dt);
    if (decide(agent, brain, percept, here, ai.points_of_interest, ai.now, lane.scratch)) {
        ++lane.transitions;
        due.change = lane.scratch.change;
    }
    due.changed = agent.entered;
    if (active) {
        agent.next_decision = next_decision(agent.entity, decision_period(brain, ai.dt), ai.now);
        if (viewers.covers(body)) {
            agent.offscreen_since = kNever;
        } else if (agent.offscreen_since == kNever) {
            agent.offscreen_since = ai.now;
        }
    }
}

}  // namespace

/// Finds the rows of active agents, and the agents that have something to do, the longest waiting
/// first. Agents beyond the budget wait.
void collect_due(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings, TradeUpdate& trades) {
    const std::span<const Slot> active = ai.agents.active();
    turn.rows.resize(active.size());
    turn.due.clear();
    turn.herd_steps.clear();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = ai.agents.at(active[i]);
        turn.rows[i] = row_of(ai.entities, agent.entity, turn.row_hints[active[i]]);
        turn.row_hints[active[i]] = turn.rows[i];
        if (turn.rows[i] != world::kNoRow && meetings.ranges().any()) {
            turn.slot_hints[turn.rows[i]] = active[i];
        }
        if (turn.rows[i] != world::kNoRow && agent.next_decision <= ai.now) {
            turn.due.push_back(
                {agent.next_decision, agent.entity, active[i], turn.rows[i], Tier::kActive});
        }
    }
    turn.events.clear();
    ai.agents.take_due(ai.now, turn.events);
    trades.call_up_waiting(ai, turn);
    for (const AgentStore::Event& event : turn.events) {
        __builtin_prefetch(&turn.row_hints[event.slot], 1);
    }
    std::sort(turn.events.begin(),
              turn.events.end(),
              [](const AgentStore::Event& a, const AgentStore::Event& b) {
                  return a.at != b.at ? a.at < b.at : a.entity < b.entity;
              });
    // Prefetch: the agents lie scattered in memory.
    for (const AgentStore::Event& event : turn.events) {
        ai.entities.prefetch(turn.row_hints[event.slot]);
        ai.agents.prefetch_neighbours(event.slot);
    }
    for (const AgentStore::Event& event : turn.events) {
        const world::Row row = row_of(ai.entities, event.entity, turn.row_hints[event.slot]);
        turn.row_hints[event.slot] = row;
        if (row == world::kNoRow) {
            continue;
        }
        const Agent& agent = ai.agents.at(event.slot);
        if (!event.waited && only_steps(agent, brain_of(agent, ai.settings), ai, row)) {
            turn.herd_steps.push_back({event.entity, event.slot, row});
        } else {
            turn.due.push_back({event.at, event.entity, event.slot, row, Tier::kSuspended});
            turn.due.back().waited = event.waited || agent.wait.any();
        }
    }
    const auto before = [](const DueAgent& a, const DueAgent& b) {
        return a.since != b.since ? a.since < b.since : a.entity < b.entity;
    };
    // The elements are large, and already sorted where few agents or none are active.
    if (!std::is_sorted(turn.due.begin(), turn.due.end(), before)) {
        std::sort(turn.due.begin(), turn.due.end(), before);
    }
    keep_to_budgets(ai, turn, meetings);
}

/// The grid is built only where some active agent looks for other entities than players, or is
/// looked for.
bool needs_others(const AiContext& ai, const AiTurn& turn, const PerceptionRanges& ranges) {
    const std::span<const Slot> active = ai.agents.active();
    bool needed = false;
    for (std::size_t i = 0; i < active.size() && !needed; ++i) {
        const Agent& agent = ai.agents.at(active[i]);
        const CompiledBrain& brain = brain_of(agent, ai.settings);
        needed = brain.knows_others || (brain.counts_rivals && agent.prey) ||
                 (ranges.any() && turn.rows[i] != world::kNoRow &&
                  ranges.farthest({ai.entities.type[turn.rows[i]], agent.brain}) >= 0.0F);
    }
    return needed;
}

/// Places the suspended agents that are due first; then all agents perceive and decide.
void decide_due(const AiContext& ai,
                AiTurn& turn,
                const PerceptionRanges& ranges,
                const ViewerUpdate& viewers) {
    turn.in_lanes(ai.team, turn.due.size(), [&](AiLane&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (turn.due[i].tier == Tier::kSuspended) {
                Agent& agent = ai.agents.at(turn.due[i].slot);
                turn.due[i].decides = agent.next_decision <= ai.now;
                catch_up(agent, ai, turn.due[i].row);
                turn.due[i].moved = ai.entities.discontinuity_tick[turn.due[i].row] == ai.now;
            }
        }
    });
    turn.in_lanes(ai.team, turn.due.size(), [&](AiLane& lane, std::size_t begin, std::size_t end) {
        lane.scratch.max_plan_nodes = ai.settings.max_plan_nodes;
        for (std::size_t i = begin; i < end; ++i) {
            if (turn.due[i].decides) {
                decide_one(turn.due[i], ai, turn, ranges, viewers, lane);
            }
        }
    });
}

/// Finds agents whose state flaps. Only reports use this.
void watch_changes(const AiContext& ai, const AiTurn& turn) {
    for (const DueAgent& due : turn.due) {
        if (due.change) {
            ai.agents.watch(due.slot, *due.change, ai.now, ai.dt);
        }
    }
}

}  // namespace zoned::ai
