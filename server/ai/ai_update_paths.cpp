#include "server/ai/ai_update.h"
#include "server/ai/ai_update_lookup.h"

#include <algorithm>
#include <iterator>

namespace zoned::ai {

/// In the order of entities, so that what is answered when does not depend on lanes.
void AiUpdate::request_paths(AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings) {
    asking_.clear();
    for (AiLane& lane : lanes_) {
        asking_.insert(asking_.end(), lane.asking.begin(), lane.asking.end());
        lane.asking.clear();
    }
    std::sort(asking_.begin(), asking_.end(), [&agents](Slot a, Slot b) {
        return agents.at(a).entity < agents.at(b).entity;
    });
    const world::Entities& e = world.entities;
    const auto at = [&](Slot slot) {
        const Agent& agent = agents.at(slot);
        const Vec3& body = e.position[row_hints_[slot]];
        const Vec2 here = whereabouts(agent, Vec2(body.x(), body.z()), world.now, world.dt);
        return pathfinding::Spot{here.x(), here.y()};
    };
    const auto feet = [&](Slot slot) {
        const world::Row row = row_hints_[slot];
        const motion::CharacterLimits& body = world.types[e.type[row]].character;
        return e.position[row].y() - body.radius - body.half_segment;
    };
    waiting_.insert(waiting_.end(), world.paths->requeued().begin(), world.paths->requeued().end());
    for (const Slot slot : waiting_) {
        const EntityId entity = agents.at(slot).entity;
        row_hints_[slot] = row_of(e, entity, row_hints_[slot]);
        if (world.paths->has(slot, entity) && row_hints_[slot] != world::kNoRow) {
            world.paths->see(slot, at(slot), feet(slot));
        }
    }
    for (const Slot slot : asking_) {
        Agent& agent = agents.at(slot);
        agent.on_path = true;
        const pathfinding::Spot goal{agent.segment.goal.x(), agent.segment.goal.y()};
        const world::Row row = row_hints_[slot];
        const BrainState& state = brain_of(agent, settings).states[agent.current_action];
        const float floor = goal_floor(agent, state, offscreen(world).around(agent, row, slot));
        world.paths->ask(slot, agent.entity, e.type[row], at(slot), goal, {feet(slot), floor});
    }
}

void AiUpdate::wait_for(const PathService& paths, const AgentStore& agents) {
    waiting_.clear();
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Slot slot = agents.nth(n);
        if (paths.has(slot, agents.at(slot).entity) && paths.answer(slot).waiting) {
            waiting_.push_back(slot);
        }
    }
    std::sort(waiting_.begin(), waiting_.end());
}

/// Those who are simulated: who is seen by nobody walks through everybody.
void AiUpdate::count_bodies(const AiContext& world) {
    if (!world.paths->counts_bodies()) {
        return;
    }
    body_x_.clear();
    body_z_.clear();
    const world::Entities& e = world.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        if (world.types[e.type[row]].kind == world::EntityKind::kCharacter &&
            !e.has(row, world::kHidden) && !e.has(row, world::kDozing)) {
            body_x_.push_back(e.position[row].x());
            body_z_.push_back(e.position[row].z());
        }
    }
    world.paths->count_bodies(body_x_, body_z_);
}

/// Paths for those who need one, most often in the tick in which they ask; others are told when
/// theirs is there, or another than before because a door has turned.
void AiUpdate::find_paths(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    if (world.paths == nullptr) {
        return;
    }
    request_paths(agents, world, settings);
    count_bodies(world);
    world.paths->serve();
    told_.clear();
    std::copy_if(asking_.begin(), asking_.end(), std::back_inserter(told_), [&agents](Slot slot) {
        return agents.at(slot).timed;
    });
    waiting_.insert(waiting_.end(), asking_.begin(), asking_.end());
    for (const Slot slot : world.paths->answered()) {
        Agent& agent = agents.at(slot);
        const bool walks = agent.timed && agent.on_path && world.paths->has(slot, agent.entity);
        if (!agent.on_path) {
            world.paths->release(slot);
        }
        const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
        if (walks && row != world::kNoRow) {
            restart_progress(agent, world.entities.position[row], world.now);
            told_.push_back(slot);
        }
    }
    for (std::vector<Slot>* slots : {&told_, &waiting_}) {
        std::sort(slots->begin(), slots->end());
        slots->erase(std::unique(slots->begin(), slots->end()), slots->end());
    }
    std::erase_if(waiting_, [&](Slot slot) {
        return !world.paths->has(slot, agents.at(slot).entity) ||
               !world.paths->answer(slot).waiting;
    });
    for (const Slot slot : told_) {
        Agent& agent = agents.at(slot);
        const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
        // Who was told between two events is put where it is: it may be in another square.
        if (agent.tier == Tier::kSuspended && row != world::kNoRow &&
            agent.placed != position_at(agent.segment, world.now - 1, world.dt)) {
            place(agent, world, row);
        }
        go_on_from(agent, slot, world, settings);
        if (agent.tier == Tier::kSuspended) {
            plan(agents, slot, world, settings);
            settle(agents, slot, std::max(left_at(agent, world), world.now + 1), world);
        }
    }
}

/// Sets out on the way that the agent was told.
void AiUpdate::go_on_from(Agent& agent,
                          Slot slot,
                          const AiContext& world,
                          const AiSettings& settings) {
    const CompiledBrain& brain = brain_of(agent, settings);
    const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
    row_hints_[slot] = row;
    follow_path(
        agent, brain.states[agent.current_action], offscreen(world).around(agent, row, slot));
    agent.next_steering = world.now + 1;
    if (agent.tier == Tier::kSuspended) {
        agent.next_event = next_event(agent, brain, offscreen(world));
    }
}

}  // namespace zoned::ai
