#include "server/config/npc/behaviour_parts.h"
#include "server/config/npc/blends.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/npc/poi_config.h"
#include "server/config/text/check_name.h"
#include "server/config/types/perceptions.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>
#include <vector>

namespace zoned::config {

namespace {

using ai::state_machine::StateMachineDefectKind;
using proto::config::Config;

/// A state must choose its action by exactly one setting. False where it names an unknown tree or
/// plan.
bool check_single_decider(const Config& config,
                          const proto::config::State& state,
                          const std::string& here,
                          Diagnostics& diagnostics) {
    if (static_cast<int>(state.has_brain()) + static_cast<int>(state.has_tree()) +
            static_cast<int>(state.has_domain()) + static_cast<int>(state.has_policy()) +
            static_cast<int>(state.has_blend()) >
        1) {
        diagnostics.add(here, "takes one of `brain`, `tree`, `domain`, `blend` and `policy`");
    }
    if (state.has_policy() && find_policy(config, state.policy()) < 0) {
        diagnostics.add(here + ".policy", "there is no policy named '" + state.policy() + "'");
        return false;
    }
    if (state.has_blend() && find_blend(config, state.blend()) < 0) {
        diagnostics.add(here + ".blend", "there is no blend named '" + state.blend() + "'");
        return false;
    }
    if (state.has_goal() && !state.has_domain()) {
        diagnostics.add(here + ".goal", "needs a `domain`");
    }
    if (state.has_tree() && find_tree(config, state.tree()) < 0) {
        diagnostics.add(here + ".tree", "there is no tree named '" + state.tree() + "'");
        return false;
    }
    const int domain = state.has_domain() ? find_domain(config, state.domain()) : -1;
    if (state.has_domain() && domain < 0) {
        diagnostics.add(here + ".domain", "there is no domain named '" + state.domain() + "'");
        return false;
    }
    if (domain >= 0 && find_goal(config.domain(domain), state) < 0) {
        diagnostics.add(here + ".goal",
                        "domain '" + state.domain() + "' has no goal named '" + state.goal() + "'");
        return false;
    }
    return true;
}

/// Names of one brain's states, and of the brains that they are. False where one is wrong.
bool check_states(const Config& config,
                  const proto::config::Brain& brain,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    std::set<std::string> names;
    bool right = true;
    for (int s = 0; s < brain.state_size(); ++s) {
        const std::string here = join_path(path, "state", s);
        const auto& state = brain.state(s);
        if (!check_name(state.name(), "state", here, diagnostics)) {
            right = false;
        } else if (!names.insert(state.name()).second) {
            diagnostics.add(here + ".name", "'" + state.name() + "' is the name of another state");
            right = false;
        }
        right = check_single_decider(config, state, here, diagnostics) && right;
        if (state.has_leash_m() && state.leash_m() < state.radius_m()) {
            diagnostics.add(here + ".leash_m", "is shorter than radius_m");
        }
        if (!state.has_brain()) {
            continue;
        }
        const int inside = find_brain(config, state.brain());
        if (inside < 0) {
            right = false;
            diagnostics.add(here + ".brain", "there is no brain named '" + state.brain() + "'");
        } else if (config.brain(inside).has_coded()) {
            right = false;
            diagnostics.add(here + ".brain",
                            "is a brain whose transitions come from code: types alone have those");
        }
        if (state.has_action() || state.has_speed_factor() || state.has_sprint() ||
            state.has_radius_m()) {
            diagnostics.add(here,
                            "a brain as a state: what to do, and how fast, say its own states");
        }
    }
    return right;
}

/// Code runs one level of states, in a brain of its own.
void check_code(const Config& config,
                const proto::config::Brain& brain,
                const std::string& path,
                Diagnostics& diagnostics) {
    if (!brain.has_coded()) {
        if (brain.reads_size() > 0) {
            diagnostics.add(join_path(path, "reads", 0), "needs `coded`");
        }
        return;
    }
    if (config.has_script()) {
        diagnostics.add(path + ".coded",
                        "rules by a script have no brains in code: rules in C++ do");
    }
    for (int s = 0; s < brain.state_size(); ++s) {
        const std::string here = join_path(path, "state", s);
        if (brain.state(s).transition_size() > 0) {
            diagnostics.add(join_path(here, "transition", 0),
                            "code '" + brain.coded() + "' makes the transitions of this brain");
        }
        if (brain.state(s).has_brain()) {
            diagnostics.add(here + ".brain", "code leads to no brain within a state");
        }
    }
}

void check_variables(const proto::config::Brain& brain,
                     const std::string& path,
                     Diagnostics& diagnostics) {
    std::set<std::string> names;
    for (int v = 0; v < brain.variable_size(); ++v) {
        const std::string here = join_path(path, "variable", v);
        const auto& variable = brain.variable(v);
        if (check_name(variable.name(), "variable", here, diagnostics) &&
            !names.insert(variable.name()).second) {
            diagnostics.add(here + ".name",
                            "'" + variable.name() + "' is the name of another variable");
        }
        if (!(variable.high() > variable.low())) {
            diagnostics.add(here, "high must be above low");
        } else if (variable.start() < variable.low() || variable.start() > variable.high()) {
            diagnostics.add(here + ".start", "lies outside of low to high");
        }
    }
}

void check_condition(const Config& config,
                     bool has_sense,
                     const std::string& sense,
                     proto::config::Sensor sensor,
                     double threshold,
                     int root,
                     const std::string& path,
                     Diagnostics& diagnostics) {
    if (has_sense) {
        const std::string wrong = why_not_sensed(config, root, sense);
        if (!wrong.empty()) {
            diagnostics.add(path + ".sense", wrong);
        }
        return;
    }
    const double perception_m =
        std::max(config.brain(root).perception_m(), config.brain(root).perception().hearing_m());
    if (sensor == proto::config::PLAYER_DISTANCE && threshold > perception_m) {
        diagnostics.add(path + ".threshold",
                        text_of("%g m is beyond perception_m, %g: players there are not noticed",
                                threshold,
                                perception_m));
    }
    if (sensor == proto::config::RANDOM && threshold > 1.0) {
        diagnostics.add(path + ".threshold", "RANDOM is drawn from [0, 1)");
    }
}

/// False where it leads nowhere.
bool check_transition(const Config& config,
                      const proto::config::Brain& brain,
                      const proto::config::Transition& transition,
                      int root,
                      const std::string& path,
                      Diagnostics& diagnostics) {
    const bool exists =
        std::any_of(brain.state().begin(), brain.state().end(), [&](const auto& state) {
            return state.name() == transition.to();
        });
    if (transition.to().empty()) {
        diagnostics.add(path, "a transition needs `to`, the name of a state");
    } else if (!exists) {
        diagnostics.add(
            path + ".to",
            "brain '" + brain.name() + "' has no state named '" + transition.to() + "'");
    }
    check_condition(config,
                    transition.has_sense(),
                    transition.sense(),
                    transition.sensor(),
                    transition.threshold(),
                    root,
                    path,
                    diagnostics);
    for (int a = 0; a < transition.also_size(); ++a) {
        const auto& also = transition.also(a);
        check_condition(config,
                        also.has_sense(),
                        also.sense(),
                        also.sensor(),
                        also.threshold(),
                        root,
                        join_path(path, "also", a),
                        diagnostics);
    }
    return exists;
}

/// One brain that runs by itself, with all that is inside it.
class RootCheck {
  public:
    /// `named`: by brain, whether its states have distinct names. `looked_at`: whether it was
    /// inside a checked brain.
    RootCheck(const Config& config,
              int root,
              const std::vector<bool>& named,
              std::vector<bool>& looked_at,
              Diagnostics& diagnostics)
        : config_(config),
          root_(root),
          named_(named),
          looked_at_(looked_at),
          diagnostics_(diagnostics) {}

