// Sentry: one state machine as data, as a switch and as a class per state, with its senses.
#pragma once

#include "server/ai/decision/state_machine/coded_state_machine.h"
#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::scenario {

inline constexpr float kSentryDt = 1.0F / 30.0F;

enum SentrySense : ai::SenseIndex {
    kFoeDistance,   ///< m
    kPostDistance,  ///< m
    kHealth,        ///< [0, 1]
    kNoise,         ///< [0, 1]
    kSentrySenses,
};

enum SentryState : std::uint16_t {
    kPatrol,
    kListen,
    kChase,
    kFight,
    kFlee,
    kRest,
    kSentryStates,
};

/// Six states with two transitions each; some conditions must hold for a while.
inline ai::state_machine::StateMachineDef sentry_def() {
    using ai::Compare;
    using ai::state_machine::StateDef;
    using ai::state_machine::TransitionDef;
    const auto when = [](std::uint16_t to,
                         ai::SenseIndex sense,
                         Compare compare,
                         float threshold,
                         float hold_s = 0.0F) {
        return TransitionDef{to, {{sense, compare, threshold}}, hold_s};
    };
    const auto state =
        [](const char* name, std::uint16_t action, TransitionDef a, TransitionDef b) {
            return StateDef{name, action, {std::move(a), std::move(b)}, {}, {}};
        };
    const auto below = Compare::kBelow;
    const auto above = Compare::kAbove;
    return {"sentry",
            {state("patrol",
                   kPatrol,
                   when(kListen, kNoise, above, 0.7F),
                   when(kChase, kFoeDistance, below, 20.0F, 0.3F)),
             state("listen",
                   kListen,
                   when(kChase, kFoeDistance, below, 25.0F, 0.1F),
                   when(kPatrol, ai::kStateTime, above, 5.0F)),
             state("chase",
                   kChase,
                   when(kFight, kFoeDistance, below, 3.0F),
                   when(kPatrol, kFoeDistance, above, 35.0F, 1.0F)),
             state("fight",
                   kFight,
                   when(kFlee, kHealth, below, 0.3F),
                   when(kChase, kFoeDistance, above, 5.0F, 0.2F)),
             state("flee",
                   kFlee,
                   when(kRest, kFoeDistance, above, 40.0F),
                   when(kRest, kPostDistance, below, 5.0F, 0.5F)),
             state("rest",
                   kRest,
                   when(kPatrol, kHealth, above, 0.9F),
                   when(kFlee, kFoeDistance, below, 10.0F))}};
}

/// The state machine as a switch.
inline void sentry_decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) {
    const float foe = senses[kFoeDistance];
    switch (turn.state()) {
        case kPatrol:
            if (turn.when(senses[kNoise] > 0.7F, 0)) {
                return turn.enter(kListen, 0);
            }
            if (turn.when(foe < 20.0F, 1, 0.3F)) {
                return turn.enter(kChase, 1);
            }
            break;
        case kListen:
            if (turn.when(foe < 25.0F, 2, 0.1F)) {
                return turn.enter(kChase, 2);
            }
            if (turn.when(turn.time_in_state() > 5.0F, 3)) {
                return turn.enter(kPatrol, 3);
            }
            break;
        case kChase:
            if (turn.when(foe < 3.0F, 4)) {
                return turn.enter(kFight, 4);
            }
            if (turn.when(foe > 35.0F, 5, 1.0F)) {
                return turn.enter(kPatrol, 5);
            }
            break;
        case kFight:
            if (turn.when(senses[kHealth] < 0.3F, 6)) {
                return turn.enter(kFlee, 6);
            }
            if (turn.when(foe > 5.0F, 7, 0.2F)) {
                return turn.enter(kChase, 7);
            }
            break;
        case kFlee:
            if (turn.when(foe > 40.0F, 8)) {
                return turn.enter(kRest, 8);
            }
            if (turn.when(senses[kPostDistance] < 5.0F, 9, 0.5F)) {
                return turn.enter(kRest, 9);
            }
            break;
        default:
            if (turn.when(senses[kHealth] > 0.9F, 10)) {
                return turn.enter(kPatrol, 10);
            }
            if (turn.when(foe < 10.0F, 11)) {
                return turn.enter(kFlee, 11);
            }
            break;
    }
}

/// The state machine as a class per state.
class PatrolState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kNoise] > 0.7F, 0)) {
            return turn.enter(kListen, 0);
        }
        if (turn.when(senses[kFoeDistance] < 20.0F, 1, 0.3F)) {
            return turn.enter(kChase, 1);
        }
    }
};

