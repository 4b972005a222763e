#include "server/config/npc/behaviours.h"

#include "server/config/npc/behaviour_parts.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/npc/parameters.h"
#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/types/type_families.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using proto::config::Config;

/// Copies included.
constexpr int kMostBrains = 20000;

int find_part(const Config& config, const std::string& name) {
    for (int b = 0; b < config.behaviour_size(); ++b) {
        if (config.behaviour(b).name() == name) {
            return b;
        }
    }
    return -1;
}

/// Every setting with a parameter gets one within its range, and every parameter is used.
class PartsCheck {
  public:
    PartsCheck(const Config& config, Diagnostics& diagnostics)
        : config_(config),
          diagnostics_(diagnostics) {}

    void run() {
        std::set<std::string> names;
        for (int b = 0; b < config_.behaviour_size(); ++b) {
            const std::string path = join_path("", "behaviour", b);
            const proto::config::Behaviour& part = config_.behaviour(b);
            if (check_name(part.name(), "behaviour", path, diagnostics_) &&
                !names.insert(part.name()).second) {
                diagnostics_.add(path + ".name",
                                 "'" + part.name() + "' is the name of another behaviour");
            }
            if (find_brain(config_, part.brain()) < 0) {
                diagnostics_.add(path + (part.has_brain() ? ".brain" : ""),
                                 part.has_brain() ? "there is no brain named '" + part.brain() + "'"
                                                  : "a behaviour needs a `brain`");
                continue;
            }
            parameters(part, path);
        }
        strays();
    }

  private:
    void parameters(const proto::config::Behaviour& part, const std::string& path) {
        std::set<std::string> used;
        const LookAtParameter look = [&](const FieldDescriptor* number,
                                         const std::string& name,
                                         bool twice,
                                         const std::string& here) {
            if (twice) {
                diagnostics_.add(here, "takes either `" + number->name() + "` or a parameter");
            }
            used.insert(name);
            for (int p = 0; p < part.parameter_size(); ++p) {
                if (part.parameter(p).name() == name) {
                    bears(*number, part.parameter(p), join_path(path, "parameter", p));
                    return;
                }
            }
            diagnostics_.add(
                here, "behaviour '" + part.name() + "' has no parameter named '" + name + "'");
        };
        const BrainParts parts = parts_of(config_, part.brain());
        in_parts_.merge(parts);
        parts.for_each(config_, [&look](const auto& of, const std::string& at) {
            for_each_parameter(of, at, look);
        });
        for_each_parameter(part, path, look);
        for (int p = 0; p < part.parameter_size(); ++p) {
            if (used.count(part.parameter(p).name()) == 0) {
                diagnostics_.add(join_path(path, "parameter", p),
                                 "no setting takes it: name it in one that ends in _from");
            }
        }
    }

    void bears(const FieldDescriptor& number,
               const proto::config::Parameter& parameter,
               const std::string& path) {
        const proto::FieldRange& range = number.options().GetExtension(proto::range);
        if (parameter.low() < range.min() || parameter.high() > range.max()) {
            diagnostics_.add(path,
                             text_of("its bounds are %g to %g, but it stands for ",
                                     parameter.low(),
                                     parameter.high()) +
                                 number.name() +
                                 text_of(", which lies in [%g..%g]", range.min(), range.max()));
        }
    }

    /// Reports parameters where no type could set them.
    void strays() {
        const auto stray = [this](const FieldDescriptor* /*number*/,
                                  const std::string& name,
                                  bool /*twice*/,
                                  const std::string& here) {
            diagnostics_.add(
                here, "'" + name + "' is the parameter of a behaviour; this is part of none");
        };
        BrainParts others;
        const auto rest = [](int count, const std::set<int>& known, std::set<int>& out) {
            for (int i = 0; i < count; ++i) {
                if (known.count(i) == 0) {
                    out.insert(i);
                }
            }
        };
        rest(config_.brain_size(), in_parts_.brains, others.brains);
        rest(config_.tree_size(), in_parts_.trees, others.trees);
        rest(config_.domain_size(), in_parts_.domains, others.domains);
        rest(config_.blend_size(), in_parts_.blends, others.blends);
        others.for_each(config_, [&stray](const auto& of, const std::string& at) {
            for_each_parameter(of, at, stray);
        });
        for (int t = 0; t < config_.type_size(); ++t) {
            const std::string& brain = config_.type(t).brain();
            if (find_brain(config_, brain) >= 0 && takes_parameters(config_, brain)) {
                diagnostics_.add(
                    join_path("", "type", t) + ".brain",
                    "brain '" + brain + "' takes parameters: the type needs the behaviour");
            }
        }
    }