    /// Reachability is checked only where all names are valid.
    void run() {
        transitions(root_);
        if (!broken_) {
            defects();
        }
    }

  private:
    /// Transitions of all brains inside, checked against the perception of this one's agents; finds
    /// cycles.
    void transitions(int index) {
        path_.push_back(index);
        looked_at_[static_cast<std::size_t>(index)] = true;
        broken_ = broken_ || !named_[static_cast<std::size_t>(index)];
        const proto::config::Brain& brain = config_.brain(index);
        const std::string path = join_path("", "brain", index);
        for (int r = 0; r < brain.reads_size(); ++r) {
            const std::string wrong = why_not_sensed(config_, root_, brain.reads(r));
            if (!wrong.empty()) {
                diagnostics_.add(join_path(path, "reads", r), wrong);
            }
        }
        for (int s = 0; s < brain.state_size(); ++s) {
            const auto& state = brain.state(s);
            const std::string here = join_path(path, "state", s);
            for (int t = 0; t < state.transition_size(); ++t) {
                const bool leads = check_transition(config_,
                                                    brain,
                                                    state.transition(t),
                                                    root_,
                                                    join_path(here, "transition", t),
                                                    diagnostics_);
                broken_ = broken_ || !leads;
            }
            if (state.rubber_band().rivals() > 0 && state.action() != proto::config::FOLLOW_TRACK) {
                diagnostics_.add(here + ".rubber_band.rivals", "is of FOLLOW_TRACK alone");
            }
            check_action(state, here);
            for_each_choice_action(
                config_, state, [this](const proto::config::Action& action, const std::string& at) {
                    check_action(action, at);
                });
            for_each_choice_condition(
                config_, state, [this](const proto::config::Condition& of, const std::string& at) {
                    check_condition(config_,
                                    of.has_sense(),
                                    of.sense(),
                                    of.sensor(),
                                    of.threshold(),
                                    root_,
                                    at,
                                    diagnostics_);
                });
            blend_inputs(state);
            const int inside = state.has_brain() ? find_brain(config_, state.brain()) : -1;
            if (inside < 0) {
                continue;
            }
            if (std::find(path_.begin(), path_.end(), inside) != path_.end()) {
                cycle(here, inside);
            } else if (done_.count(inside) == 0) {
                transitions(inside);
            }
        }
        path_.pop_back();
        done_.insert(index);
    }

