#include "server/config/npc/policies.h"

#include "server/config/npc/brain_config.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/text/sha256.h"
#include "server/config/training/policy_file.h"
#include "proto/config/config.pb.h"

#include <fstream>
#include <set>
#include <sstream>
#include <utility>

namespace zoned::config {

namespace {

using proto::config::Config;

ai::learning::Guard guard_of(const proto::config::Policy& from) {
    ai::learning::Guard guard;
    guard.max_speed = narrow(from.max_speed());
    guard.max_turn_radps = narrow(from.max_turn_degps() * kRadians);
    guard.max_home_m = narrow(from.max_home_m());
    guard.may_sprint = from.may_sprint();
    return guard;
}

std::shared_ptr<const ai::GuardedPolicy> load_policy(proto::config::Policy& from,
                                                     const std::string& path,
                                                     Diagnostics& diagnostics) {
    if (from.file().empty()) {
        diagnostics.add(path, "a policy needs a file: zoned train writes them");
        return nullptr;
    }
    std::ifstream in(from.file(), std::ios::binary);
    std::ostringstream text;
    if (in.good()) {
        text << in.rdbuf();
    }
    if (!in.good()) {
        diagnostics.add(path + ".file", from.file() + ": cannot be opened");
        return nullptr;
    }
    const std::string sha256 = sha256_hex(text.str());
    if (from.has_sha256() && from.sha256() != sha256) {
        diagnostics.add(path + ".sha256",
                        from.file() + " has another content than is asked for: its SHA-256 is " +
                            sha256 + ", not " + from.sha256());
        return nullptr;
    }
    auto policy = parse_policy(text.str());
    if (!policy) {
        diagnostics.add(path + ".file", from.file() + " " + policy.error());
        return nullptr;
    }
    from.set_sha256(sha256);
    return std::make_shared<const ai::GuardedPolicy>(
        ai::GuardedPolicy{std::move(*policy), guard_of(from)});
}

/// Gives states their policies; returns the first variable that `brain` lacks.
class PolicyGiver {
  public:
    PolicyGiver(const Policies& policies, const ai::Brain& brain)
        : policies_(policies),
          variables_(brain.variables) {}

    void give(std::vector<ai::BrainState>& states) {
        for (ai::BrainState& state : states) {
            if (auto* choice = std::get_if<ai::PolicyChoice>(&state.choice)) {
                if (choice->number < policies_.size() && policies_[choice->number] != nullptr) {
                    give(*choice);
                }
            }
            give(state.inside);
        }
    }

    /// Numbers of policies and of the missing variables that they read.
    std::set<std::pair<std::uint16_t, std::string>> lacking;

  private:
    void give(ai::PolicyChoice& choice) {
        choice.policy = policies_[choice.number];
        const auto& inputs = choice.policy->policy.inputs;
        choice.variable.assign(inputs.size(), 0);
        for (std::size_t k = 0; k < inputs.size(); ++k) {
            if (inputs[k].variable.empty()) {
                continue;
            }
            std::size_t v = 0;
            while (v < variables_.size() && variables_[v].name != inputs[k].variable) {
                ++v;
            }
            if (v == variables_.size()) {
                lacking.insert({choice.number, inputs[k].variable});
            } else {
                choice.variable[k] = static_cast<std::uint16_t>(v);
            }
        }
    }

    const Policies& policies_;
    const std::vector<ai::BrainVariable>& variables_;
};

}  // namespace

Policies load_policies(Config& config, Diagnostics& diagnostics) {
    Policies policies;
    std::set<std::string> names;
    for (int p = 0; p < config.policy_size(); ++p) {
        const std::string path = join_path("", "policy", p);
        proto::config::Policy& policy = *config.mutable_policy(p);
        if (check_name(policy.name(), "policy", path, diagnostics) &&
            !names.insert(policy.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + policy.name() + "' is the name of another policy");
        }
        policies.push_back(load_policy(policy, path, diagnostics));
    }
    return policies;
}

void give_policies(const Config& config,
                   const Policies& policies,
                   std::vector<ai::Brain>& brains,
                   Diagnostics& diagnostics) {
    for (ai::Brain& brain : brains) {
        if (brain.inner) {
            continue;
        }
        PolicyGiver giver(policies, brain);
        giver.give(brain.states);
        for (const auto& [number, variable] : giver.lacking) {
            diagnostics.add(join_path("", "policy", number),
                            "'" + config.policy(number).name() + "' reads the variable '" +
                                variable + "', which agents of brain '" + brain.name +
                                "' do not have");
        }
    }
}

}  // namespace zoned::config
