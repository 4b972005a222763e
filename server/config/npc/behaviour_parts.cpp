#include "server/config/npc/behaviour_parts.h"

#include "server/config/npc/blends.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/find_by_name.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <map>

namespace zoned::config {

namespace {

using ai::state_machine::StateMachineDefectKind;
using proto::config::Config;

void collect(const Config& config, int brain, BrainParts& parts) {
    if (brain < 0 || !parts.brains.insert(brain).second) {
        return;
    }
    for (const proto::config::State& state : config.brain(brain).state()) {
        if (state.has_brain()) {
            collect(config, find_brain(config, state.brain()), parts);
        }
        const int tree = state.has_tree() ? find_tree(config, state.tree()) : -1;
        const int domain = state.has_domain() ? find_domain(config, state.domain()) : -1;
        const int blend = state.has_blend() ? find_blend(config, state.blend()) : -1;
        if (blend >= 0) {
            parts.blends.insert(blend);
        }
        if (tree >= 0) {
            parts.trees.insert(tree);
        }
        if (domain >= 0) {
            parts.domains.insert(domain);
        }
    }
}

/// A transition between behaviours, and where in the file it comes from.
struct Crossing {
    proto::config::Transition transition;
    std::vector<std::string> origins;  ///< of its conditions
    bool spare = false;  ///< joins an end and a beginning: may go where it can never fire
};

void add_cue(const proto::config::Cue& cue, const std::string& path, Crossing& out) {
    for (int w = 0; w < cue.when_size(); ++w) {
        const proto::config::Condition& when = cue.when(w);
        if (out.origins.empty()) {
            out.transition.set_sensor(when.sensor());
            out.transition.set_compare(when.compare());
            out.transition.set_threshold(when.threshold());
            if (when.has_sense()) {
                out.transition.set_sense(when.sense());
            }
        } else {
            *out.transition.add_also() = when;
        }
        out.origins.push_back(join_path(path, "when", w));
    }
}

class Crossings {
  public:
    explicit Crossings(const std::vector<BrainLayer>& layers) : layers_(layers) {}

    /// Of layer `from`, in the order in which they are tried.
    std::vector<Crossing> of(std::size_t from) const {
        std::vector<Crossing> out;
        const bool last = from + 1 == layers_.size();
        for (std::size_t to = 0; to < from; ++to) {
            for (int b = 0; b < layers_[to].part.begins_size(); ++b) {
                out.push_back(begin(to, b));
            }
        }
        for (int e = 0; !last && e < layers_[from].part.ends_size(); ++e) {
            for (std::size_t to = from + 1; to + 1 < layers_.size(); ++to) {
                for (int b = 0; b < layers_[to].part.begins_size(); ++b) {
                    // One that must hold for a while begins out of the last layer.
                    if (layers_[to].part.begins(b).hold_s() == 0.0) {
                        Crossing crossing = end(from, e, to);
                        add_cue(layers_[to].part.begins(b), begins_path(to, b), crossing);
                        crossing.spare = true;
                        out.push_back(std::move(crossing));
                    }
                }
            }
        }
        for (int e = 0; !last && e < layers_[from].part.ends_size(); ++e) {
            out.push_back(end(from, e, layers_.size() - 1));
        }
        return out;
    }

  private:
    [[nodiscard]] std::string begins_path(std::size_t layer, int cue) const {
        return join_path(layers_[layer].path, "begins", cue);
    }

    [[nodiscard]] Crossing begin(std::size_t to, int cue) const {
        Crossing out;
        out.transition.set_to(layers_[to].part.name());
        out.transition.set_hold_s(layers_[to].part.begins(cue).hold_s());
        add_cue(layers_[to].part.begins(cue), begins_path(to, cue), out);
        return out;
    }

    [[nodiscard]] Crossing end(std::size_t from, int cue, std::size_t to) const {
        Crossing out;
        out.transition.set_to(layers_[to].part.name());
        out.transition.set_hold_s(layers_[from].part.ends(cue).hold_s());
        add_cue(layers_[from].part.ends(cue), join_path(layers_[from].path, "ends", cue), out);
        return out;
    }

