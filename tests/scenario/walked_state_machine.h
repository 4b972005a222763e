// WalkedMachine: a state machine walked level by level on its definition, slow, for comparison. It
// shares only the definition with the tables.
#pragma once

#include "server/ai/decision/state_machine/state_machine_def.h"
#include "shared/core/ids.h"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace zoned::scenario {

/// One agent. `dt` in s.
class WalkedMachine {
  public:
    WalkedMachine(ai::state_machine::StateMachineDef def, float dt)
        : def_(std::move(def)),
          dt_(dt) {
        enter(def_.states, 0, 0);
    }

    /// Starts again from the state of `other`, with indices into its own definition.
    WalkedMachine(const WalkedMachine& other) : WalkedMachine(other.def_, other.dt_) {}

    WalkedMachine& operator=(const WalkedMachine&) = delete;

    void tick(Tick now, std::span<const float> senses) {
        const ai::state_machine::TransitionDef* held = nullptr;
        std::size_t held_level = 0;
        const States* level = &def_.states;
        for (std::size_t l = 0; l < path_.size(); ++l) {
            const ai::state_machine::StateDef& state = (*level)[path_[l]];
            for (const ai::state_machine::TransitionDef& transition : state.transitions) {
                if (!all_hold(transition, senses, now, l)) {
                    continue;
                }
                if (transition.hold_s <= 0.0F) {
                    leave(now, l, *level, transition.to);
                    held_ = held_level < l ? held : nullptr;
                    return;
                }
                if (held != nullptr) {
                    continue;
                }
                held = &transition;
                held_level = l;
                if (held_ != held) {
                    held_ = held;
                    held_since_ = now;
                } else if (static_cast<float>(now - held_since_) * dt_ >= transition.hold_s) {
                    leave(now, l, *level, transition.to);
                    held_ = nullptr;
                    return;
                }
            }
            level = &state.inside;
        }
        held_ = held;
    }

    /// "day/labour/fetch"
    [[nodiscard]] std::string name() const {
        std::string name;
        const States* level = &def_.states;
        for (const std::uint16_t s : path_) {
            name += (name.empty() ? "" : "/") + (*level)[s].name;
            level = &(*level)[s].inside;
        }
        return name;
    }

  private:
    using States = std::vector<ai::state_machine::StateDef>;

    [[nodiscard]] bool all_hold(const ai::state_machine::TransitionDef& transition,
                                std::span<const float> senses,
                                Tick now,
                                std::size_t level) const {
        for (const ai::Condition& condition : transition.when) {
            const float value = condition.sense == ai::kStateTime
                                    ? static_cast<float>(now - since_[level]) * dt_
                                    : senses[condition.sense];
            if (!ai::holds(condition, value)) {
                return false;
            }
        }
        return true;
    }

    void leave(Tick now, std::size_t level, const States& siblings, std::uint16_t to) {
        const States* states = &siblings;
        for (std::size_t l = level; l < path_.size(); ++l) {
            const ai::state_machine::StateDef* state = &(*states)[path_[l]];
            if (state->history != ai::state_machine::StateHistory::kNone) {
                last_[state] = {path_.begin() + static_cast<std::ptrdiff_t>(l) + 1, path_.end()};
            }
            states = &state->inside;
        }
        path_.resize(level);
        since_.resize(level);
        enter(siblings, to, now);
    }

    void enter(const States& states, std::uint16_t at, Tick now) {
        path_.push_back(at);
        since_.push_back(now);
        const ai::state_machine::StateDef& state = states[at];
        if (state.inside.empty()) {
            return;
        }
        const auto last = last_.find(&state);
        if (last == last_.end()) {
            enter(state.inside, 0, now);
        } else if (state.history == ai::state_machine::StateHistory::kShallow) {
            enter(state.inside, last->second[0], now);
        } else {
            for (const std::uint16_t s : last->second) {
                path_.push_back(s);
                since_.push_back(now);
            }
        }
    }

    ai::state_machine::StateMachineDef def_;
    float dt_;
    std::vector<std::uint16_t> path_;
    std::vector<Tick> since_;
    std::map<const ai::state_machine::StateDef*, std::vector<std::uint16_t>> last_;
    const ai::state_machine::TransitionDef* held_ = nullptr;
    Tick held_since_ = 0;
};

}  // namespace zoned::scenario