    /// A state or action.
    template <class ActionSpec>
    void check_action(const ActionSpec& of, const std::string& path) {
        for (int c = 0; c < of.change_size(); ++c) {
            change(of.change(c), join_path(path, "change", c));
        }
        check_action_details(config_, root_, of, path, diagnostics_);
    }

    void blend_inputs(const proto::config::State& state) {
        const int blend = state.has_blend() ? find_blend(config_, state.blend()) : -1;
        for (int i = 0; blend >= 0 && i < config_.blend(blend).input_size(); ++i) {
            const proto::config::FuzzyInput& input = config_.blend(blend).input(i);
            const std::string wrong =
                input.has_sense() ? why_not_sensed(config_, root_, input.sense()) : std::string();
            if (!wrong.empty()) {
                diagnostics_.add(join_path(join_path("", "blend", blend), "input", i) + ".sense",
                                 wrong);
            }
        }
        for (int s = 0; blend >= 0 && s < config_.blend(blend).state_size(); ++s) {
            check_action(config_.blend(blend).state(s).do_(),
                         join_path(join_path("", "blend", blend), "state", s) + ".do");
        }
    }

    void change(const proto::config::Change& of, const std::string& path) {
        if (find_variable(config_.brain(root_), of.variable()) < 0) {
            diagnostics_.add(path + ".variable",
                             "brain '" + config_.brain(root_).name() + "' has no variable named '" +
                                 of.variable() + "'");
        }
    }

    void cycle(const std::string& here, int inside) {
        broken_ = true;
        std::string names;
        for (auto at = std::find(path_.begin(), path_.end(), inside); at != path_.end(); ++at) {
            names += "'" + config_.brain(*at).name() + "' holds ";
        }
        diagnostics_.add(
            here + ".brain",
            "a brain cannot be inside itself: " + names + "'" + config_.brain(inside).name() + "'");
    }

