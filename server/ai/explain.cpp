#include "server/ai/explain.h"

#include "server/ai/agent/brain/sense_names.h"
#include "server/ai/steering/spline_following.h"
#include "shared/core/print.h"

namespace zoned::ai {

namespace {

using core::print;

/// Writes the explanation of one agent.
class Account {
  public:
    Account(const Agent& agent,
            const Brain& brain,
            const CompiledBrain& compiled,
            const PointsOfInterest& points_of_interest,
            Tick now)
        : agent_(agent),
          brain_(brain),
          compiled_(compiled),
          points_of_interest_(points_of_interest),
          names_(sense_names(brain)),
          now_(now) {}

    std::string write(const Senses& senses, float dt) {
        states(dt);
        text_ += "does " + compiled_.states[agent_.current_action].name + "\n";
        track(dt);
        learned();
        degrees();
        text_ += "senses:\n";
        for (std::size_t k = 0; k < names_.size(); ++k) {
            text_ += print("  %s %g\n", names_[k].c_str(), static_cast<double>(senses[k]));
        }
        for (std::size_t f = 0; f < compiled_.fuzzy.size(); ++f) {
            rules(brain_.fuzzy[f], compiled_.fuzzy[f], senses);
        }
        if (compiled_.code) {
            by_code(dt);
            return std::move(text_);
        }
        text_ += "transitions, as they are tried:\n";
        const state_machine::FlatStateMachine& table = compiled_.table;
        const state_machine::FlatTest* row = &table.tests[agent_.state_machine.leaf * table.width];
        for (std::size_t k = 0; k < table.width && row[k].transition != state_machine::kNone; ++k) {
            transition(row[k], senses, dt);
        }
        return std::move(text_);
    }

  private:
    [[nodiscard]] const std::uint16_t* path() const {
        return &compiled_.table.path[agent_.state_machine.leaf * compiled_.table.levels];
    }

    [[nodiscard]] double seconds_in(std::size_t level, float dt) const {
        return static_cast<double>(now_ - agent_.state_machine.since[level]) *
               static_cast<double>(dt);
    }

    void states(float dt) {
        text_ += print("brain %s, in state:\n", brain_.name.c_str());
        for (std::size_t level = 0; level < compiled_.table.levels; ++level) {
            if (path()[level] != state_machine::kNone) {
                text_ += print("  %s for %.2f s\n",
                               compiled_.table.nodes[path()[level]].name.c_str(),
                               seconds_in(level, dt));
            }
        }
    }

    /// Writes where on its spline the agent is.
    void track(float dt) {
        if (compiled_.states[agent_.current_action].action != ActionKind::kFollowTrack ||
            agent_.entered) {
            return;
        }
        const SplinePlace place = spline_place(agent_, points_of_interest_);
        if (place.lane == splines::kNoLane) {
            return;
        }
        text_ += "on track " + points_of_interest_.tracks()->name(place.lane);
        if (agent_.corner == kJoins) {
            text_ += ": walks there\n";
        } else if (agent_.corner == kTrackEnds) {
            text_ += ": at its end\n";
        } else {
            const double due =
                static_cast<double>(agent_.track.due - now_) * static_cast<double>(dt) +
                static_cast<double>(agent_.track.due_s);
            text_ += print(": at %.2f m of %.2f m in %.2f s", place.s, place.length, due);
            if (agent_.track.from != splines::kNoLane) {
                text_ += ", coming from " + points_of_interest_.tracks()->name(agent_.track.from);
            }
            text_ += "\n";
        }
    }

    /// Writes the envelope of a policy, and the values that adapt.
    void learned() {
        const BrainState& state = compiled_.states[agent_.current_action];
        if (const auto* choice = std::get_if<PolicyChoice>(&state.choice)) {
            const learning::Guard& guard = choice->policy->guard;
            text_ += print("as policy %s says, within %.3g of full speed%s, %.3g rad/s, ",
                           choice->policy->policy.name.c_str(),
                           static_cast<double>(guard.max_speed),
                           guard.may_sprint ? " and sprint" : "",
                           static_cast<double>(guard.max_turn_radps));
            text_ += guard.max_home_m > 0.0F
                         ? print("%.3g m from home\n", static_cast<double>(guard.max_home_m))
                         : "anywhere\n";
        }
        if (state.rubber_band) {
            text_ += print("rubber band: speed times %.3f, within [%.3g, %.3g]\n",
                           static_cast<double>(agent_.band),
                           static_cast<double>(state.rubber_band->least),
                           static_cast<double>(state.rubber_band->most));
        }
    }

    /// Writes the degrees of a blend, by state.
    void degrees() {
        const std::uint16_t leaf = agent_.state_machine.leaf;
        const CompiledBrain::LeafChoice& choice = compiled_.choices[leaf];
        if (choice.blend < 0) {
            return;
        }
        text_ += "blended, by degree:\n";
        for (std::size_t d = 0; d < compiled_.states[leaf].actions.size(); ++d) {
            text_ += print("  %s %.3g\n",
                           compiled_.states[choice.first + d].name.c_str(),
                           static_cast<double>(agent_.degrees[d]));
        }
    }

