#include "server/ai/agent/decision.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/simulation/zone_agents.h"

#include <algorithm>
#include <cmath>

namespace zoned::zone {

namespace {

const ai::CompiledBrain& brain_of(const ZoneState& state, const ai::Agent& agent) {
    return state.settings.ai.compiled[agent.brain];
}

std::optional<std::size_t> variable_of(const ai::CompiledBrain& brain, std::string_view name) {
    const auto at = std::ranges::find(brain.variables, name, &ai::BrainVariable::name);
    return at != brain.variables.end()
               ? std::optional(static_cast<std::size_t>(at - brain.variables.begin()))
               : std::nullopt;
}

}  // namespace

std::optional<AgentReading> ZoneContext::agent(EntityId entity) const {
    const ai::Agent* const agent = state_->agents.find(entity);
    if (agent == nullptr) {
        return std::nullopt;
    }
    const ai::CompiledBrain& brain = brain_of(*state_, *agent);
    return AgentReading{brain.name,
                        brain.states[agent->state_machine.leaf].name,
                        brain.states[agent->current_action].name,
                        agent->home,
                        agent->prey};
}

std::optional<double> ZoneContext::agent_variable(EntityId entity, std::string_view name) const {
    const ai::Agent* const agent = state_->agents.find(entity);
    if (agent == nullptr) {
        return std::nullopt;
    }
    const ai::CompiledBrain& brain = brain_of(*state_, *agent);
    const auto variable = variable_of(brain, name);
    return variable ? std::optional<double>(ai::variable_at(*agent, brain, *variable, state_->now))
                    : std::nullopt;
}

ai::Agent* ZoneContext::commanded(EntityId entity) {
    const world::Row row = owned(entity);
    if (row == world::kNoRow || state_->agents.find(entity) == nullptr) {
        return nullptr;
    }
    // Off screen its course was foreseen without this command.
    wake_agent(*state_, row);
    ai::Agent* const agent = state_->agents.find(entity);
    agent->next_decision = state_->now;
    return agent;
}

bool ZoneContext::set_agent_variable(EntityId entity, std::string_view name, double value) {
    const ai::Agent* const known = state_->agents.find(entity);
    const auto variable =
        known != nullptr ? variable_of(brain_of(*state_, *known), name) : std::nullopt;
    if (!variable || !std::isfinite(value)) {
        return false;
    }
    ai::Agent* const agent = commanded(entity);
    if (agent == nullptr) {
        return false;
    }
    const ai::CompiledBrain& brain = brain_of(*state_, *agent);
    ai::grow(*agent, brain, state_->now);
    const ai::BrainVariable& of = brain.variables[*variable];
    agent->variables[*variable] = std::clamp(static_cast<float>(value), of.low, of.high);
    return true;
}

bool ZoneContext::set_agent_home(EntityId entity, const Vec3& home) {
    ai::Agent* const agent = home.allFinite() ? commanded(entity) : nullptr;
    if (agent == nullptr) {
        return false;
    }
    agent->home = home;
    agent->entered = true;  // its action begins anew, from the new home
    return true;
}

}  // namespace zoned::zone
