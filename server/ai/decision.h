// Decision: one pass through the transitions of a mind's state.
#pragma once

#include "server/ai/ai_step.h"
#include "server/ai/perception.h"

#include <array>

namespace zoned::ai {

/// What a mind senses at a decision.
using Senses = std::array<float, fsm::kMaxSenses>;

/// Variables as they are at `now`: they have grown at the rates of the mind's state.
void grow(Mind& mind, const CompiledMachine& machine, Tick now);

/// Fills in what `machine` reads: its own senses, the variables as of variables_at, then the
/// outputs of its fuzzy systems. `random` in [0, 1); `position` zone-local, m.
void sense(const Mind& mind,
           const CompiledMachine& machine,
           const Sight& sight,
           const Vec3& position,
           float random,
           Senses& senses);

/// Lets variables grow, senses, and takes the transition that fires, if any (fsm::step_one); what
/// the states that it enters give is added. Then finds what to do: as the state says, its tree or
/// its plan, which is made anew when a fact has changed since; where no plan is found, the state's
/// own action. Draws one random number. Returns whether a transition fired.
bool decide(Mind& mind,
            const CompiledMachine& machine,
            const Sight& sight,
            const Vec3& position,
            Tick now,
            Thinking& thinking);

/// Ticks between decisions, >= 1.
Tick decision_period(const CompiledMachine& machine, float dt);

/// The next tick after `now` at which the mind decides: entities are spread over the period by id,
/// so that a herd that was born in one tick does not decide in one tick for ever.
Tick next_decision(EntityId entity, Tick period, Tick now);

}  // namespace zoned::ai