    void rules(const FuzzySense& sense,
               const CompiledBrain::Fuzzy& compiled,
               const Senses& senses) {
        std::vector<float> in;
        for (const SenseIndex input : compiled.inputs) {
            in.push_back(senses[input]);
        }
        std::vector<float> degrees;
        compiled.system.explain(in, degrees);
        text_ += print("rules of %s that fire:\n", sense.def.name.c_str());
        for (std::size_t r = 0; r < degrees.size(); ++r) {
            if (degrees[r] > 0.0F) {
                text_ += "  " + rule_text(sense.def, sense.def.rules[r]) +
                         print(": %.3g\n", static_cast<double>(degrees[r]));
            }
        }
    }

    /// Writes the code that makes the transitions, what it reads, and the transition that it holds.
    void by_code(float dt) {
        const state_machine::BoundMachine& code = *compiled_.code;
        text_ += "transitions by code " + code.name() + ", which reads:";
        for (const SenseIndex sense : code.senses()) {
            text_ += (sense == code.senses().front() ? " " : ", ") + names_[sense];
        }
        text_ += "\n";
        if (agent_.state_machine.pending != state_machine::kNone) {
            const Tick held = now_ - agent_.state_machine.pending_since;
            text_ += print("  %s, held %.2f s\n",
                           code.transitions()[agent_.state_machine.pending].c_str(),
                           static_cast<double>(held) * static_cast<double>(dt));
        }
    }

    static std::string rule_text(const fuzzy::FuzzyDef& def, const fuzzy::Rule& rule) {
        std::string text;
        for (const fuzzy::Proposition& p : rule.when) {
            text += text.empty() ? "" : rule.any ? " or " : " and ";
            text += def.inputs[p.variable].name + (p.negated ? " is not " : " is ") +
                    def.inputs[p.variable].terms[p.term].name;
        }
        const fuzzy::FuzzyOutput& output = def.outputs[rule.output];
        return text + ", then " + output.name + " is " +
               (output.inference == fuzzy::Inference::kSugeno ? output.values[rule.then].name
                                                              : output.terms[rule.then].name);
    }

    void transition(const state_machine::FlatTest& first, const Senses& senses, float dt) {
        const state_machine::FlatTransition& transition =
            compiled_.table.transitions[first.transition];
        text_ += "  " + compiled_.table.nodes[path()[transition.level]].name + " -> " +
                 compiled_.table.nodes[transition.to].name + ": ";
        condition(first, senses, dt);
        for (std::size_t c = 0; c < transition.more_count; ++c) {
            text_ += ", and ";
            condition(compiled_.table.more[transition.more + c], senses, dt);
        }
        if (transition.hold > 0) {
            const bool pending = agent_.state_machine.pending == first.transition;
            const Tick held = pending ? now_ - agent_.state_machine.pending_since : 0;
            text_ += print(", held %.2f of %.2f s",
                           static_cast<double>(held) * static_cast<double>(dt),
                           static_cast<double>(transition.hold) * static_cast<double>(dt));
        }
        text_ += "\n";
    }

    void condition(const state_machine::FlatTest& test, const Senses& senses, float dt) {
        const bool own_time = test.sense >= compiled_.senses;
        const double value = own_time ? seconds_in(test.sense - compiled_.senses, dt)
                                      : static_cast<double>(senses[test.sense]);
        const double threshold = static_cast<double>(test.threshold * test.sign);
        const bool holds = test.sign > 0.0F ? value < threshold : value > threshold;
        text_ += print("%s %g %s %g: %s",
                       own_time ? "time in state" : names_[test.sense].c_str(),
                       value,
                       test.sign > 0.0F ? "below" : "above",
                       threshold,
                       holds ? "yes" : "no");
    }

    const Agent& agent_;
    const Brain& brain_;
    const CompiledBrain& compiled_;
    const PointsOfInterest& points_of_interest_;
    std::vector<std::string> names_;
    Tick now_;
    std::string text_;
};

}  // namespace

std::string transition_text(const Brain& brain,
                            const CompiledBrain& compiled,
                            std::uint16_t from,
                            std::uint16_t to,
                            std::uint16_t number) {
    const state_machine::FlatStateMachine& table = compiled.table;
    const std::vector<std::string> names = sense_names(brain);
    const auto condition = [&](const state_machine::FlatTest& test) {
        return (test.sense >= compiled.senses ? std::string("time in state") : names[test.sense]) +
               print(" %s %g",
                     test.sign > 0.0F ? "below" : "above",
                     static_cast<double>(test.threshold * test.sign));
    };
    std::string text = table.state_name(from) + " -> " + table.state_name(to);
    if (compiled.code) {
        return text + " by code: " + compiled.code->transitions()[number];
    }
    const state_machine::FlatTest* row = &table.tests[from * table.width];
    for (std::size_t k = 0; k < table.width; ++k) {
        if (row[k].transition != number) {
            continue;
        }
        text += " where " + condition(row[k]);
        const state_machine::FlatTransition& transition = table.transitions[number];
        for (std::size_t c = 0; c < transition.more_count; ++c) {
            text += " and " + condition(table.more[transition.more + c]);
        }
        break;
    }
    return text;
}

std::string explain(const Agent& agent,
                    const Brain& brain,
                    const CompiledBrain& compiled,
                    const Percept& percept,
                    const Vec2& here,
                    const PointsOfInterest& points_of_interest,
                    Tick now,
                    float dt) {
    Senses senses;
    sense(agent, compiled, percept, here, points_of_interest, now, senses);
    return Account(agent, brain, compiled, points_of_interest, now).write(senses, dt);
}

}  // namespace zoned::ai
