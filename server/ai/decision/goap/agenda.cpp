#include "server/ai/decision/goap/agenda.h"

#include "shared/core/assert.h"

namespace zoned::ai::goap {

namespace {

/// Takes up the plan where the world stands; false where nothing of it is of use.
bool resume(Agenda& agenda, FactSet world) {
    const Plan& plan = agenda.plan;
    for (std::size_t k = plan.size + 1U; k-- > 0;) {
        if (plan.kernel[k].hold_in(world)) {
            agenda.step = static_cast<std::uint8_t>(k);
            agenda.state = k == plan.size ? AgendaState::kReached : AgendaState::kActing;
            return true;
        }
    }
    return false;
}

}  // namespace

void aim(Agenda& agenda, std::uint16_t goal) {
    agenda.goal = goal;
    agenda.plan.verdict = Verdict::kCutOff;
    agenda.plan.size = 0;
    agenda.step = 0;
    agenda.plans = 0;
}

bool follow(Agenda& agenda,
            const Domain& domain,
            const Actions& actions,
            FactSet world,
            GoapPlanner& planner) {
    ZONED_ASSERT(agenda.goal < domain.goals.size(), "a goal of the domain");
    if (agenda.plan.verdict == Verdict::kPlanned && resume(agenda, world)) {
        return false;
    }
    const bool failed = agenda.plans > 0 && agenda.plan.verdict != Verdict::kPlanned;
    if (failed && agenda.tried == world) {
        return false;
    }
    planner.plan(actions, world, domain.goals[agenda.goal].wants, agenda.plan);
    ++agenda.plans;
    agenda.tried = world;
    if (agenda.plan.verdict == Verdict::kPlanned) {
        resume(agenda, world);
    } else {
        agenda.step = 0;
        agenda.state = agenda.plan.verdict == Verdict::kUnreachable ? AgendaState::kUnreachable
                                                                    : AgendaState::kCutOff;
    }
    return true;
}

}  // namespace zoned::ai::goap
