#include "server/ai/ai_step.h"
#include "server/ai/step_lookup.h"

#include <algorithm>
#include <iterator>

namespace zoned::ai {

/// In the order of entities, so that what is answered when does not depend on lanes.
void Step::request_paths(Minds& minds, const World& world, const Settings& settings) {
    asking_.clear();
    for (Lane& lane : lanes_) {
        asking_.insert(asking_.end(), lane.asking.begin(), lane.asking.end());
        lane.asking.clear();
    }
    std::sort(asking_.begin(), asking_.end(), [&minds](Slot a, Slot b) {
        return minds.at(a).entity < minds.at(b).entity;
    });
    const world::Entities& e = world.entities;
    const auto at = [&](Slot slot) {
        const Mind& mind = minds.at(slot);
        const Vec3& body = e.position[row_hints_[slot]];
        const Vec2 here = whereabouts(mind, Vec2(body.x(), body.z()), world.now, world.dt);
        return pathfinding::Spot{here.x(), here.y()};
    };
    const auto feet = [&](Slot slot) {
        const world::Row row = row_hints_[slot];
        const motion::CharacterLimits& body = world.types[e.type[row]].character;
        return e.position[row].y() - body.radius - body.half_segment;
    };
    waiting_.insert(waiting_.end(), world.paths->requeued().begin(), world.paths->requeued().end());
    for (const Slot slot : waiting_) {
        const EntityId entity = minds.at(slot).entity;
        row_hints_[slot] = row_of(e, entity, row_hints_[slot]);
        if (world.paths->has(slot, entity) && row_hints_[slot] != world::kNoRow) {
            world.paths->see(slot, at(slot), feet(slot));
        }
    }
    for (const Slot slot : asking_) {
        Mind& mind = minds.at(slot);
        mind.on_path = true;
        const pathfinding::Spot goal{mind.segment.goal.x(), mind.segment.goal.y()};
        const world::Row row = row_hints_[slot];
        const State& state = machine_of(mind, settings).states[mind.doing];
        const float floor = goal_floor(mind, state, coarse(world).around(mind, row, slot));
        world.paths->ask(slot, mind.entity, e.type[row], at(slot), goal, {feet(slot), floor});
    }
}

void Step::wait_for(const PathService& paths, const Minds& minds) {
    waiting_.clear();
    for (std::size_t n = 0; n < minds.size(); ++n) {
        const Slot slot = minds.nth(n);
        if (paths.has(slot, minds.at(slot).entity) && paths.answer(slot).waiting) {
            waiting_.push_back(slot);
        }
    }
    std::sort(waiting_.begin(), waiting_.end());
}

/// Those who are simulated: who is seen by nobody walks through everybody.
void Step::count_bodies(const World& world) {
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
void Step::find_paths(Minds& minds, const World& world, const Settings& settings) {
    if (world.paths == nullptr) {
        return;
    }
    request_paths(minds, world, settings);
    count_bodies(world);
    world.paths->serve();
    told_.clear();
    std::copy_if(asking_.begin(), asking_.end(), std::back_inserter(told_), [&minds](Slot slot) {
        return minds.at(slot).timed;
    });
    waiting_.insert(waiting_.end(), asking_.begin(), asking_.end());
    for (const Slot slot : world.paths->answered()) {
        Mind& mind = minds.at(slot);
        const bool walks = mind.timed && mind.on_path && world.paths->has(slot, mind.entity);
        if (!mind.on_path) {
            world.paths->release(slot);
        }
        const world::Row row = row_of(world.entities, mind.entity, row_hints_[slot]);
        if (walks && row != world::kNoRow) {
            restart_progress(mind, world.entities.position[row], world.now);
            told_.push_back(slot);
        }
    }
    for (std::vector<Slot>* slots : {&told_, &waiting_}) {
        std::sort(slots->begin(), slots->end());
        slots->erase(std::unique(slots->begin(), slots->end()), slots->end());
    }
    std::erase_if(waiting_, [&](Slot slot) {
        return !world.paths->has(slot, minds.at(slot).entity) || !world.paths->answer(slot).waiting;
    });
    for (const Slot slot : told_) {
        Mind& mind = minds.at(slot);
        const world::Row row = row_of(world.entities, mind.entity, row_hints_[slot]);
        // Who was told between two events is put where it is: it may be in another square.
        if (mind.tier == Tier::kCoarse && row != world::kNoRow &&
            mind.placed != position_at(mind.segment, world.now - 1, world.dt)) {
            place(mind, world, row);
        }
        go_on_from(mind, slot, world, settings);
        if (mind.tier == Tier::kCoarse) {
            plan(minds, slot, world, settings);
            settle(minds, slot, std::max(left_at(mind, world), world.now + 1), world);
        }
    }
}

/// Sets out on the way that the mind was told.
void Step::go_on_from(Mind& mind, Slot slot, const World& world, const Settings& settings) {
    const CompiledMachine& machine = machine_of(mind, settings);
    const world::Row row = row_of(world.entities, mind.entity, row_hints_[slot]);
    row_hints_[slot] = row;
    follow_path(mind, machine.states[mind.doing], coarse(world).around(mind, row, slot));
    mind.next_steering = world.now + 1;
    if (mind.tier == Tier::kCoarse) {
        mind.next_event = next_event(mind, machine, coarse(world));
    }
}

}  // namespace zoned::ai
