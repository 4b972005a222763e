#include "server/config/types/perceptions.h"

#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::config {

namespace {

using proto::config::Config;

int find_type(const Config& config, const std::string& name) {
    for (int t = 0; t < config.type_size(); ++t) {
        if (config.type(t).name() == name) {
            return t;
        }
    }
    return -1;
}

template <class Names>
std::vector<TypeIndex> expand_types(const Config& config, const Names& names) {
    std::vector<TypeIndex> out;
    for (const std::string& name : names) {
        const int type = find_type(config, name);
        if (type >= 0) {
            out.push_back(static_cast<TypeIndex>(type));
        }
    }
    return out;
}

bool any_does(const std::vector<ai::BrainState>& states, ai::ActionKind action) {
    return std::any_of(states.begin(), states.end(), [action](const ai::BrainState& state) {
        return (state.inside.empty() && state.action == action) || any_does(state.inside, action) ||
               any_does(state.actions, action);
    });
}

/// Whether any transition reads that sense.
bool any_reads(const std::vector<ai::BrainState>& states, ai::SenseIndex sense) {
    const auto reads = [sense](const ai::Transition& transition) {
        return transition.first().sense == sense ||
               std::any_of(transition.also.begin(),
                           transition.also.end(),
                           [sense](const ai::Condition& also) { return also.sense == sense; });
    };
    return std::any_of(states.begin(), states.end(), [&](const ai::BrainState& state) {
        return std::any_of(state.transitions.begin(), state.transitions.end(), reads) ||
               any_reads(state.inside, sense);
    });
}

}  // namespace

ai::Perception expand_perception(const Config& config, const proto::config::Brain& brain) {
    ai::Perception out;
    if (!brain.has_perception()) {
        return out;
    }
    const proto::config::Perception& from = brain.perception();
    out.given = true;
    out.players = from.players();
    out.targets = expand_types(config, from.target());
    out.allies = expand_types(config, from.ally());
    out.wards = expand_types(config, from.ward());
    out.ward_players = from.ward_players();
    out.succession = from.succession();
    // All round is exactly that, whatever the cosine is rounded to.
    out.cos_half_angle = from.half_angle_deg() >= 180.0
                             ? -1.0F
                             : narrow(elementary::cos(from.half_angle_deg() * kRadians));
    out.around_m = narrow(from.around_m());
    out.line_of_sight = from.line_of_sight();
    out.eyes_m = narrow(from.eyes_m());
    out.hearing_m = narrow(from.hearing_m());
    out.memory_s = narrow(from.memory_s());
    out.keeps_target = from.keeps_target();
    return out;
}

void check_perception(const Config& config,
                      const proto::config::Perception& perception,
                      const std::string& path,
                      Diagnostics& diagnostics) {
    const auto types = [&](const auto& names, const std::string& list) {
        for (int n = 0; n < names.size(); ++n) {
            if (find_type(config, names[n]) < 0) {
                diagnostics.add(join_path(path, list, n),
                                "there is no type named '" + names[n] + "'");
            }
        }
    };
    types(perception.target(), "target");
    types(perception.ally(), "ally");
    types(perception.ward(), "ward");
    if (!perception.players() && perception.target_size() == 0 &&
        (perception.memory_s() > 0.0 || perception.hearing_m() > 0.0 ||
         perception.line_of_sight())) {
        diagnostics.add(path, "looks for nobody: set `target`, or leave `players` on");
    }
}

void check_company(const ai::Brain& brain, const std::string& path, Diagnostics& diagnostics) {
    const bool wards = !brain.perception.wards.empty() || brain.perception.ward_players ||
                       brain.perception.succession;
    if (!wards && any_does(brain.states, ai::ActionKind::kEscort)) {
        diagnostics.add(
            path,
            "a state escorts, but `perception` has no `ward`, `ward_players` or `succession`");
    }
    if (!wards && any_does(brain.states, ai::ActionKind::kFormUp)) {
        diagnostics.add(
            path,
            "a state forms up, but `perception` has no `ward`, `ward_players` or `succession`");
    }
    if (!brain.perception.succession && any_reads(brain.states, ai::kSenseLeads)) {
        diagnostics.add(path, "a transition asks LEADS, but `perception.succession` is not set");
    }
}

}  // namespace zoned::config
