#include "server/app/world/world_rules.h"

#include "server/app/log/log.h"
#include "server/config/world/world_description.h"
#include "server/scripting/script_rules.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

namespace zoned::app {

std::unique_ptr<zone::Rules> make_world_rules(
    const std::optional<scripting::ScriptSettings>& script,
    const zone::RulesSettings& settings,
    const world::TypeTable& types) {
    if (!script) {
        return zone::make_rules(settings, types);
    }
    return std::make_unique<scripting::ScriptRules>(
        *script, settings, types, script_log(script->name));
}

namespace {

/// Names of one number by chance could not be told apart.
void check_names(const world::TypeTable& types) {
    std::map<wire::FieldId, std::string> names;
    for (const world::EntityType& type : types) {
        for (std::size_t f = 0; type.fields && f < type.fields->fields().size(); ++f) {
            const wire::DeclaredField& field = type.fields->fields()[f];
            const auto [at, fresh] = names.emplace(field.id, field.name);
            if (!fresh && at->second != field.name) {
                throw std::runtime_error("fields '" + field.name + "' and '" + at->second +
                                         "' have the same number by chance: rename one of them");
            }
        }
    }
}

wire::DeclaredField with_interval(const zone::TypeField& declared, double tick_rate_hz) {
    wire::DeclaredField field = declared.field;
    if (declared.max_changes_per_s > 0.0) {
        field.interval =
            static_cast<Tick>(std::ceil(tick_rate_hz / declared.max_changes_per_s - 1e-6));
    }
    return field;
}

}  // namespace

void declare_fields(config::Settings& settings) {
    const std::vector<zone::TypeField> declared =
        make_world_rules(settings.script, settings.rules, settings.types)->declared_fields();
    for (const zone::TypeField& one : declared) {
        const bool known = std::any_of(settings.types.begin(),
                                       settings.types.end(),
                                       [&](const auto& type) { return type.name == one.type; });
        if (!known) {
            throw std::runtime_error("field '" + one.field.name + "' is declared for '" + one.type +
                                     "', a type that there is not");
        }
    }
    for (world::EntityType& type : settings.types) {
        std::vector<wire::DeclaredField> fields;
        if (type.fields) {
            fields.assign(type.fields->fields().begin(), type.fields->fields().end());
        }
        const std::size_t before = fields.size();
        for (const zone::TypeField& one : declared) {
            if (one.type == type.name) {
                fields.push_back(with_interval(one, settings.tick_rate_hz));
            }
        }
        if (fields.size() == before) {
            continue;
        }
        auto made = wire::FieldSchema::make(std::move(fields));
        if (!made.ok()) {
            throw std::runtime_error("type '" + type.name + "': " + made.error());
        }
        type.fields = *made;
    }
    if (!declared.empty()) {
        check_names(settings.types);
        settings.digest = config::world_digest(settings);
    }
}

void try_world_rules(const config::Settings& settings) {
    const std::unique_ptr<zone::Rules> rules =
        make_world_rules(settings.script, settings.rules, settings.types);
    ai::AiSettings agents = settings.ai;
    const std::string wrong = ai::bind_code(agents, rules->coded_machines());
    if (!wrong.empty()) {
        throw std::runtime_error(wrong);
    }
}

scripting::ScriptLog script_log(const std::string& name) {
    return [name](scripting::ScriptLine kind, const std::string& line) {
        const bool is_error = kind == scripting::ScriptLine::kError;
        log_of(LogArea::kWorld)
            .log(is_error ? spdlog::level::err : spdlog::level::info, "{}: {}", name, line);
    };
}

}  // namespace zoned::app
