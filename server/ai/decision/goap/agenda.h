// Agenda: carries a plan out, skips what has come true by itself, and plans anew when what the rest
// relies on breaks.
#pragma once

#include "server/ai/decision/goap/goap_planner.h"

#include <cstdint>

namespace zoned::ai::goap {

enum class AgendaState : std::uint8_t {
    kActing,       ///< `action` is to be done now
    kReached,      ///< the goal is true
    kUnreachable,  ///< and will be tried again when the world has changed
    kCutOff,       ///< likewise
};

/// What one agent is up to.
struct Agenda {
    AgendaState state = AgendaState::kReached;
    std::uint8_t step = 0;    ///< of the plan
    std::uint16_t goal = 0;   ///< index in the domain
    std::uint32_t plans = 0;  ///< made so far
    FactSet tried = 0;        ///< the world when a plan was last made
    Plan plan;
};

/// Sets a goal; the next follow() plans.
void aim(Agenda& agenda, std::uint16_t goal);

/// Looks at the world as it is. The last step whose kernel holds is the one to do: what an action
/// or luck has brought is never done again. Where none holds, not even to do it all over again, a
/// new plan is made; after a failure only once the world differs. Returns whether it planned.
bool follow(Agenda& agenda,
            const Domain& domain,
            const Actions& actions,
            FactSet world,
            GoapPlanner& planner);

}  // namespace zoned::ai::goap
