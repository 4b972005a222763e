#include "server/ai/update/crowd_update.h"

namespace zoned::ai {

/// Computes the current formation slot of each agent that keeps formation around another entity.
void CrowdUpdate::place_formations(const AiContext& ai, const AiTurn& turn) {
    formations_.clear();
    const std::span<const Slot> active = ai.agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const Agent& agent = ai.agents.at(active[i]);
        const CompiledBrain& brain = ai.settings.compiled[agent.brain];
        if (turn.rows[i] == world::kNoRow || !brain.forms_up || !agent.ward ||
            brain.states[agent.current_action].action != ActionKind::kFormUp) {
            continue;
        }
        const world::Row captain = ai.entities.find(agent.ward);
        if (captain != world::kNoRow) {
            formations_.add({agent.ward, agent.entity, captain, turn.rows[i], active[i]});
        }
    }
    if (!formations_.empty()) {
        formations_.place(
            ai.agents, ai.entities, ai.types, ai.settings.compiled, walls_.of(ai.statics), ai.now);
    }
}

/// Makes agents on a collision course avoid each other. An agent's desired velocity stays its aim.
void CrowdUpdate::avoid(const AiContext& ai, AiTurn& turn) {
    if (!ai.settings.avoidance) {
        return;
    }
    walkers_.clear();
    const std::span<const Slot> active = ai.agents.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        if (turn.rows[i] != world::kNoRow) {
            const Agent& agent = ai.agents.at(active[i]);
            const BrainState& state =
                ai.settings.compiled[agent.brain].states[agent.current_action];
            const Vec3& at = ai.entities.position[turn.rows[i]];
            walkers_.push_back(
                {turn.rows[i],
                 path_left(agent, state, ai.points_of_interest, Vec2(at.x(), at.z()))});
        }
    }
    turn.report.avoidance = avoidance_.step(walkers_, ai, walls_, *ai.settings.avoidance);
}

}  // namespace zoned::ai
