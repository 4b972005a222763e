#include "server/ai/decision.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

void add(Mind& mind, const CompiledMachine& machine, std::size_t variable, float amount) {
    const Variable& of = machine.variables[variable];
    mind.variables[variable] = std::clamp(mind.variables[variable] + amount, of.low, of.high);
}

/// What states from `level` on give to those who enter them.
void gain(Mind& mind, const CompiledMachine& machine, std::size_t level) {
    const fsm::FlatMachine& table = machine.table;
    const std::uint16_t* path = &table.path[mind.fsm.state() * table.levels];
    for (const CompiledMachine::Gain& gain : machine.gains) {
        const std::size_t at = table.nodes[gain.node].level;
        if (at >= level && path[at] == gain.node) {
            add(mind, machine, gain.variable, gain.amount);
        }
    }
}

}  // namespace

void begin(Mind& mind, const CompiledMachine& machine, Tick now) {
    mind.fsm = fsm::OneState(now);
    for (std::size_t v = 0; v < machine.variables.size(); ++v) {
        mind.variables[v] = machine.variables[v].start;
    }
    mind.variables_at = now;
    gain(mind, machine, 0);
}

void grow(Mind& mind, const CompiledMachine& machine, Tick now) {
    const std::size_t count = machine.variables.size();
    const auto ticks = static_cast<float>(now - mind.variables_at);
    for (std::size_t v = 0; v < count; ++v) {
        add(mind, machine, v, machine.rates[mind.fsm.state() * count + v] * ticks);
    }
    mind.variables_at = now;
}

void sense(const Mind& mind,
           const CompiledMachine& machine,
           const Sight& sight,
           const Vec3& position,
           float random,
           Senses& senses) {
    senses[kSensePlayerDistance] = sight.distance;
    senses[kSenseHomeDistance] =
        Vec2(position.x() - mind.home.x(), position.z() - mind.home.z()).norm();
    senses[kSenseRandom] = random;
    std::copy_n(mind.variables.begin(), machine.variables.size(), senses.begin() + kOwnSenses);
    for (const CompiledMachine::Fuzzy& fuzzy : machine.fuzzy) {
        std::array<const float*, fuzzy::kMaxInputs> in{};
        std::array<float*, fuzzy::kMaxOutputs> out{};
        for (std::size_t k = 0; k < fuzzy.inputs.size(); ++k) {
            in[k] = &senses[fuzzy.inputs[k]];
        }
        for (std::size_t o = 0; o < fuzzy.system.outputs(); ++o) {
            out[o] = &senses[fuzzy.first + o];
        }
        fuzzy.system.evaluate(std::span(in.data(), fuzzy.inputs.size()),
                              1,
                              std::span(out.data(), fuzzy.system.outputs()));
    }
}

bool decide(Mind& mind,
            const CompiledMachine& machine,
            const Sight& sight,
            const Vec3& position,
            Tick now) {
    grow(mind, machine, now);
    Senses senses;
    sense(mind, machine, sight, position, mind.rng.unit(), senses);
    mind.prey = sight.prey;
    mind.far = sight.player_far;
    mind.fresh = true;
    const std::optional<fsm::Change> change =
        fsm::step_one(machine.table, mind.fsm, std::span(senses.data(), machine.senses), now);
    if (!change) {
        return false;
    }
    gain(mind, machine, machine.table.transitions[change->transition].level);
    mind.entered = true;
    return true;
}

Tick decision_period(const CompiledMachine& machine, float dt) {
    return std::max<Tick>(1, std::lround(machine.decide_every_s / dt));
}

Tick next_decision(EntityId entity, Tick period, Tick now) {
    const Tick phase = static_cast<Tick>(entity.value) % period;
    const Tick earliest = now + 1;
    return earliest + ((phase - earliest) % period + period) % period;
}

}  // namespace zoned::ai
