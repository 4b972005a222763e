#include "server/config/npc/choices.h"

#include "server/config/npc/find_by_name.h"
#include "server/config/npc/poi_config.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/stances.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using proto::config::Config;

/// "not x" is x, negated.
std::pair<std::string, bool> literal(const std::string& text) {
    const bool negated = text.rfind("not ", 0) == 0;
    return {negated ? text.substr(4) : text, negated};
}

template <class Names>
ai::goap::Literals literals(const proto::config::Domain& domain, const Names& names) {
    ai::goap::Literals out;
    for (const std::string& text : names) {
        const auto [name, negated] = literal(text);
        const int fact = index_of(domain.fact(), name);
        if (fact >= 0) {
            (negated ? out.no : out.yes) |= ai::goap::FactSet{1} << fact;
        }
    }
    return out;
}

ai::goap::Domain expand_domain(const proto::config::Domain& domain) {
    ai::goap::Domain out;
    for (const auto& fact : domain.fact()) {
        out.facts.push_back(fact.name());
    }
    for (const auto& action : domain.action()) {
        out.actions.push_back({action.name(),
                               literals(domain, action.needs()),
                               literals(domain, action.makes()),
                               action.cost()});
    }
    for (const auto& goal : domain.goal()) {
        out.goals.push_back({goal.name(), literals(domain, goal.wants())});
    }
    return out;
}

/// With the senses that `sense_of` gives; actions are numbered by node.
ai::tree::TreeDef expand_tree(const proto::config::Tree& tree, const SenseOf& sense_of) {
    ai::tree::TreeDef out;
    out.name = tree.name();
    for (int n = 0; n < tree.node_size(); ++n) {
        const auto& node = tree.node(n);
        ai::tree::NodeDef def;
        def.name = node.name();
        def.action = static_cast<std::uint16_t>(n);
        if (node.has_ask()) {
            def.test = {sense_of(node.ask()),
                        static_cast<ai::Compare>(node.ask().compare()),
                        narrow(node.ask().threshold())};
            // A name that means nothing is a node that does not exist; a question without answers
            // is none either.
            constexpr int kNoNode = 1 << 20;
            const int yes = index_of(tree.node(), node.yes());
            const int no = index_of(tree.node(), node.no());
            def.yes = yes < 0 ? kNoNode : yes;
            def.no = no < 0 ? kNoNode : no;
        }
        out.nodes.push_back(std::move(def));
    }
    return out;
}

void unique(const std::string& name,
            const std::string& what,
            const std::string& path,
            std::set<std::string>& names,
            Diagnostics& diagnostics) {
    if (check_name(name, what, path, diagnostics) && !names.insert(name).second) {
        diagnostics.add(path + ".name", "'" + name + "' is the name of another " + what);
    }
}

void check_untimed(const proto::config::Condition& condition,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    if (!condition.has_sense() && condition.sensor() == proto::config::TIME_IN_STATE) {
        diagnostics.add(path, "the time in a state is known to transitions alone: set `sensor`");
    }
}

void check_tree(const proto::config::Tree& tree,
                const std::string& path,
                Diagnostics& diagnostics) {
    std::set<std::string> names;
    bool named = true;
    for (int n = 0; n < tree.node_size(); ++n) {
        const auto& node = tree.node(n);
        const std::string here = join_path(path, "node", n);
        unique(node.name(), "node", here, names, diagnostics);
        if (node.has_ask() == node.has_do_()) {
            diagnostics.add(here, "needs either `ask` or `do`");
            named = false;
        }
        if (!node.has_ask()) {
            continue;
        }
        check_untimed(node.ask(), here + ".ask", diagnostics);
        for (const bool yes : {true, false}) {
            const std::string& to = yes ? node.yes() : node.no();
            if (index_of(tree.node(), to) < 0) {
                diagnostics.add(here + (yes ? ".yes" : ".no"),
                                to.empty() ? "a question needs `yes` and `no`, names of nodes"
                                           : "there is no node named '" + to + "'");
                named = false;
            }
        }
    }
    if (!named) {
        return;
    }
    // Which senses there are is judged with the brains that use the tree; here each name counts
    // as one, so that questions about the same can be compared.
    std::vector<std::string> seen;
    const SenseOf sense_of = [&seen](const proto::config::Condition& condition) {
        const std::string name =
            condition.has_sense() ? condition.sense() : std::to_string(condition.sensor());
        const auto at = std::find(seen.begin(), seen.end(), name);
        const auto index = static_cast<ai::SenseIndex>(at - seen.begin());
        if (at == seen.end()) {
            seen.push_back(name);
        }
        return index;
    };
    const ai::tree::TreeDef def = expand_tree(tree, sense_of);
    for (const auto& defect : ai::tree::defects_of(def, seen.size())) {
        diagnostics.add(join_path(path, "node", defect.node), ai::tree::text_of(defect));
    }
}

