// Adopt: minds go on with machines that have become others.
#pragma once

#include "server/ai/ai_step.h"

namespace zoned::ai {

/// Of all minds that lived by `before` and whose machines are now those of `after`, both compiled
/// for `dt` s; `machine_of` names the new machine of a mind, by index into after.machines.
///
/// What has a name keeps it: the state, the deed within it and how long it has been in it, the
/// places that histories remember, and variables, within their new bounds. A mind whose state is no
/// more begins anew, as do variables that are new. A hold that was under way begins again, and a
/// plan is made anew at the next decision, which comes when the new machine's period has it. Who
/// walks at another pace now does so at once. Minds are awake.
template <class MachineOf>
void adopt(Minds& minds,
           const Settings& before,
           const Settings& after,
           MachineOf&& machine_of,
           Tick now,
           float dt);

/// One mind of `before` becomes one of machine `index`, `after`.
void adopt(Mind& mind,
           const CompiledMachine& before,
           const CompiledMachine& after,
           std::uint16_t index,
           Tick now,
           float dt);

template <class MachineOf>
void adopt(Minds& minds,
           const Settings& before,
           const Settings& after,
           MachineOf&& machine_of,
           Tick now,
           float dt) {
    minds.forget_wavering();
    for (std::size_t n = 0; n < minds.size(); ++n) {
        Mind& mind = minds.at(minds.nth(n));
        const std::uint16_t index = machine_of(mind);
        adopt(mind, before.compiled[mind.machine], after.compiled[index], index, now, dt);
    }
}

}  // namespace zoned::ai
