#include "server/ai/ai_step.h"

namespace zoned::ai {

/// Where those who look for food go next.
void Step::forage(Minds& minds, const World& world, const Settings& settings) {
    nests_.clear();
    const std::span<const Slot> awake = minds.awake();
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const Mind& mind = minds.at(awake[i]);
        const CompiledMachine& machine = settings.compiled[mind.machine];
        // Who has just turned to it begins when it steers.
        if (rows_[i] != world::kNoRow && machine.forages && !mind.entered &&
            machine.states[mind.doing].action == ActionKind::kForage) {
            nests_.add({rows_[i], awake[i]});
        }
    }
    nests_.step(minds,
                {world.entities,
                 world.types,
                 world.places,
                 world.statics,
                 settings.compiled,
                 world.half_size,
                 world.now,
                 world.dt});
    report_.delivered = nests_.delivered();
}

/// Where those who form up around somebody are to be now.
void Step::form_up(Minds& minds, const World& world, const Settings& settings) {
    formations_.clear();
    const std::span<const Slot> awake = minds.awake();
    for (std::size_t i = 0; i < awake.size(); ++i) {
        const Mind& mind = minds.at(awake[i]);
        const CompiledMachine& machine = settings.compiled[mind.machine];
        if (rows_[i] == world::kNoRow || !machine.forms_up || !mind.ward ||
            machine.states[mind.doing].action != ActionKind::kFormUp) {
            continue;
        }
        const world::Row captain = world.entities.find(mind.ward);
        if (captain != world::kNoRow) {
            formations_.add({mind.ward, mind.entity, captain, rows_[i], awake[i]});
        }
    }
    if (!formations_.empty()) {
        formations_.place(minds,
                          world.entities,
                          world.types,
                          settings.compiled,
                          walls_.of(world.statics),
                          world.now);
    }
}

/// Whoever would meet somebody avoids it; what it wants stays its aim.
void Step::make_way(Minds& minds, const World& world, const Settings& settings) {
    if (!settings.avoidance) {
        return;
    }
    walkers_.clear();
    const std::span<const Slot> awake = minds.awake();
    for (std::size_t i = 0; i < awake.size(); ++i) {
        if (rows_[i] != world::kNoRow) {
            const Mind& mind = minds.at(awake[i]);
            const State& state = settings.compiled[mind.machine].states[mind.doing];
            const Vec3& at = world.entities.position[rows_[i]];
            walkers_.push_back(
                {rows_[i], way_left(mind, state, world.places, Vec2(at.x(), at.z()))});
        }
    }
    report_.ways = make_way_.step(
        walkers_,
        {world.entities, world.types, world.statics, walls_, world.team, world.now, world.dt},
        *settings.avoidance);
}

}  // namespace zoned::ai
