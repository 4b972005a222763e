#include "server/ai/agent/ai_settings.h"

#include "server/ai/agent/brain/sense_names.h"

#include <algorithm>

namespace zoned::ai {

namespace {

std::vector<CompiledBrain> compiled_of(const std::vector<Brain>& brains, float dt) {
    std::vector<CompiledBrain> out;
    for (const Brain& brain : brains) {
        out.push_back(brain.inner ? CompiledBrain{} : compile(brain, dt));
    }
    return out;
}

/// The reason why `compiled`, made of `brain`, cannot have the code that it names; empty: it has
/// it.
std::string give_code(const Brain& brain,
                      std::span<const state_machine::CodedMachine> machines,
                      CompiledBrain& compiled) {
    const auto named = [&brain](const auto& machine) {
        return machine.name == brain.coded;
    };
    const auto machine = std::find_if(machines.begin(), machines.end(), named);
    if (std::count_if(machines.begin(), machines.end(), named) != 1) {
        return "names code '" + brain.coded + "', which these rules " +
               (machine == machines.end() ? "do not have" : "have twice");
    }
    std::vector<std::string> leaves;
    for (std::uint16_t leaf = 0; leaf < compiled.table.leaves(); ++leaf) {
        leaves.push_back(compiled.table.state_name(leaf));
    }
    auto bound = state_machine::BoundMachine::bind(
        *machine, leaves, config_sense_names(brain), compiled.table.dt);
    if (!bound.ok()) {
        return bound.error();
    }
    std::uint64_t read = 0;
    for (const SenseIndex sense : bound->senses()) {
        read |= std::uint64_t{1} << sense;
    }
    for (std::uint64_t& senses : compiled.senses_of_leaf) {
        senses |= read;
    }
    compiled.table.transitions.assign(bound->transitions().size(), {});
    compiled.code = std::move(bound).value();
    return {};
}

std::string give_code(const std::vector<Brain>& brains,
                      std::span<const state_machine::CodedMachine> machines,
                      std::vector<CompiledBrain>& compiled) {
    for (std::size_t m = 0; m < brains.size(); ++m) {
        if (brains[m].coded.empty() || brains[m].inner) {
            continue;
        }
        const std::string wrong = give_code(brains[m], machines, compiled[m]);
        if (!wrong.empty()) {
            return "brain '" + brains[m].name + "' " + wrong;
        }
    }
    return {};
}

}  // namespace

void compile(AiSettings& settings, float dt) {
    settings.compiled = compiled_of(settings.brains, dt);
    for (DifficultyLevel& level : settings.difficulty.levels) {
        level.compiled = compiled_of(level.brains, dt);
    }
    if (settings.avoidance) {
        steering::AvoidanceSettings& avoidance = *settings.avoidance;
        avoidance.step_s = dt;
        avoidance.horizon_s = std::max(avoidance.horizon_s, dt);
        avoidance.wall_horizon_s = std::max(avoidance.wall_horizon_s, dt);
    }
}

bool travels(const AiSettings& settings, std::uint16_t brain) {
    const auto in = [brain](const std::vector<CompiledBrain>& compiled) {
        return brain != 0 && brain <= compiled.size() &&
               std::any_of(compiled[brain - 1U].states.begin(),
                           compiled[brain - 1U].states.end(),
                           [](const BrainState& state) { return goes_to_places(state.action); });
    };
    return in(settings.compiled) ||
           std::any_of(settings.difficulty.levels.begin(),
                       settings.difficulty.levels.end(),
                       [&in](const DifficultyLevel& level) { return in(level.compiled); });
}

std::string bind_code(AiSettings& settings, std::span<const state_machine::CodedMachine> machines) {
    std::string wrong = give_code(settings.brains, machines, settings.compiled);
    for (DifficultyLevel& level : settings.difficulty.levels) {
        if (wrong.empty()) {
            wrong = give_code(level.brains, machines, level.compiled);
        }
    }
    return wrong;
}

}  // namespace zoned::ai