    const Config& config_;
    Diagnostics& diagnostics_;
    BrainParts in_parts_;
};

/// The brain of one type.
class BrainOfType {
  public:
    BrainOfType(Config& config,
                const std::string& type,
                const std::string& path,
                const std::string& as,
                Diagnostics& diagnostics)
        : config_(config),
          type_(type),
          path_(path),
          as_(as),
          diagnostics_(diagnostics) {}

    /// Appends the brain; its name, empty where something is missing.
    std::string build(const std::vector<BehaviourUse>& uses,
                      std::vector<ParameterChoice>& choices) {
        for (const BehaviourUse& use : uses) {
            add(use, choices);
        }
        if (broken_) {
            return {};
        }
        proto::config::Brain brain;
        brain.set_name(type_ + ".brain");
        perceive(brain);
        merge_variables(uses, brain);
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            // It starts with the last: the one that needs no cue.
            const BrainLayer& layer = layers_[(k + layers_.size() - 1) % layers_.size()];
            proto::config::State* state = brain.add_state();
            state->set_name(layer.part.name());
            state->set_brain(layer.part.brain());
            if (layer.remembers) {
                state->set_history(layer.part.history());
            }
        }
        const std::string name = brain.name();
        const int index = config_.brain_size();
        *config_.add_brain() = std::move(brain);
        diagnostics_.set_origin(join_path("", "brain", index), path_, as_);
        for (const BrainLayer& layer : layers_) {
            const int of = find_brain(config_, layer.part.brain());
            if (config_.brain(of).has_perception()) {
                diagnostics_.set_origin(join_path("", "brain", index) + ".perception",
                                        join_path("", "brain", of) + ".perception",
                                        as_);
                break;
            }
        }
        add_transitions(config_, index, layers_, diagnostics_, as_);
        return name;
    }

  private:
    void add(const BehaviourUse& use, std::vector<ParameterChoice>& choices) {
        const int index = find_part(config_, use.name);
        if (index < 0 || find_brain(config_, config_.behaviour(index).brain()) < 0) {
            broken_ = true;
            if (index < 0) {
                diagnostics_.add(use.path + ".name",
                                 "there is no behaviour named '" + use.name + "'");
            }
            return;
        }
        const std::size_t before = choices.size();
        const ParameterValues values = values_of(config_, index, type_, use, choices, diagnostics_);
        if (choices.size() == before) {
            choices.push_back({type_, use.name, {}, 0.0, {}});
        }
        BrainLayer layer;
        layer.part = config_.behaviour(index);
        layer.path = join_path("", "behaviour", index);
        layer.use_path = use.path;
        put_parameters(values, layer.part);
        const proto::config::Brain& first = config_.brain(find_brain(config_, layer.part.brain()));
        layer.remembers =
            first.state_size() > 1 || (first.state_size() > 0 && first.state(0).has_brain());
        layer.part.set_brain(copy_with_parameters(
            config_, layer.part.brain(), type_ + "." + use.name + ".", values, diagnostics_, as_));
        layers_.push_back(std::move(layer));
    }

    void perceive(proto::config::Brain& brain) const {
        double perception = 0.0;
        double period = 60.0;
        for (const BrainLayer& layer : layers_) {
            const proto::config::Brain& of = config_.brain(find_brain(config_, layer.part.brain()));
            perception = std::max(perception, of.perception_m());
            period = std::min(period, of.decide_every_s());
            if (of.has_perception() && !brain.has_perception()) {
                *brain.mutable_perception() = of.perception();
            }
        }
        brain.set_perception_m(perception);
        brain.set_decide_every_s(period);
    }

    void merge_variables(const std::vector<BehaviourUse>& uses, proto::config::Brain& brain) {
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            const proto::config::Brain& of =
                config_.brain(find_brain(config_, layers_[k].part.brain()));
            for (const proto::config::Variable& variable : of.variable()) {
                const int known = find_variable(brain, variable.name());
                if (known < 0) {
                    *brain.add_variable() = variable;
                } else if (brain.variable(known).SerializeAsString() !=
                           variable.SerializeAsString()) {
                    diagnostics_.add(uses[k].path,
                                     "its variable '" + variable.name() +
                                         "' is another in a behaviour before it: variables of "
                                         "one name are one, and must be written alike");
                }
            }
        }
        if (brain.variable_size() > static_cast<int>(ai::kMaxVariables)) {
            diagnostics_.add(path_,
                             text_of("its behaviours have %g variables together, at most %g",
                                     brain.variable_size(),
                                     static_cast<double>(ai::kMaxVariables)));
        }
    }

    Config& config_;
    std::string type_;
    std::string path_;
    std::string as_;
    Diagnostics& diagnostics_;
    std::vector<BrainLayer> layers_;
    bool broken_ = false;
};