/// Whether all names are facts.
template <class Names>
bool check_facts(const proto::config::Domain& domain,
                 const Names& names,
                 const std::string& path,
                 const std::string& what,
                 Diagnostics& diagnostics) {
    bool right = true;
    for (int i = 0; i < names.size(); ++i) {
        const std::string name = literal(names[i]).first;
        if (index_of(domain.fact(), name) < 0) {
            diagnostics.add(join_path(path, what, i),
                            "there is no fact named '" + name + "' (\"FACT\" or \"not FACT\")");
            right = false;
        }
    }
    return right;
}

void check_domain(const proto::config::Domain& domain,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    std::set<std::string> facts;
    for (int f = 0; f < domain.fact_size(); ++f) {
        const std::string here = join_path(path, "fact", f);
        unique(domain.fact(f).name(), "fact", here, facts, diagnostics);
        for (int w = 0; w < domain.fact(f).when_size(); ++w) {
            check_untimed(domain.fact(f).when(w), join_path(here, "when", w), diagnostics);
        }
    }
    bool right = true;
    std::set<std::string> actions;
    for (int a = 0; a < domain.action_size(); ++a) {
        const auto& action = domain.action(a);
        const std::string here = join_path(path, "action", a);
        unique(action.name(), "action", here, actions, diagnostics);
        right = check_facts(domain, action.needs(), here, "needs", diagnostics) && right;
        right = check_facts(domain, action.makes(), here, "makes", diagnostics) && right;
    }
    std::set<std::string> goals;
    for (int g = 0; g < domain.goal_size(); ++g) {
        const std::string here = join_path(path, "goal", g);
        unique(domain.goal(g).name(), "goal", here, goals, diagnostics);
        right = check_facts(domain, domain.goal(g).wants(), here, "wants", diagnostics) && right;
    }
    if (!right) {
        return;
    }
    const ai::goap::Domain expanded = expand_domain(domain);
    for (const auto& defect : ai::goap::defects_of(expanded)) {
        const std::string place = defect.action >= 0 ? join_path(path, "action", defect.action)
                                  : defect.goal >= 0 ? join_path(path, "goal", defect.goal)
                                                     : path;
        diagnostics.add(place, ai::goap::text_of(defect, expanded));
    }
}

}  // namespace

void for_each_choice_condition(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Condition&, const std::string&)>& look) {
    const int tree = state.has_tree() ? find_tree(config, state.tree()) : -1;
    for (int n = 0; tree >= 0 && n < config.tree(tree).node_size(); ++n) {
        if (config.tree(tree).node(n).has_ask()) {
            look(config.tree(tree).node(n).ask(),
                 join_path(join_path("", "tree", tree), "node", n) + ".ask");
        }
    }
    const int domain = state.has_domain() ? find_domain(config, state.domain()) : -1;
    for (int f = 0; domain >= 0 && f < config.domain(domain).fact_size(); ++f) {
        const auto& fact = config.domain(domain).fact(f);
        for (int w = 0; w < fact.when_size(); ++w) {
            look(fact.when(w),
                 join_path(join_path(join_path("", "domain", domain), "fact", f), "when", w));
        }
    }
}