    const std::vector<BrainLayer>& layers_;
};

/// A brain has far fewer transitions (state_machine::kMaxTransitions); beyond this number it is not
/// built at all.
constexpr std::size_t kMostCrossings = 1000;

/// Removes transitions that join an end and a beginning and can never fire, as
/// state_machine::defects_of finds in any brain.
void drop_spare(Config& config, int index, std::vector<std::vector<Crossing>>& crossings) {
    const auto write = [&] {
        for (std::size_t s = 0; s < crossings.size(); ++s) {
            proto::config::State& state =
                *config.mutable_brain(index)->mutable_state(static_cast<int>(s));
            state.clear_transition();
            for (const Crossing& crossing : crossings[s]) {
                *state.add_transition() = crossing.transition;
            }
        }
    };
    write();
    for (bool dropped = true; dropped;) {
        dropped = false;
        const ai::Brain brain = expand_brain(config, index);
        auto defects =
            ai::state_machine::defects_of(ai::state_machine_of(brain), ai::senses_of(brain));
        std::reverse(defects.begin(), defects.end());  // from behind, so that places stay
        for (const ai::state_machine::StateMachineDefect& defect : defects) {
            const bool idle = defect.kind == StateMachineDefectKind::kNeverTried ||
                              defect.kind == StateMachineDefectKind::kNeverHolds;
            if (!idle || defect.state.size() != 1 || defect.transition < 0) {
                continue;
            }
            std::vector<Crossing>& of = crossings[defect.state[0]];
            const auto at = static_cast<std::size_t>(defect.transition);
            if (at < of.size() && of[at].spare) {
                of.erase(of.begin() + defect.transition);
                dropped = true;
            }
        }
        write();
    }
}

}  // namespace

void BrainParts::for_each(const Config& config, const LookAtPart& work) const {
    for (const int b : brains) {
        work(config.brain(b), join_path("", "brain", b));
    }
    for (const int t : trees) {
        work(config.tree(t), join_path("", "tree", t));
    }
    for (const int d : domains) {
        work(config.domain(d), join_path("", "domain", d));
    }
    for (const int b : blends) {
        work(config.blend(b), join_path("", "blend", b));
    }
}

BrainParts parts_of(const Config& config, const std::string& brain) {
    BrainParts parts;
    collect(config, find_brain(config, brain), parts);
    return parts;
}

bool takes_parameters(const Config& config, const std::string& brain) {
    bool takes = false;
    parts_of(config, brain).for_each(config, [&](const auto& part, const std::string& path) {
        for_each_parameter(
            part, path, [&takes](const auto*, const std::string&, bool, const std::string&) {
                takes = true;
            });
    });
    return takes;
}

std::string copy_with_parameters(Config& config,
                                 const std::string& brain,
                                 const std::string& prefix,
                                 const ParameterValues& values,
                                 Diagnostics& diagnostics,
                                 const std::string& as) {
    if (!takes_parameters(config, brain)) {
        return brain;
    }
    const BrainParts parts = parts_of(config, brain);
    const auto origin = [&](const std::string& list, int made, int from) {
        diagnostics.set_origin(join_path("", list, made), join_path("", list, from), as);
    };
    for (const int t : parts.trees) {
        origin("tree", config.tree_size(), t);
        proto::config::Tree copy = config.tree(t);
        copy.set_name(prefix + copy.name());
        put_parameters(values, copy);
        *config.add_tree() = std::move(copy);
    }
    for (const int d : parts.domains) {
        origin("domain", config.domain_size(), d);
        proto::config::Domain copy = config.domain(d);
        copy.set_name(prefix + copy.name());
        put_parameters(values, copy);
        *config.add_domain() = std::move(copy);
    }
    for (const int b : parts.blends) {
        origin("blend", config.blend_size(), b);
        proto::config::Blend copy = config.blend(b);
        copy.set_name(prefix + copy.name());
        put_parameters(values, copy);
        *config.add_blend() = std::move(copy);
    }
    for (const int m : parts.brains) {
        origin("brain", config.brain_size(), m);
        proto::config::Brain copy = config.brain(m);
        copy.set_name(prefix + copy.name());
        put_parameters(values, copy);
        for (proto::config::State& state : *copy.mutable_state()) {
            // Names that mean nothing stay as they are, and are reported as such.
            if (state.has_brain() && find_brain(config, state.brain()) >= 0) {
                state.set_brain(prefix + state.brain());
            }
            if (state.has_tree() && find_tree(config, state.tree()) >= 0) {
                state.set_tree(prefix + state.tree());
            }
            if (state.has_blend() && find_blend(config, state.blend()) >= 0) {
                state.set_blend(prefix + state.blend());
            }
            if (state.has_domain() && find_domain(config, state.domain()) >= 0) {
                state.set_domain(prefix + state.domain());
            }
        }
        *config.add_brain() = std::move(copy);
    }
    return prefix + brain;
}

void add_transitions(Config& config,
                     int index,
                     const std::vector<BrainLayer>& layers,
                     Diagnostics& diagnostics,
                     const std::string& as) {
    for (std::size_t k = 0; k + 1 < layers.size(); ++k) {
        if (layers[k].part.begins_size() == 0) {
            diagnostics.add(layers[k].use_path,
                            "'" + layers[k].part.name() +
                                "' never begins: it has no `begins`, and is not the last");
        }
        if (layers[k].part.ends_size() == 0) {
            diagnostics.add(layers[k].use_path,
                            "'" + layers[k].part.name() +
                                "' never ends: it has no `ends`, and is not the last");
        }
        if (layers[k].part.begins_size() == 0 || layers[k].part.ends_size() == 0) {
            diagnostics.silence_line_of(layers[k].use_path);
        }
    }
    const Crossings all(layers);
    std::vector<std::vector<Crossing>> crossings;
    for (std::size_t s = 0; s < layers.size(); ++s) {
        crossings.push_back(all.of((s + layers.size() - 1) % layers.size()));
    }
    const bool many = std::any_of(crossings.begin(), crossings.end(), [](const auto& of) {
        return of.size() > kMostCrossings;
    });
    if (many) {
        diagnostics.add(join_path("", "brain", index),
                        "its behaviours have too many cues to tell which comes when");
        return;
    }
    drop_spare(config, index, crossings);
    for (std::size_t s = 0; s < crossings.size(); ++s) {
        const std::string state =
            join_path(join_path("", "brain", index), "state", static_cast<int>(s));
        diagnostics.set_origin(state, layers[(s + layers.size() - 1) % layers.size()].use_path, as);
        for (std::size_t t = 0; t < crossings[s].size(); ++t) {
            const std::string path = join_path(state, "transition", static_cast<int>(t));
            const auto& origins = crossings[s][t].origins;
            for (std::size_t c = 0; c < origins.size(); ++c) {
                diagnostics.set_origin(
                    c == 0 ? path : join_path(path, "also", static_cast<int>(c) - 1),
                    origins[c],
                    as);
            }
        }
    }
}

}  // namespace zoned::config
