#include "server/app/world/world_rules.h"

#include "server/app/log/log.h"
#include "server/scripting/script_rules.h"

#include <string>

namespace zoned::app {

std::unique_ptr<zone::Rules> make_world_rules(const config::Settings& settings,
                                              const world::TypeTable& types) {
    if (!settings.script) {
        return zone::make_rules(settings.rules, types);
    }
    const std::string name = settings.script->name;
    return std::make_unique<scripting::ScriptRules>(
        *settings.script,
        settings.rules,
        types,
        [name](scripting::ScriptLine kind, const std::string& line) {
            const bool is_error = kind == scripting::ScriptLine::kError;
            log_of(LogArea::kWorld)
                .log(is_error ? spdlog::level::err : spdlog::level::info, "{}: {}", name, line);
        });
}

}  // namespace zoned::app
