#include "server/app/world/world_rules.h"

#include "server/app/log/log.h"
#include "server/scripting/script_rules.h"

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

scripting::ScriptLog script_log(const std::string& name) {
    return [name](scripting::ScriptLine kind, const std::string& line) {
        const bool is_error = kind == scripting::ScriptLine::kError;
        log_of(LogArea::kWorld)
            .log(is_error ? spdlog::level::err : spdlog::level::info, "{}: {}", name, line);
    };
}

}  // namespace zoned::app
