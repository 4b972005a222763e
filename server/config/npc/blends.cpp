#include "server/config/npc/blends.h"

#include "server/config/npc/choices.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/npc/fuzzy_config.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using proto::config::Config;

/// A fuzzy system with the blend's inputs and a rule for each of its transitions. So one piece of
/// code checks and expands the parts that fuzzy systems and blends share.
proto::config::Fuzzy system_of(const proto::config::Blend& blend) {
    proto::config::Fuzzy out;
    out.set_name("blend");
    *out.mutable_input() = blend.input();
    proto::config::FuzzyOutput* output = out.add_output();
    output->set_name("fires");
    output->add_value()->set_name("yes");
    for (const proto::config::BlendTransition& transition : blend.transition()) {
        proto::config::FuzzyRule* rule = out.add_rule();
        *rule->mutable_when() = transition.when();
        rule->set_any(transition.any());
        rule->set_then("yes");
    }
    return out;
}

int find_state(const proto::config::Blend& blend, const std::string& name) {
    for (int s = 0; s < blend.state_size(); ++s) {
        if (blend.state(s).name() == name) {
            return s;
        }
    }
    return -1;
}

void check_actions(const proto::config::Blend& blend,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    std::set<int> seen;
    for (int s = 0; s < blend.state_size(); ++s) {
        const proto::config::ActionKind action = blend.state(s).do_().action();
        const std::string here = join_path(path, "state", s) + ".do";
        if (action == proto::config::FLOCK) {
            diagnostics.add(here, "FLOCK cannot be blended: herds steer by decisions alone");
        }
        if (action == proto::config::FORM_UP || action == proto::config::FORAGE) {
            diagnostics.add(here, "cannot be blended: its places are kept by one action");
        }
        // Round and post are remembered in one place.
        const int kind =
            action == proto::config::GUARD ? static_cast<int>(proto::config::PATROL) : action;
        if (!seen.insert(kind).second && action != proto::config::IDLE) {
            diagnostics.add(here, "another state of the blend does this already");
        }
    }
}

void check_blend(const proto::config::Blend& blend,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    std::set<std::string> names;
    for (int s = 0; s < blend.state_size(); ++s) {
        const std::string here = join_path(path, "state", s);
        if (check_name(blend.state(s).name(), "state", here, diagnostics) &&
            !names.insert(blend.state(s).name()).second) {
            diagnostics.add(here + ".name",
                            "'" + blend.state(s).name() + "' is the name of another state");
        }
    }
    check_actions(blend, path, diagnostics);
    std::set<int> reached{0};
    for (int t = 0; t < blend.transition_size(); ++t) {
        const proto::config::BlendTransition& transition = blend.transition(t);
        const std::string here = join_path(path, "transition", t);
        diagnostics.set_origin(join_path(path, "rule", t), here, "");
        for (const bool from : {true, false}) {
            const std::string& name = from ? transition.from() : transition.to();
            if (find_state(blend, name) < 0) {
                diagnostics.add(here + (from ? ".from" : ".to"),
                                "there is no state named '" + name + "'");
            }
        }
        if (transition.from() == transition.to()) {
            diagnostics.add(here, "leads from a state to itself");
        }
        reached.insert(find_state(blend, transition.to()));
    }
    for (int s = 0; s < blend.state_size(); ++s) {
        if (reached.count(s) == 0) {
            diagnostics.add(join_path(path, "state", s), "no transition leads here");
        }
    }
    check_fuzzy_system(system_of(blend), path, diagnostics);
}

}  // namespace

void expand_blend(const Config& config,
                  const proto::config::Blend& blend,
                  const std::function<ai::SenseIndex(const proto::config::FuzzyInput&)>& sense_of,
                  const VariableOf& variable_of,
                  ai::BrainState& out) {
    const ai::fuzzy::FuzzyDef system = expand_fuzzy(system_of(blend));
    ai::BlendChoice choice;
    choice.def.name = blend.name();
    choice.def.inputs = system.inputs;
    choice.def.response_s = narrow(blend.response_s());
    for (const proto::config::FuzzyInput& input : blend.input()) {
        choice.inputs.push_back(sense_of(input));
    }
    for (const proto::config::BlendState& state : blend.state()) {
        choice.def.states.push_back(state.name());
        out.actions.push_back(expand_action(config, state.name(), state.do_(), variable_of));
    }
    for (int t = 0; t < blend.transition_size(); ++t) {
        const auto index = [&blend](const std::string& name) {
            return static_cast<std::uint16_t>(std::max(find_state(blend, name), 0));
        };
        choice.def.transitions.push_back({index(blend.transition(t).from()),
                                          index(blend.transition(t).to()),
                                          system.rules[static_cast<std::size_t>(t)].when,
                                          blend.transition(t).any()});
    }
    out.choice = std::move(choice);
}

void check_blends(const Config& config, Diagnostics& diagnostics) {
    std::set<std::string> names;
    for (int b = 0; b < config.blend_size(); ++b) {
        const std::string path = join_path("", "blend", b);
        if (check_name(config.blend(b).name(), "blend", path, diagnostics) &&
            !names.insert(config.blend(b).name()).second) {
            diagnostics.add(path + ".name",
                            "'" + config.blend(b).name() + "' is the name of another blend");
        }
        check_blend(config.blend(b), path, diagnostics);
    }
}

}  // namespace zoned::config