void for_each_choice_action(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Action&, const std::string&)>& look) {
    const int tree = state.has_tree() ? find_tree(config, state.tree()) : -1;
    for (int n = 0; tree >= 0 && n < config.tree(tree).node_size(); ++n) {
        look(config.tree(tree).node(n).do_(),
             join_path(join_path("", "tree", tree), "node", n) + ".do");
    }
    const int domain = state.has_domain() ? find_domain(config, state.domain()) : -1;
    for (int a = 0; domain >= 0 && a < config.domain(domain).action_size(); ++a) {
        look(config.domain(domain).action(a).do_(),
             join_path(join_path("", "domain", domain), "action", a) + ".do");
    }
}

ai::VariableChange expand_change(const proto::config::Change& change,
                                 const VariableOf& variable_of) {
    ai::VariableChange out;
    out.variable = variable_of(change.variable());
    if (change.has_per_s()) {
        out.per_s = narrow(change.per_s());
    }
    out.on_enter = narrow(change.on_enter());
    return out;
}

ai::BrainState expand_action(const proto::config::Config& config,
                             const std::string& name,
                             const proto::config::Action& action,
                             const VariableOf& variable_of) {
    ai::BrainState out;
    out.name = name;
    out.action = static_cast<ai::ActionKind>(action.action());
    out.speed_factor = narrow(action.speed_factor());
    out.sprint = action.sprint();
    out.radius_m = narrow(action.radius_m());
    out.leash_m = narrow(action.has_leash_m() ? action.leash_m() : kLeash * action.radius_m());
    out.stance = static_cast<std::uint8_t>(action.stance());
    if (action.has_named_stance()) {
        out.stance =
            static_cast<std::uint8_t>(std::max(find_stance(config, action.named_stance()), 0));
    }
    for (const auto& change : action.change()) {
        out.changes.push_back(expand_change(change, variable_of));
    }
    expand_action_details(config, action, variable_of, out);
    return out;
}

void expand_choice(const proto::config::Config& config,
                   const proto::config::State& state,
                   const SenseOf& sense_of,
                   const VariableOf& variable_of,
                   ai::BrainState& out) {
    const int tree = state.has_tree() ? find_tree(config, state.tree()) : -1;
    const int domain = state.has_domain() ? find_domain(config, state.domain()) : -1;
    if (tree >= 0) {
        out.choice = ai::TreeChoice{expand_tree(config.tree(tree), sense_of)};
        for (const auto& node : config.tree(tree).node()) {
            out.actions.push_back(expand_action(config, node.name(), node.do_(), variable_of));
        }
    } else if (domain >= 0) {
        ai::PlanChoice plan;
        plan.domain = expand_domain(config.domain(domain));
        plan.goal =
            static_cast<std::uint16_t>(std::max(find_goal(config.domain(domain), state), 0));
        for (const auto& fact : config.domain(domain).fact()) {
            plan.facts.emplace_back();
            for (const auto& when : fact.when()) {
                plan.facts.back().push_back({sense_of(when),
                                             static_cast<ai::Compare>(when.compare()),
                                             narrow(when.threshold())});
            }
        }
        out.choice = std::move(plan);
        for (const auto& action : config.domain(domain).action()) {
            out.actions.push_back(expand_action(config, action.name(), action.do_(), variable_of));
        }
    } else if (state.has_policy()) {
        out.choice = ai::PolicyChoice{
            static_cast<std::uint16_t>(std::max(find_policy(config, state.policy()), 0)), {}, {}};
    }
}

void check_choices(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::set<std::string> trees;
    for (int t = 0; t < config.tree_size(); ++t) {
        const std::string path = join_path("", "tree", t);
        unique(config.tree(t).name(), "tree", path, trees, diagnostics);
        check_tree(config.tree(t), path, diagnostics);
    }
    std::set<std::string> domains;
    for (int d = 0; d < config.domain_size(); ++d) {
        const std::string path = join_path("", "domain", d);
        unique(config.domain(d).name(), "domain", path, domains, diagnostics);
        check_domain(config.domain(d), path, diagnostics);
    }
}

}  // namespace zoned::config
