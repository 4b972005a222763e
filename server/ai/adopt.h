// Adopt: agents go on with machines that have become others.
#pragma once

#include "server/ai/ai_step.h"

namespace zoned::ai {

/// Of all agents that lived by `before` and whose machines are now those of `after`, both compiled
/// for `dt` s; `machine_of` names the new machine of an agent, by index into after.machines.
///
/// What has a name keeps it: the state, the deed within it and how long it has been in it, the
/// places that histories remember, and variables, within their new bounds. An agent whose state is
/// no more begins anew, as do variables that are new. A hold that was under way begins again, and a
/// plan is made anew at the next decision, which comes when the new machine's period has it. Who
/// walks at another pace now does so at once. AgentStore are awake.
template <class MachineOf>
void adopt(AgentStore& agents,
           const Settings& before,
           const Settings& after,
           MachineOf&& machine_of,
           Tick now,
           float dt);

/// One agent of `before` becomes one of machine `index`, `after`.
void adopt(Agent& agent,
           const CompiledMachine& before,
           const CompiledMachine& after,
           std::uint16_t index,
           Tick now,
           float dt);

template <class MachineOf>
void adopt(AgentStore& agents,
           const Settings& before,
           const Settings& after,
           MachineOf&& machine_of,
           Tick now,
           float dt) {
    agents.forget_wavering();
    for (std::size_t n = 0; n < agents.size(); ++n) {
        Agent& agent = agents.at(agents.nth(n));
        const std::uint16_t index = machine_of(agent);
        adopt(agent, before.compiled[agent.machine], after.compiled[index], index, now, dt);
    }
}

}  // namespace zoned::ai
