#include "server/ai/update/path_update.h"

#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/path_following.h"

#include <algorithm>
#include <iterator>

namespace zoned::ai {

namespace {

/// Sets the agent out on the path that it has got.
void set_out(Agent& agent, Slot slot, const AiContext& ai, AiTurn& turn) {
    const CompiledBrain& brain = brain_of(agent, ai.settings);
    const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
    turn.row_hints[slot] = row;
    follow_path(agent, brain.states[agent.current_action], surroundings_of(ai, agent, row, slot));
    agent.next_steering = ai.now + 1;
    if (agent.tier == Tier::kSuspended) {
        agent.next_event = next_event(agent, brain, ai);
    }
}

}  // namespace

/// Goes in the order of entities, so that the tick of each answer does not depend on lanes.
void PathUpdate::request_paths(const AiContext& ai, AiTurn& turn) {
    asking_.clear();
    for (AiLane& lane : turn.lanes) {
        asking_.insert(asking_.end(), lane.asking.begin(), lane.asking.end());
        lane.asking.clear();
    }
    std::sort(asking_.begin(), asking_.end(), [&ai](Slot a, Slot b) {
        return ai.agents.at(a).entity < ai.agents.at(b).entity;
    });
    const world::Entities& e = ai.entities;
    const auto at = [&](Slot slot) {
        const Agent& agent = ai.agents.at(slot);
        const Vec3& body = e.position[turn.row_hints[slot]];
        const Vec2 here = whereabouts(agent, Vec2(body.x(), body.z()), ai.now, ai.dt);
        return pathfinding::Spot{here.x(), here.y()};
    };
    const auto feet = [&](Slot slot) {
        const world::Row row = turn.row_hints[slot];
        const motion::CharacterLimits& body = ai.types[e.type[row]].character;
        return e.position[row].y() - body.radius - body.half_segment;
    };
    waiting_.insert(waiting_.end(), ai.paths->requeued().begin(), ai.paths->requeued().end());
    for (const Slot slot : waiting_) {
        const EntityId entity = ai.agents.at(slot).entity;
        turn.row_hints[slot] = row_of(e, entity, turn.row_hints[slot]);
        if (ai.paths->has(slot, entity) && turn.row_hints[slot] != world::kNoRow) {
            ai.paths->see(slot, at(slot), feet(slot));
        }
    }
    for (const Slot slot : asking_) {
        Agent& agent = ai.agents.at(slot);
        agent.on_path = true;
        const pathfinding::Spot goal{agent.segment.goal.x(), agent.segment.goal.y()};
        const world::Row row = turn.row_hints[slot];
        const BrainState& state = brain_of(agent, ai.settings).states[agent.current_action];
        const float floor = goal_floor(agent, state, surroundings_of(ai, agent, row, slot));
        ai.paths->ask(slot, agent.entity, e.type[row], at(slot), goal, {feet(slot), floor});
    }
}

void PathUpdate::wait_for(const PathService& paths, const AgentStore& agents) {
    waiting_.clear();
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Slot slot = agents.nth(n);
        if (paths.has(slot, agents.at(slot).entity) && paths.answer(slot).waiting) {
            waiting_.push_back(slot);
        }
    }
    std::sort(waiting_.begin(), waiting_.end());
}

/// Counts the bodies of simulated agents. A suspended agent walks through all other entities.
void PathUpdate::count_bodies(const AiContext& ai) {
    if (!ai.paths->counts_bodies()) {
        return;
    }
    body_x_.clear();
    body_z_.clear();
    const world::Entities& e = ai.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        if (ai.types[e.type[row]].kind == world::EntityKind::kCharacter &&
            !e.has(row, world::kHidden) && !e.has(row, world::kDozing)) {
            body_x_.push_back(e.position[row].x());
            body_z_.push_back(e.position[row].z());
        }
    }
    ai.paths->count_bodies(body_x_, body_z_);
}

/// Finds paths for the agents that need one, most often in the tick of the request. Other agents
/// are notified when their path is there, or when it has changed because a door has moved.
void PathUpdate::find_paths(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    if (ai.paths == nullptr) {
        return;
    }
    request_paths(ai, turn);
    count_bodies(ai);
    ai.paths->serve();
    answered_.clear();
    std::copy_if(asking_.begin(), asking_.end(), std::back_inserter(answered_), [&ai](Slot slot) {
        return ai.agents.at(slot).timed;
    });
    waiting_.insert(waiting_.end(), asking_.begin(), asking_.end());
    for (const Slot slot : ai.paths->answered()) {
        Agent& agent = ai.agents.at(slot);
        const bool walks = agent.timed && agent.on_path && ai.paths->has(slot, agent.entity);
        if (!agent.on_path) {
            ai.paths->release(slot);
        }
        const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
        if (walks && row != world::kNoRow) {
            restart_progress(agent, ai.entities.position[row], ai.now);
            answered_.push_back(slot);
        }
    }
    for (std::vector<Slot>* slots : {&answered_, &waiting_}) {
        std::sort(slots->begin(), slots->end());
        slots->erase(std::unique(slots->begin(), slots->end()), slots->end());
    }
    std::erase_if(waiting_, [&](Slot slot) {
        return !ai.paths->has(slot, ai.agents.at(slot).entity) || !ai.paths->answer(slot).waiting;
    });
    for (const Slot slot : answered_) {
        Agent& agent = ai.agents.at(slot);
        const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
        // An agent notified between two events is placed now: it may be in another square.
        if (agent.tier == Tier::kSuspended && row != world::kNoRow &&
            agent.placed != position_at(agent.segment, ai.now - 1, ai.dt)) {
            place(agent, ai, turn, row);
        }
        set_out(agent, slot, ai, turn);
        if (agent.tier == Tier::kSuspended) {
            schedule_event(ai, slot);
            meetings.settle(ai, turn, slot, std::max(left_at(agent, ai), ai.now + 1));
        }
    }
}

}  // namespace zoned::ai
