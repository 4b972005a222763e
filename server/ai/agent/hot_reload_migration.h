// HotReloadMigration: agents go on with brains that have become others.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/ai_settings.h"

namespace zoned::ai {

/// Of all agents that lived by `before` and whose brains are now those of `after`, both compiled
/// for `dt` s; `brain_of` names the new brain of an agent, by index into after.brains.
///
/// What has a name keeps it: the state, the action within it and how long it has been in it, the
/// places that histories remember, and variables, within their new bounds. An agent whose state is
/// no more begins anew, as do variables that are new. A hold that was under way begins again, and a
/// plan is made anew at the next decision, which comes when the new brain's period has it. Who
/// walks at another pace now does so at once. Agents are active.
template <class BrainOf>
void migrate(AgentStore& agents,
             const AiSettings& before,
             const AiSettings& after,
             BrainOf&& brain_of,
             Tick now,
             float dt);

/// One agent of `before` becomes one of brain `index`, `after`.
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
