#include "server/rules/agents/gate_guard.h"

#include <memory>

namespace zoned::rules {

namespace {

using ai::state_machine::CodedMachine;
using ai::state_machine::CodedState;
using ai::state_machine::CodedTurn;
using GuardSenses = std::span<const float>;

enum GuardPhase : std::uint16_t {
    kAtPost,
    kOnRound,
    kInPursuit,
    kOutOfBreath,
    kOnWayBack,
};

enum GuardSense : std::size_t {
    kIntruderM,
    kGateM,
    kBreath,
};

enum GuardTransition : std::uint16_t {
    kIntruderAtPost,
    kPostIsOver,
    kIntruderOnRound,
    kRoundIsOver,
    kTooFar,
    kEscaped,
    kExhausted,
    kReadyAgain,
    kRested,
    kAtTheGate,
};

constexpr float kNoticeM = 12.0F;
constexpr float kNoticeS = 0.4F;
constexpr float kLoseM = 16.0F;
constexpr float kLoseS = 1.0F;
constexpr float kLeashM = 18.0F;
constexpr float kGateReachM = 2.0F;
constexpr float kPostS = 4.0F;
constexpr float kRoundS = 8.0F;
constexpr float kBreathless = 0.2F;
constexpr float kReady = 0.8F;
constexpr float kFullBreath = 0.9F;

// ---------------------------------------------------------------- as a switch

void decide_gate_guard(CodedTurn& turn, GuardSenses senses) {
    switch (turn.state()) {
        case kAtPost:
            if (turn.when(senses[kIntruderM] < kNoticeM, kIntruderAtPost, kNoticeS)) {
                return turn.enter(kInPursuit, kIntruderAtPost);
            }
            if (turn.when(turn.time_in_state() > kPostS, kPostIsOver)) {
                return turn.enter(kOnRound, kPostIsOver);
            }
            break;
        case kOnRound:
            if (turn.when(senses[kIntruderM] < kNoticeM, kIntruderOnRound, kNoticeS)) {
                return turn.enter(kInPursuit, kIntruderOnRound);
            }
            if (turn.when(turn.time_in_state() > kRoundS, kRoundIsOver)) {
                return turn.enter(kAtPost, kRoundIsOver);
            }
            break;
        case kInPursuit:
            if (turn.when(senses[kGateM] > kLeashM, kTooFar)) {
                return turn.enter(kOnWayBack, kTooFar);
            }
            if (turn.when(senses[kIntruderM] > kLoseM, kEscaped, kLoseS)) {
                return turn.enter(kOnWayBack, kEscaped);
            }
            if (turn.when(senses[kBreath] < kBreathless, kExhausted)) {
                return turn.enter(kOutOfBreath, kExhausted);
            }
            break;
        case kOutOfBreath:
            if (turn.when(senses[kBreath] > kReady && senses[kIntruderM] < kNoticeM, kReadyAgain)) {
                return turn.enter(kInPursuit, kReadyAgain);
            }
            if (turn.when(senses[kBreath] > kFullBreath, kRested)) {
                return turn.enter(kOnWayBack, kRested);
            }
            break;
        default:
            if (turn.when(senses[kGateM] < kGateReachM, kAtTheGate)) {
                return turn.enter(kAtPost, kAtTheGate);
            }
            break;
    }
}

// ---------------------------------------------------------------- as an object a state

class GuardAtPost final : public CodedState {
  public:
    void decide(CodedTurn& turn, GuardSenses senses) const override {
        if (turn.when(senses[kIntruderM] < kNoticeM, kIntruderAtPost, kNoticeS)) {
            turn.enter(kInPursuit, kIntruderAtPost);
        } else if (turn.when(turn.time_in_state() > kPostS, kPostIsOver)) {
            turn.enter(kOnRound, kPostIsOver);
        }
    }
};

class GuardOnRound final : public CodedState {
  public:
    void decide(CodedTurn& turn, GuardSenses senses) const override {
        if (turn.when(senses[kIntruderM] < kNoticeM, kIntruderOnRound, kNoticeS)) {
            turn.enter(kInPursuit, kIntruderOnRound);
        } else if (turn.when(turn.time_in_state() > kRoundS, kRoundIsOver)) {
            turn.enter(kAtPost, kRoundIsOver);
        }
    }
};

class GuardInPursuit final : public CodedState {
  public:
    void decide(CodedTurn& turn, GuardSenses senses) const override {
        if (turn.when(senses[kGateM] > kLeashM, kTooFar)) {
            turn.enter(kOnWayBack, kTooFar);
        } else if (turn.when(senses[kIntruderM] > kLoseM, kEscaped, kLoseS)) {
            turn.enter(kOnWayBack, kEscaped);
        } else if (turn.when(senses[kBreath] < kBreathless, kExhausted)) {
            turn.enter(kOutOfBreath, kExhausted);
        }
    }
};

class GuardOutOfBreath final : public CodedState {
  public:
    void decide(CodedTurn& turn, GuardSenses senses) const override {
        const bool near = senses[kIntruderM] < kNoticeM;
        if (turn.when(senses[kBreath] > kReady && near, kReadyAgain)) {
            turn.enter(kInPursuit, kReadyAgain);
        } else if (turn.when(senses[kBreath] > kFullBreath, kRested)) {
            turn.enter(kOnWayBack, kRested);
        }
    }
};

class GuardOnWayBack final : public CodedState {
  public:
    void decide(CodedTurn& turn, GuardSenses senses) const override {
        if (turn.when(senses[kGateM] < kGateReachM, kAtTheGate)) {
            turn.enter(kAtPost, kAtTheGate);
        }
    }
};

}  // namespace

ai::state_machine::CodedMachines gate_guards() {
    CodedMachine by_switch;
    by_switch.name = "gate_guard";
    by_switch.states = {"post", "round", "pursuit", "rest", "way_back"};
    by_switch.senses = {"PLAYER_DISTANCE", "HOME_DISTANCE", "breath"};
    by_switch.transitions = {"intruder at post",
                             "post is over",
                             "intruder on round",
                             "round is over",
                             "too far",
                             "escaped",
                             "exhausted",
                             "ready again",
                             "rested",
                             "at the gate"};
    CodedMachine by_states = by_switch;
    by_switch.decision = &decide_gate_guard;
    by_states.name = "gate_guard_states";
    by_states.objects = {std::make_shared<GuardAtPost>(),
                         std::make_shared<GuardOnRound>(),
                         std::make_shared<GuardInPursuit>(),
                         std::make_shared<GuardOutOfBreath>(),
                         std::make_shared<GuardOnWayBack>()};
    return {std::move(by_switch), std::move(by_states)};
}

}  // namespace zoned::rules
