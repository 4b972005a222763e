#include "server/ai/update/forage_update.h"

namespace zoned::ai {

namespace {

bool forages(const Agent& agent, const AiSettings& settings) {
    const CompiledBrain& brain = settings.compiled[agent.brain];
    // An agent that has only just begun to forage starts when it steers.
    return brain.forages && !agent.entered &&
           brain.states[agent.current_action].action == ActionKind::kForage;
}

}  // namespace

/// After a door has moved, suspended foraging creatures check their path as well.
void ForageUpdate::call_foragers(const AiContext& ai) const {
    for (std::size_t n = 0; nests_.turned() && n < ai.agents.size(); ++n) {
        const Slot slot = ai.agents.nth(n);
        Agent& agent = ai.agents.at(slot);
        if (agent.tier == Tier::kSuspended && forages(agent, ai.settings)) {
            agent.next_event = ai.now;
            schedule_event(ai, slot);
        }
    }
}

/// Chooses the next cell of each agent that forages.
void ForageUpdate::forage(const AiContext& ai, AiTurn& turn) {
    nests_.clear();
    const std::span<const Slot> active = ai.agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = ai.agents.at(active[i]);
        if (turn.rows[i] != world::kNoRow && forages(agent, ai.settings)) {
            nests_.add({agent.entity, turn.rows[i], active[i]});
        }
    }
    for (const DueAgent& due : turn.due) {
        if (due.tier == Tier::kSuspended && forages(ai.agents.at(due.slot), ai.settings)) {
            nests_.add({due.entity, due.row, due.slot});
        }
    }
    nests_.step(ai);
    turn.report.delivered = nests_.delivered();
}

}  // namespace zoned::ai