/// A type's perception replaces its brain's perception.
void perceive_as_type(Config& config, int type, Diagnostics& diagnostics) {
    const proto::config::Type& of = config.type(type);
    const int brain = find_brain(config, of.brain());
    if (!of.has_perception()) {
        return;
    }
    const std::string path = join_path("", "type", type);
    if (brain < 0) {
        diagnostics.add(path + ".perception", "needs an agent: `brain` or `behaviour`");
        return;
    }
    int own = brain;
    if (of.brain() != of.name() + ".brain") {
        own = config.brain_size();
        proto::config::Brain copy = config.brain(brain);
        copy.set_name(of.name() + ".brain");
        config.mutable_type(type)->set_brain(copy.name());
        *config.add_brain() = std::move(copy);
        diagnostics.set_origin(join_path("", "brain", own),
                               join_path("", "brain", brain),
                               "in type '" + of.name() + "'");
    }
    *config.mutable_brain(own)->mutable_perception() = of.perception();
    diagnostics.set_origin(join_path("", "brain", own) + ".perception", path + ".perception", "");
}

}  // namespace

std::vector<ParameterChoice> build_behaviours(Config& config, Diagnostics& diagnostics) {
    std::vector<ParameterChoice> choices;
    const BehaviourUses uses = resolve_types(config, diagnostics);
    check_parameters(config, diagnostics);
    PartsCheck(config, diagnostics).run();
    std::set<std::string> used;
    for (int t = 0; t < config.type_size(); ++t) {
        const auto& of = uses[static_cast<std::size_t>(t)];
        for (const BehaviourUse& use : of) {
            used.insert(use.name);
        }
        if (config.brain_size() > kMostBrains) {
            diagnostics.add(join_path("", "type", t),
                            "the types so far need too many copies of brains with parameters");
            return choices;
        }
        if (!of.empty()) {
            const std::string brain = BrainOfType(config,
                                                  config.type(t).name(),
                                                  join_path("", "type", t),
                                                  "in type '" + config.type(t).name() + "'",
                                                  diagnostics)
                                          .build(of, choices);
            if (!brain.empty()) {
                config.mutable_type(t)->set_brain(brain);
            }
        }
        perceive_as_type(config, t, diagnostics);
    }
    // A behaviour that no type has is checked by itself.
    std::vector<ParameterChoice> unused;
    for (int b = 0; b < config.behaviour_size(); ++b) {
        const std::string name = config.behaviour(b).name();
        if (used.count(name) == 0) {
            const std::string path = join_path("", "behaviour", b);
            BrainOfType(config, "behaviour." + name, path, "no type has it", diagnostics)
                .build({{name, path, {}}}, unused);
        }
    }
    return choices;
}

}  // namespace zoned::config