    void defects() {
        const ai::Brain brain = expand_brain(config_, root_);
        const std::size_t senses = ai::senses_of(brain);
        if (senses > ai::state_machine::kMaxSenses) {
            diagnostics_.add(join_path("", "brain", root_),
                             text_of("reads %g senses, at most %g",
                                     static_cast<double>(senses),
                                     static_cast<double>(ai::state_machine::kMaxSenses)));
        }
        // The perceptions of types are in brains of their own; brains that no type has are not
        // checked against them.
        const auto& types = config_.type();
        if (std::any_of(types.begin(), types.end(), [&brain](const proto::config::Type& type) {
                return type.brain() == brain.name;
            })) {
            check_company(brain, join_path("", "brain", root_), diagnostics_);
        }
        const std::size_t actions = actions_of(brain.states);
        if (actions > kMostActions) {
            diagnostics_.add(join_path("", "brain", root_),
                             text_of("its states and all that their trees and plans choose among "
                                     "are %g, at most %g",
                                     static_cast<double>(actions),
                                     static_cast<double>(kMostActions)));
        }
        for (const auto& defect :
             ai::state_machine::defects_of(ai::state_machine_of(brain), senses)) {
            // These were said above, by name, or follow from the number of states.
            if (defect.kind != StateMachineDefectKind::kUnknownState &&
                defect.kind != StateMachineDefectKind::kUnknownSense &&
                defect.kind != StateMachineDefectKind::kNoStates) {
                diagnostics_.add(path_of(defect), ai::state_machine::text_of(defect));
            }
        }
    }

    /// Innermost states and actions have numbers of 16 bits.
    static constexpr std::size_t kMostActions = 60000;

    static std::size_t actions_of(const std::vector<ai::BrainState>& states) {
        std::size_t actions = 0;
        for (const ai::BrainState& state : states) {
            actions += 1 + state.actions.size() + actions_of(state.inside);
        }
        return actions;
    }

    [[nodiscard]] std::string path_of(const ai::state_machine::StateMachineDefect& defect) const {
        int index = root_;
        std::string path = join_path("", "brain", index);
        for (std::size_t level = 0; level < defect.state.size(); ++level) {
            path = join_path(join_path("", "brain", index), "state", defect.state[level]);
            index = find_brain(config_, config_.brain(index).state(defect.state[level]).brain());
        }
        if (defect.transition >= 0) {
            path = join_path(path, "transition", defect.transition);
        }
        return defect.condition > 0 ? join_path(path, "also", defect.condition - 1) : path;
    }

    const Config& config_;
    int root_;
    const std::vector<bool>& named_;
    std::vector<bool>& looked_at_;
    Diagnostics& diagnostics_;
    std::vector<int> path_;
    std::set<int> done_;
    bool broken_ = false;
};

}  // namespace

void check_brains(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::set<std::string> names;
    std::vector<bool> named;
    for (int m = 0; m < config.brain_size(); ++m) {
        const std::string path = join_path("", "brain", m);
        const auto& brain = config.brain(m);
        if (check_name(brain.name(), "brain", path, diagnostics) &&
            !names.insert(brain.name()).second) {
            diagnostics.add(path + ".name", "'" + brain.name() + "' is the name of another brain");
        }
        named.push_back(check_states(config, brain, path, diagnostics));
        check_code(config, brain, path, diagnostics);
        check_variables(brain, path, diagnostics);
        if (brain.has_perception()) {
            check_perception(config, brain.perception(), path + ".perception", diagnostics);
        }
    }
    std::vector<bool> looked_at(named.size(), false);
    for (const int root : root_brains(config)) {
        RootCheck(config, root, named, looked_at, diagnostics).run();
    }
    // The brains of behaviours were checked in their types, with the types' parameters.
    for (const auto& behaviour : config.behaviour()) {
        for (const int m : parts_of(config, behaviour.brain()).brains) {
            looked_at[static_cast<std::size_t>(m)] = true;
        }
    }
    // Brains that hold each other in a ring have no root.
    for (std::size_t m = 0; m < looked_at.size(); ++m) {
        if (!looked_at[m]) {
            RootCheck(config, static_cast<int>(m), named, looked_at, diagnostics).run();
        }
    }
}

}  // namespace zoned::config
