#include "server/ai/decision.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

struct Senses {
    float player_distance = 0.0F;
    float home_distance = 0.0F;
    float time_in_state = 0.0F;
    float random = 0.0F;
};

float read(const Senses& senses, Sensor sensor) {
    switch (sensor) {
        case Sensor::kPlayerDistance:
            return senses.player_distance;
        case Sensor::kHomeDistance:
            return senses.home_distance;
        case Sensor::kTimeInState:
            return senses.time_in_state;
        case Sensor::kRandom:
            return senses.random;
    }
    ZONED_ASSERT(false, "a sensor is one of the enumeration");
    return 0.0F;
}

bool holds(const Transition& transition, const Senses& senses) {
    const float value = read(senses, transition.sensor);
    return transition.compare == Compare::kBelow ? value < transition.threshold
                                                 : value > transition.threshold;
}

void enter(Mind& mind, std::uint16_t state, Tick now) {
    mind.state = state;
    mind.state_since = now;
    mind.holding_since = -1;
    mind.entered = true;
}

}  // namespace

bool decide(Mind& mind,
            const Machine& machine,
            const Sight& sight,
            const Vec3& position,
            Tick now,
            float dt) {
    Senses senses;
    senses.player_distance = sight.distance;
    senses.home_distance = Vec2(position.x() - mind.home.x(), position.z() - mind.home.z()).norm();
    senses.time_in_state = static_cast<float>(now - mind.state_since) * dt;
    senses.random = mind.rng.unit();
    mind.prey = sight.prey;
    mind.far = sight.player_far;
    mind.fresh = true;

    const std::vector<Transition>& transitions = machine.states[mind.state].transitions;
    bool pending = false;
    for (std::size_t i = 0; i < transitions.size(); ++i) {
        const Transition& transition = transitions[i];
        if (!holds(transition, senses)) {
            continue;
        }
        if (transition.hold_s <= 0.0F) {
            enter(mind, transition.to, now);
            return true;
        }
        if (pending) {
            continue;
        }
        pending = true;
        if (mind.holding_since < 0 || mind.holding != i) {
            mind.holding = static_cast<std::uint16_t>(i);
            mind.holding_since = now;
        } else if (static_cast<float>(now - mind.holding_since) * dt >= transition.hold_s) {
            enter(mind, transition.to, now);
            return true;
        }
    }
    if (!pending) {
        mind.holding_since = -1;
    }
    return false;
}

Tick decision_period(const Machine& machine, float dt) {
    return std::max<Tick>(1, std::lround(machine.decide_every_s / dt));
}

Tick next_decision(EntityId entity, Tick period, Tick now) {
    const Tick phase = static_cast<Tick>(entity.value) % period;
    const Tick earliest = now + 1;
    return earliest + ((phase - earliest) % period + period) % period;
}

}  // namespace zoned::ai
