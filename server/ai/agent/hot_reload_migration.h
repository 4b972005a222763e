// HotReloadMigration: moves agents to changed brains.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/ai_settings.h"

namespace zoned::ai {

/// Moves all agents from the brains of `before` to those of `after`, both compiled for `dt` s.
/// `brain_of` names the new brain of an agent, by index into after.brains.
///
/// State is matched by name. An agent keeps its state, the action within it and the time spent in
/// it. It keeps the states that histories remember, and its variables within their new bounds.
///
/// An agent whose state is gone begins anew, and so do new variables. A hold in progress begins
/// again. A plan is made anew at the next decision, which follows the new brain's period. A new
/// walking speed applies at once. All agents are active.
template <class BrainOf>
void migrate(AgentStore& agents,
             const AiSettings& before,
             const AiSettings& after,
             BrainOf&& brain_of,
             Tick now,
             float dt);

/// Turns an agent of `before` into an agent of brain `index` of `after`.
void migrate(Agent& agent,
             const CompiledBrain& before,
             const CompiledBrain& after,
             std::uint16_t index,
             Tick now,
             float dt);

template <class BrainOf>
void migrate(AgentStore& agents,
             const AiSettings& before,
             const AiSettings& after,
             BrainOf&& brain_of,
             Tick now,
             float dt) {
    agents.forget_flapping();
    for (std::size_t n = 0; n < agents.size(); ++n) {
        Agent& agent = agents.at(agents.nth(n));
        const std::uint16_t index = brain_of(agent);
        migrate(agent, before.compiled[agent.brain], after.compiled[index], index, now, dt);
    }
}

}  // namespace zoned::ai
