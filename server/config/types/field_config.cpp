#include "server/config/types/field_config.h"

#include "server/config/text/check_name.h"
#include "server/config/types/deformation_config.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::config {

namespace {

using proto::config::DeclaredField;

/// Steps of a number's range; rounding errors of decimal fractions are no part of them.
double steps_of(const proto::config::NumberField& number) {
    return (number.max() - number.min()) / number.quantum();
}

bool is_integer(double steps) {
    return std::abs(steps - std::round(steps)) < 1e-6 * std::max(1.0, std::abs(steps));
}

wire::DeclaredField expand_field(const DeclaredField& from, double tick_rate_hz) {
    wire::DeclaredField out;
    out.name = from.name();
    if (from.max_changes_per_s() > 0.0) {
        out.interval = static_cast<Tick>(std::ceil(tick_rate_hz / from.max_changes_per_s() - 1e-6));
    }
    switch (from.kind_case()) {
        case DeclaredField::kNumber:
        case DeclaredField::KIND_NOT_SET:
            out.kind = wire::DeclaredKind::kNumber;
            out.minimum = from.number().min();
            out.quantum = from.number().quantum();
            out.most = static_cast<std::uint32_t>(
                std::clamp(std::round(steps_of(from.number())), 0.0, 4e9));
            break;
        case DeclaredField::kChoice:
            out.kind = wire::DeclaredKind::kEnum;
            out.values.assign(from.choice().value().begin(), from.choice().value().end());
            break;
        case DeclaredField::kFlag:
            out.kind = wire::DeclaredKind::kBool;
            out.initial[0] = from.flag().initial() ? 1 : 0;
            break;
        case DeclaredField::kText:
            out.kind = wire::DeclaredKind::kText;
            break;
    }
    return out;
}

/// The initial value of a field, where it is one that the field can have.
wire::FieldOutcome put_initial(const DeclaredField& from, wire::DeclaredField& field) {
    const std::span<std::uint32_t> words(field.initial);
    switch (field.kind) {
        case wire::DeclaredKind::kNumber:
            return wire::put_value(
                field,
                from.number().has_initial() ? from.number().initial() : from.number().min(),
                words);
        case wire::DeclaredKind::kEnum:
            return from.choice().has_initial()
                       ? wire::put_value(field, std::string_view(from.choice().initial()), words)
                       : wire::FieldOutcome::kDone;
        case wire::DeclaredKind::kBool:
            return wire::FieldOutcome::kDone;
        case wire::DeclaredKind::kText:
            break;
    }
    return wire::put_value(field, std::string_view(from.text().initial()), words);
}

void check_number(const proto::config::NumberField& number,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    if (number.max() <= number.min()) {
        diagnostics.add(path + ".max",
                        text_of("%g is not above the least value, %g", number.max(), number.min()));
        return;
    }
    const double steps = steps_of(number);
    if (steps > wire::kMostFieldSteps) {
        diagnostics.add(path + ".quantum",
                        text_of("%g makes %.0f steps of the range, at most 16777215 can be sent",
                                number.quantum(),
                                steps));
    } else if (!is_integer(steps) || steps < 0.5) {
        diagnostics.add(path + ".quantum",
                        text_of("%g does not divide the range from %g to %g into whole steps",
                                number.quantum(),
                                number.min(),
                                number.max()));
    }
}

void check_choice(const proto::config::ChoiceField& choice,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    if (choice.value_size() < 2 || choice.value_size() > static_cast<int>(wire::kMostEnumValues)) {
        diagnostics.add(path, "a choice has 2 to 256 values");
        return;
    }
    for (int v = 0; v < choice.value_size(); ++v) {
        const std::string here = join_path(path, "value", v);
        const std::string& name = choice.value(v);
        if (std::find(choice.value().begin(), choice.value().begin() + v, name) !=
            choice.value().begin() + v) {
            diagnostics.add(here, "'" + name + "' is another value of this choice");
        }
    }
}

void check_initial(const DeclaredField& from, const std::string& path, Diagnostics& diagnostics) {
    wire::DeclaredField field = expand_field(from, 1.0);
    if (field.kind == wire::DeclaredKind::kEnum && field.values.empty()) {
        return;
    }
    if (put_initial(from, field) == wire::FieldOutcome::kDone) {
        return;
    }
    switch (field.kind) {
        case wire::DeclaredKind::kNumber:
            diagnostics.add(path + ".number.initial",
                            text_of("%g is outside the range from %g to %g",
                                    from.number().initial(),
                                    from.number().min(),
                                    from.number().max()));
            break;
        case wire::DeclaredKind::kEnum:
            diagnostics.add(path + ".choice.initial",
                            "there is no value '" + from.choice().initial() + "'");
            break;
        case wire::DeclaredKind::kBool:
            break;
        case wire::DeclaredKind::kText:
            diagnostics.add(path + ".text.initial",
                            "a text has at most 31 bytes of UTF-8 without control characters");
            break;
    }
}

/// Too many fields are found by the range of the list.
void check_words(const proto::config::Type& type,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    const std::size_t words = words_of_fields(type);
    if (words > wire::kMostFieldWords) {
        diagnostics.add(
            path + ".field",
            text_of("the fields have %.0f words, at most 128 can be sent: a text has 8, "
                    "others have 1",
                    static_cast<double>(words)));
    }
}

}  // namespace

