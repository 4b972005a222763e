#include "server/ai/decision/state_machine/state_machine_def.h"

#include <algorithm>

namespace zoned::ai::state_machine {

namespace {

/// Inspects one state machine after the other, from the outermost inwards.
class Inspection {
  public:
    Inspection(std::size_t senses, bool coded) : senses_(senses), coded_(coded) {}

    void machine(const std::vector<StateDef>& states) {
        if (states.empty()) {
            add(StateMachineDefectKind::kNoStates);
            return;
        }
        const std::vector<bool> reached = reached_states(states);
        for (std::size_t s = 0; s < states.size(); ++s) {
            place_.push_back(static_cast<std::uint16_t>(s));
            state(states[s], states.size(), coded_ || reached[s]);
            place_.pop_back();
        }
    }

    std::vector<StateMachineDefect> defects;

  private:
    void add(StateMachineDefectKind kind, int transition = -1, int condition = -1) {
        defects.push_back({kind, place_, transition, condition});
    }

    static std::vector<bool> reached_states(const std::vector<StateDef>& states) {
        std::vector<bool> reached(states.size(), false);
        std::vector<std::size_t> open{0};
        reached[0] = true;
        while (!open.empty()) {
            const StateDef& from = states[open.back()];
            open.pop_back();
            for (const TransitionDef& transition : from.transitions) {
                if (transition.to < states.size() && !reached[transition.to]) {
                    reached[transition.to] = true;
                    open.push_back(transition.to);
                }
            }
        }
        return reached;
    }

    void state(const StateDef& state, std::size_t siblings, bool reached) {
        if (!reached) {
            add(StateMachineDefectKind::kUnreachable);
        }
        for (std::size_t t = 0; t < state.transitions.size(); ++t) {
            transition(state, static_cast<int>(t), siblings);
            if (tried_ + t == kMaxTransitions) {
                add(StateMachineDefectKind::kTooMany, static_cast<int>(t));
            }
        }
        tried_ += state.transitions.size();
        inside(state);
        tried_ -= state.transitions.size();
    }

    void inside(const StateDef& state) {
        if (state.inside.empty()) {
            if (state.history != StateHistory::kNone) {
                add(StateMachineDefectKind::kIdleMemory);
            }
            if (++leaves_ == kMaxLeaves + 1) {
                add(StateMachineDefectKind::kTooMany);
            }
            return;
        }
        if (state.history != StateHistory::kNone && ++memories_ == kMaxMemories + 1) {
            add(StateMachineDefectKind::kTooMany);
        }
        if (place_.size() >= kMaxLevels) {
            add(StateMachineDefectKind::kTooDeep);
            return;
        }
        machine(state.inside);
    }

    void transition(const StateDef& state, int index, std::size_t siblings) {
        const TransitionDef& transition = state.transitions[static_cast<std::size_t>(index)];
        if (transition.to >= siblings) {
            add(StateMachineDefectKind::kUnknownState, index);
        }
        if (transition.when.empty()) {
            add(StateMachineDefectKind::kNoCondition, index);
            return;
        }
        for (std::size_t c = 0; c < transition.when.size(); ++c) {
            const SenseIndex sense = transition.when[c].sense;
            if (sense != kStateTime && sense >= senses_) {
                add(StateMachineDefectKind::kUnknownSense, index, static_cast<int>(c));
            }
            if (excluded(transition.when, c)) {
                add(StateMachineDefectKind::kNeverHolds, index, static_cast<int>(c));
            }
        }
        for (int earlier = 0; earlier < index; ++earlier) {
            if (covers(state.transitions[static_cast<std::size_t>(earlier)], transition)) {
                add(StateMachineDefectKind::kNeverTried, index);
                return;
            }
        }
    }

    /// True where an earlier condition on the same sense leaves no value for this one.
    static bool excluded(const std::vector<Condition>& when, std::size_t at) {
        const Condition& b = when[at];
        return std::any_of(
            when.begin(), when.begin() + static_cast<std::ptrdiff_t>(at), [&b](const Condition& a) {
                return a.sense == b.sense && a.compare != b.compare &&
                       (a.compare == Compare::kBelow ? a.threshold <= b.threshold
                                                     : b.threshold <= a.threshold);
            });
    }

    static bool implies(const Condition& b, const Condition& a) {
        return a.sense == b.sense && a.compare == b.compare &&
               (a.compare == Compare::kBelow ? b.threshold <= a.threshold
                                             : b.threshold >= a.threshold);
    }

    /// True where `a` fires at once whenever `b` holds.
    static bool covers(const TransitionDef& a, const TransitionDef& b) {
        return a.hold_s <= 0.0F && !a.when.empty() &&
               std::all_of(a.when.begin(), a.when.end(), [&b](const Condition& wanted) {
                   return std::any_of(
                       b.when.begin(), b.when.end(), [&wanted](const Condition& given) {
                           return implies(given, wanted);
                       });
               });
    }

    std::size_t senses_;
    bool coded_;
    std::size_t tried_ = 0;  ///< transitions of the states that this one is inside
    std::size_t leaves_ = 0;
    std::size_t memories_ = 0;
    std::vector<std::uint16_t> place_;
};

}  // namespace

std::vector<StateMachineDefect> defects_of(const StateMachineDef& def, std::size_t senses) {
    Inspection inspection(senses, def.coded);
    inspection.machine(def.states);
    return std::move(inspection.defects);
}

std::string text_of(const StateMachineDefect& defect) {
    switch (defect.kind) {
        case StateMachineDefectKind::kNoStates:
            return "a machine needs at least one state";
        case StateMachineDefectKind::kUnknownState:
            return "leads to a state that does not exist";
        case StateMachineDefectKind::kUnreachable:
            return "is never entered: no chain of transitions leads here from the first state";
        case StateMachineDefectKind::kUnknownSense:
            return "reads a sense that these agents do not have";
        case StateMachineDefectKind::kNoCondition:
            return "needs at least one condition";
        case StateMachineDefectKind::kNeverTried:
            return "never fires: an earlier transition without hold_s fires whenever it could";
        case StateMachineDefectKind::kNeverHolds:
            return "excludes an earlier condition of the same transition";
        case StateMachineDefectKind::kTooDeep:
            return "is a machine at level " + std::to_string(kMaxLevels + 1) + "; at most " +
                   std::to_string(kMaxLevels) + " levels";
        case StateMachineDefectKind::kTooMany:
            return "is one too many: at most " + std::to_string(kMaxLeaves) +
                   " states that hold no others, " + std::to_string(kMaxMemories) +
                   " with a history, and " + std::to_string(kMaxTransitions) +
                   " transitions of a state with those that it is inside";
        case StateMachineDefectKind::kIdleMemory:
            return "has a history, but nothing inside that it could remember";
    }
    return "is wrong";
}

}  // namespace zoned::ai::state_machine
