#include "server/config/npc/parameters.h"

#include "server/config/npc/difficulty_names.h"
#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using proto::config::Config;

constexpr std::string_view kFrom = "_from";

/// The setting that `field` is the companion of: null where its name does not end in _from.
const FieldDescriptor* number_beside(const FieldDescriptor& field) {
    const std::string& name = field.name();
    const bool companion = name.size() > kFrom.size() && !field.is_repeated() &&
                           field.cpp_type() == FieldDescriptor::CPPTYPE_STRING &&
                           name.compare(name.size() - kFrom.size(), kFrom.size(), kFrom) == 0;
    return companion ? field.containing_type()->FindFieldByName(
                           name.substr(0, name.size() - kFrom.size()))
                     : nullptr;
}

/// Calls `work(message, path)` for all messages within, the outermost last.
template <class AnyMessage, class Work>
void within(AnyMessage& message, const std::string& path, const Work& work) {
    const Reflection& r = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    r.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
        if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
            continue;
        }
        const int count = field->is_repeated() ? r.FieldSize(message, field) : 1;
        for (int i = 0; i < count; ++i) {
            const std::string here = join_path(path, field->name(), field->is_repeated() ? i : -1);
            if constexpr (std::is_const_v<AnyMessage>) {
                within(field->is_repeated() ? r.GetRepeatedMessage(message, field, i)
                                            : r.GetMessage(message, field),
                       here,
                       work);
            } else {
                within(field->is_repeated() ? *r.MutableRepeatedMessage(&message, field, i)
                                            : *r.MutableMessage(&message, field),
                       here,
                       work);
            }
        }
    }
    work(message, path);
}

const proto::config::Parameter* find_parameter(const proto::config::Behaviour& behaviour,
                                               const std::string& name) {
    const auto& all = behaviour.parameter();
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name() == name; });
    return at == all.end() ? nullptr : &*at;
}

const proto::config::Difficulty* chosen_difficulty(const Config& config) {
    const std::string name = first_difficulty(config);
    for (const proto::config::Difficulty& difficulty : config.difficulty()) {
        if (!name.empty() && difficulty.name() == name) {
            return &difficulty;
        }
    }
    return nullptr;
}

void check_set(const Config& config,
               const proto::config::DifficultySet& set,
               const std::string& path,
               Diagnostics& diagnostics) {
    if (set.has_value() == set.has_factor()) {
        diagnostics.add(path, "takes either `value` or `factor`");
    }
    const auto named = [](const auto& list, const std::string& name) {
        return std::any_of(
            list.begin(), list.end(), [&](const auto& of) { return of.name() == name; });
    };
    if (set.has_type() && !named(config.type(), set.type())) {
        diagnostics.add(path + ".type", "there is no type named '" + set.type() + "'");
    }
    if (set.has_behaviour() && !named(config.behaviour(), set.behaviour())) {
        diagnostics.add(path + ".behaviour",
                        "there is no behaviour named '" + set.behaviour() + "'");
        return;
    }
    const bool known =
        std::any_of(config.behaviour().begin(),
                    config.behaviour().end(),
                    [&](const proto::config::Behaviour& of) {
                        return (!set.has_behaviour() || set.behaviour() == of.name()) &&
                               find_parameter(of, set.name()) != nullptr;
                    });
    if (!known) {
        diagnostics.add(path,
                        (set.has_behaviour() ? "behaviour '" + set.behaviour() + "' has"
                                             : std::string("no behaviour has")) +
                            (set.has_behaviour() ? " no" : " a") + " parameter named '" +
                            set.name() + "'");
    }
}

}  // namespace

void for_each_parameter(const Message& message,
                        const std::string& path,
                        const LookAtParameter& look) {
    within(message, path, [&look](const Message& in, const std::string& here) {
        const Reflection& r = *in.GetReflection();
        const Descriptor& descriptor = *in.GetDescriptor();
        for (int f = 0; f < descriptor.field_count(); ++f) {
            const FieldDescriptor& field = *descriptor.field(f);
            const FieldDescriptor* number = number_beside(field);
            if (number != nullptr && r.HasField(in, &field)) {
                look(number,
                     r.GetString(in, &field),
                     r.HasField(in, number),
                     join_path(here, field.name()));
            }
        }
    });
}

void put_parameters(const ParameterValues& values, Message& message) {
    within(message, "", [&values](Message& in, const std::string& /*path*/) {
        const Reflection& r = *in.GetReflection();
        const Descriptor& descriptor = *in.GetDescriptor();
        for (int f = 0; f < descriptor.field_count(); ++f) {
            const FieldDescriptor& field = *descriptor.field(f);
            const FieldDescriptor* number = number_beside(field);
            if (number == nullptr || !r.HasField(in, &field)) {
                continue;
            }
            const auto value = values.find(r.GetString(in, &field));
            if (value != values.end()) {
                r.SetDouble(&in, number, value->second);
                r.ClearField(&in, &field);
            }
        }
    });
}