std::size_t words_of_fields(const proto::config::Type& type) {
    std::size_t words = 0;
    for (const DeclaredField& field : type.field()) {
        words += field.has_text() ? wire::kTextWords : 1;
    }
    return words;
}

void check_fields(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::map<wire::FieldId, std::string> ids;
    for (int t = 0; t < config.type_size(); ++t) {
        const auto& type = config.type(t);
        std::map<std::string, int> names;
        for (int f = 0; f < type.field_size(); ++f) {
            const DeclaredField& field = type.field(f);
            const std::string path = join_path(join_path("", "type", t), "field", f);
            if (!check_name(field.name(), "field", path, diagnostics)) {
                continue;
            }
            if (!names.emplace(field.name(), f).second) {
                diagnostics.add(path + ".name",
                                "'" + field.name() + "' is the name of another field of this type");
            }
            const auto [id, fresh] = ids.emplace(wire::field_id(field.name()), field.name());
            if (!fresh && id->second != field.name()) {
                diagnostics.add(path + ".name",
                                "'" + field.name() + "' and '" + id->second +
                                    "' have the same number by chance: rename one of them");
            }
            const std::size_t before = diagnostics.size();
            if (field.kind_case() == DeclaredField::KIND_NOT_SET) {
                diagnostics.add(path,
                                "a field needs its kind: number, choice, flag or text { ... }");
            } else if (field.has_number()) {
                check_number(field.number(), path + ".number", diagnostics);
            } else if (field.has_choice()) {
                check_choice(field.choice(), path + ".choice", diagnostics);
            }
            if (diagnostics.size() == before) {
                check_initial(field, path, diagnostics);
            }
        }
        check_words(type, join_path("", "type", t), diagnostics);
    }
}

void check_levers(const proto::config::Config& config, Diagnostics& diagnostics) {
    for (int t = 0; t < config.type_size(); ++t) {
        const auto& type = config.type(t);
        if (!type.has_lever()) {
            continue;
        }
        const std::string path = join_path("", "type", t) + ".lever";
        const std::string& name = type.lever().field();
        const bool declared =
            std::any_of(type.field().begin(), type.field().end(), [&](const DeclaredField& field) {
                return field.name() == name && field.has_flag();
            });
        if (!declared) {
            diagnostics.add(path + ".field",
                            "'" + name + "' is no flag among the fields of the type");
        }
        if (type.has_assembly()) {
            diagnostics.add(path, "a type of several bodies is no lever");
        }
    }
}

std::optional<world::Lever> expand_lever(const proto::config::Type& type) {
    if (!type.has_lever()) {
        return std::nullopt;
    }
    const auto& from = type.lever();
    return world::Lever{static_cast<float>(from.reach_m()),
                        static_cast<std::uint16_t>(1U << from.button()),
                        wire::field_id(from.field())};
}

void expand_fields(const proto::config::Config& config,
                   const proto::config::Type& type,
                   world::EntityType& out) {
    std::vector<wire::DeclaredField> fields;
    for (const DeclaredField& from : type.field()) {
        wire::DeclaredField& field =
            fields.emplace_back(expand_field(from, config.world().tick_rate_hz()));
        if (field.kind == wire::DeclaredKind::kEnum) {
            field.most = static_cast<std::uint32_t>(field.values.size() - 1);
        }
        put_initial(from, field);
    }
    add_deformation_fields(type, out, fields);
    if (!fields.empty()) {
        const auto made = wire::FieldSchema::make(std::move(fields));
        out.fields = made ? *made : nullptr;
    }
}

}  // namespace zoned::config
