#include "server/ai/decision.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

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
    Senses senses;
    sense(mind, machine, sight, position, mind.rng.unit(), senses);
    mind.prey = sight.prey;
    mind.far = sight.player_far;
    mind.fresh = true;
    const bool changed =
        fsm::step_one(machine.table, mind.fsm, std::span(senses.data(), machine.senses), now)
            .has_value();
    mind.entered = mind.entered || changed;
    return changed;
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