class ListenState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kFoeDistance] < 25.0F, 2, 0.1F)) {
            return turn.enter(kChase, 2);
        }
        if (turn.when(turn.time_in_state() > 5.0F, 3)) {
            return turn.enter(kPatrol, 3);
        }
    }
};

class ChaseState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kFoeDistance] < 3.0F, 4)) {
            return turn.enter(kFight, 4);
        }
        if (turn.when(senses[kFoeDistance] > 35.0F, 5, 1.0F)) {
            return turn.enter(kPatrol, 5);
        }
    }
};

class FightState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kHealth] < 0.3F, 6)) {
            return turn.enter(kFlee, 6);
        }
        if (turn.when(senses[kFoeDistance] > 5.0F, 7, 0.2F)) {
            return turn.enter(kChase, 7);
        }
    }
};

class FleeState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kFoeDistance] > 40.0F, 8)) {
            return turn.enter(kRest, 8);
        }
        if (turn.when(senses[kPostDistance] < 5.0F, 9, 0.5F)) {
            return turn.enter(kRest, 9);
        }
    }
};

class RestState final : public ai::state_machine::CodedState {
  public:
    void decide(ai::state_machine::CodedTurn& turn, std::span<const float> senses) const override {
        if (turn.when(senses[kHealth] > 0.9F, 10)) {
            return turn.enter(kPatrol, 10);
        }
        if (turn.when(senses[kFoeDistance] < 10.0F, 11)) {
            return turn.enter(kFlee, 11);
        }
    }
};

/// Names of the sentry's senses, by number.
inline std::vector<std::string> sentry_sense_names() {
    return {"foe", "post", "health", "noise"};
}

/// The code of the sentry: a switch, or an object a state.
inline ai::state_machine::CodedMachine sentry_code(bool objects) {
    ai::state_machine::CodedMachine code;
    code.name = objects ? "sentry objects" : "sentry";
    code.states = {"patrol", "listen", "chase", "fight", "flee", "rest"};
    code.senses = sentry_sense_names();
    for (const char* from : {"patrol", "listen", "chase", "fight", "flee", "rest"}) {
        code.transitions.push_back(std::string(from) + " 1");
        code.transitions.push_back(std::string(from) + " 2");
    }
    if (!objects) {
        code.decision = &sentry_decide;
        return code;
    }
    code.objects = {std::make_shared<PatrolState>(),
                    std::make_shared<ListenState>(),
                    std::make_shared<ChaseState>(),
                    std::make_shared<FightState>(),
                    std::make_shared<FleeState>(),
                    std::make_shared<RestState>()};
    return code;
}

/// The code for agents whose states are those of `machine`.
inline ai::state_machine::BoundMachine bound_sentry(
    bool objects,
    const ai::state_machine::FlatStateMachine& machine) {
    std::vector<std::string> leaves;
    for (std::uint16_t leaf = 0; leaf < machine.leaves(); ++leaf) {
        leaves.push_back(machine.state_name(leaf));
    }
    return ai::state_machine::BoundMachine::bind(
               sentry_code(objects), leaves, sentry_sense_names(), machine.dt)
        .value();
}

/// The senses of `count` agents, side by side for each.
class Sensed {
  public:
    Sensed(std::size_t senses, std::size_t count) : senses_(senses), values_(senses * count) {}

    [[nodiscard]] float& at(std::size_t sense, std::size_t agent) {
        return values_[agent * senses_ + sense];
    }

    [[nodiscard]] std::span<const float> of(std::size_t agent) const {
        return std::span(values_).subspan(agent * senses_, senses_);
    }

  private:
    std::size_t senses_;
    std::vector<float> values_;
};

/// Foes come and go, wounds heal: a walk at random that leads through all states. Call it once a
/// tick.
inline void sentry_walk(Sensed& sensed, std::size_t count, core::Rng& rng) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto walk = [&](std::size_t sense, float step, float high) {
            float& value = sensed.at(sense, i);
            value = std::min(high, std::max(0.0F, value + rng.range(-step, step)));
        };
        walk(kFoeDistance, 4.0F, 50.0F);
        walk(kPostDistance, 3.0F, 60.0F);
        walk(kHealth, 0.06F, 1.0F);
        walk(kNoise, 0.08F, 1.0F);
    }
}

}  // namespace zoned::scenario