void check_parameters(const Config& config, Diagnostics& diagnostics) {
    for (int b = 0; b < config.behaviour_size(); ++b) {
        std::set<std::string> names;
        for (int p = 0; p < config.behaviour(b).parameter_size(); ++p) {
            const proto::config::Parameter& parameter = config.behaviour(b).parameter(p);
            const std::string path = join_path(join_path("", "behaviour", b), "parameter", p);
            if (check_name(parameter.name(), "parameter", path, diagnostics) &&
                !names.insert(parameter.name()).second) {
                diagnostics.add(path + ".name",
                                "'" + parameter.name() + "' is the name of another parameter");
            }
            if (!(parameter.high() > parameter.low())) {
                diagnostics.add(path, "high must be above low");
            } else if (parameter.value() < parameter.low() ||
                       parameter.value() > parameter.high()) {
                diagnostics.add(path, "its value lies outside of low to high");
            }
        }
    }
    std::set<std::string> names;
    for (int d = 0; d < config.difficulty_size(); ++d) {
        const proto::config::Difficulty& difficulty = config.difficulty(d);
        const std::string path = join_path("", "difficulty", d);
        if (check_name(difficulty.name(), "difficulty", path, diagnostics) &&
            !names.insert(difficulty.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + difficulty.name() + "' is the name of another difficulty");
        }
        for (int s = 0; s < difficulty.set_size(); ++s) {
            check_set(config, difficulty.set(s), join_path(path, "set", s), diagnostics);
        }
    }
    if (config.ai().has_difficulty() && chosen_difficulty(config) == nullptr) {
        diagnostics.add("ai.difficulty",
                        "there is no difficulty named '" + config.ai().difficulty() + "'");
    }
    check_adaptation(config, diagnostics);
}

ParameterValues values_of(const Config& config,
                          int index,
                          const std::string& type,
                          const BehaviourUse& use,
                          std::vector<ParameterChoice>& choices,
                          Diagnostics& diagnostics) {
    const proto::config::Behaviour& behaviour = config.behaviour(index);
    for (const auto& [name, value] : use.set) {
        const proto::config::Parameter* parameter = find_parameter(behaviour, name);
        if (parameter == nullptr) {
            diagnostics.add(value.path + ".name",
                            "behaviour '" + use.name + "' has no parameter named '" + name + "'");
        } else if (value.value < parameter->low() || value.value > parameter->high()) {
            diagnostics.add(value.path + ".value",
                            text_of("%g lies outside of %g to %g, the parameter's bounds",
                                    value.value,
                                    parameter->low(),
                                    parameter->high()));
        }
    }
    ParameterValues values;
    for (const proto::config::Parameter& parameter : behaviour.parameter()) {
        ParameterChoice choice{
            type, use.name, parameter.name(), parameter.value(), "as the behaviour says"};
        const auto set = use.set.find(parameter.name());
        if (set != use.set.end()) {
            choice.value = set->second.value;
            choice.reason = "as type " + set->second.type + " says";
        }
        const proto::config::Difficulty* difficulty = chosen_difficulty(config);
        for (int s = 0; difficulty != nullptr && s < difficulty->set_size(); ++s) {
            const proto::config::DifficultySet& of = difficulty->set(s);
            if (of.name() != parameter.name() || (of.has_type() && of.type() != type) ||
                (of.has_behaviour() && of.behaviour() != use.name)) {
                continue;
            }
            const double wanted = of.has_value() ? of.value() : choice.value * of.factor();
            // Bounds in the wrong order were reported, and nobody uses the value.
            choice.value = std::max(parameter.low(), std::min(wanted, parameter.high()));
            choice.reason = "difficulty " + difficulty->name() +
                            (choice.value == wanted ? "" : ", at the bound of the parameter");
        }
        values[parameter.name()] = choice.value;
        choices.push_back(std::move(choice));
    }
    return values;
}

std::string parameters_text(const Settings& settings) {
    std::string text;
    std::string type;
    std::string behaviour;
    for (const ParameterChoice& choice : settings.parameters) {
        if (choice.type != type) {
            text += "type " + choice.type + "\n";
            type = choice.type;
            behaviour.clear();
        }
        if (choice.behaviour != behaviour) {
            text += "  behaviour " + choice.behaviour + "\n";
            behaviour = choice.behaviour;
        }
        if (!choice.parameter.empty()) {
            text += "    " + choice.parameter + text_of(" %g", choice.value) + "  " +
                    choice.reason + "\n";
        }
    }
    if (!text.empty()) {
        const std::string first = first_difficulty(*settings.config);
        text = "behaviours of types, what takes precedence first (difficulty: " +
               (first.empty() ? std::string("none") : first) +
               (settings.config->ai().has_adaptation() ? ", to begin with" : "") + ")\n" + text;
    }
    return text;
}

}  // namespace zoned::config
