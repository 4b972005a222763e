#include "server/ai/ai_step.h"

#include "server/ai/decision.h"
#include "server/ai/lod.h"
#include "server/ai/perception.h"
#include "server/ai/steering.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Finds the row of every mind, and the minds that want to decide, the longest waiting first.
void collect(Minds& minds, const world::Entities& entities, Tick now) {
    Minds::Scratch& scratch = minds.scratch();
    const std::span<const Mind> all = minds.all();
    scratch.rows.resize(all.size());
    scratch.due.clear();
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        world::Row row = entities.find(all[i].entity);
        if (row != world::kNoRow &&
            (entities.has(row, world::kHidden) || entities.has(row, world::kGhost))) {
            row = world::kNoRow;
        }
        scratch.rows[i] = row;
        if (row != world::kNoRow && all[i].next_decision <= now) {
            scratch.due.push_back(i);
        }
    }
    // Minds are ascending by entity id, so the index breaks ties the same way everywhere.
    std::sort(scratch.due.begin(), scratch.due.end(), [&](std::uint32_t a, std::uint32_t b) {
        return all[a].next_decision != all[b].next_decision
                   ? all[a].next_decision < all[b].next_decision
                   : a < b;
    });
}

const CompiledMachine& machine_of(const Mind& mind, const Settings& settings) {
    ZONED_ASSERT(mind.machine < settings.compiled.size(), "the machine of a mind exists");
    return settings.compiled[mind.machine];
}

}  // namespace

void compile(Settings& settings, float dt) {
    settings.compiled.clear();
    for (const Machine& machine : settings.machines) {
        settings.compiled.push_back(machine.inner ? CompiledMachine{} : compile(machine, dt));
    }
}

Report step(Minds& minds,
            world::Entities& entities,
            const world::TypeTable& types,
            const spatial::PointGrid& grid,
            const Settings& settings,
            Tick now,
            float dt) {
    Report report;
    collect(minds, entities, now);
    const Minds::Scratch& scratch = minds.scratch();
    Thinking& thinking = minds.scratch().thinking;
    thinking.max_plan_nodes = settings.max_plan_nodes;
    thinking.plans = thinking.plans_cut_off = thinking.plans_unreachable = 0;
    const std::span<Mind> all = minds.all();
    const std::size_t budget = std::max<std::size_t>(1, settings.max_decisions_per_tick);
    const std::size_t decisions = std::min(budget, scratch.due.size());
    for (std::size_t i = 0; i < decisions; ++i) {
        Mind& mind = all[scratch.due[i]];
        const world::Row row = scratch.rows[scratch.due[i]];
        const CompiledMachine& machine = machine_of(mind, settings);
        const Sight sight = look(entities, grid, row, machine.perception_m, settings.far_m);
        if (decide(mind, machine, sight, entities.position[row], now, thinking)) {
            ++report.transitions;
        }
        mind.next_decision = next_decision(mind.entity, decision_period(machine, dt), now);
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        const world::Row row = scratch.rows[i];
        if (row == world::kNoRow) {
            continue;
        }
        Mind& mind = all[i];
        const CompiledMachine& machine = machine_of(mind, settings);
        if (steers_now(mind, settings, now)) {
            steer(mind, machine, {entities, types, grid, row, now, dt});
            ++report.steered;
        }
        entities.command[row] = mind.aim;
        entities.command[row].tick = now;
        entities.behaviour[row] = machine.states[mind.doing].behaviour;
    }
    report.plans = thinking.plans;
    report.plans_cut_off = thinking.plans_cut_off;
    report.plans_unreachable = thinking.plans_unreachable;
    report.minds = static_cast<std::uint32_t>(all.size());
    report.decisions = static_cast<std::uint32_t>(decisions);
    report.postponed = static_cast<std::uint32_t>(scratch.due.size() - decisions);
    return report;
}

}  // namespace zoned::ai
