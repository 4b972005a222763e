#include "server/app/world/world_rules.h"

#include "server/app/log/log.h"
#include "server/scripting/script_rules.h"

#include <stdexcept>

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
