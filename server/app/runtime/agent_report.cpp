#include "server/app/runtime/agent_report.h"

#include "server/ai/explain.h"
#include "server/ai/perception/perception.h"
#include "server/ai/steering/path_following.h"
#include "server/app/log/difficulty_log.h"
#include "server/zone/simulation/zone_agents.h"

namespace zoned::app {

std::string agent_report(const config::Settings& settings,
                         zone::Zone& zone,
                         EntityId entity,
                         Tick now) {
    zone::ZoneState& state = zone.state();
    const ai::Agent* agent = zone.owns(entity) ? state.agents.find(entity) : nullptr;
    if (agent == nullptr) {
        return {};
    }
    const world::Row row = state.entities.find(entity);
    const ai::AiSettings& agents = state.settings.ai;
    const ai::CompiledBrain& compiled = agents.compiled[agent->brain];
    spatial::PointGrid grid;
    grid.build(state.entities.position, 8.0F);
    const physics::Query statics = state.scene.query();
    compute::Team alone;
    ai::AiContext ai = zone::context_of(state, alone, &statics);
    ai.now = now;
    ai.near = &grid;
    const ai::Percept percept = ai::perceive(ai, row, *agent, compiled);
    const Vec3& at = state.entities.position[row];
    const Vec2 here = ai::whereabouts(*agent, Vec2(at.x(), at.z()), now + 1, state.settings.dt);
    return "entity " + std::to_string(entity.value) + ", a " +
           settings.types[state.entities.type[row]].name + " in zone " +
           std::to_string(state.settings.id.value) + ", after tick " + std::to_string(now) + "\n" +
           difficulty_text(state) +
           ai::explain(*agent,
                       agents.brains[agent->brain],
                       compiled,
                       percept,
                       here,
                       state.points_of_interest,
                       now,
                       state.settings.dt);
}

}  // namespace zoned::app
