// A script that was read anew takes over between two ticks.
#include "server/app/log/log.h"
#include "server/app/world/world.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/script_config.h"
#include "server/scripting/script_rules.h"

#include <utility>

namespace zoned::app {

/// It compiles: that was found out before the order for it was recorded. A zone whose state it
/// cannot take over keeps the old one, in a replay too.
void World::reload_scripts(const std::string& config_text) {
    std::optional<scripting::ScriptSettings> fresh = config::script_of(config_text);
    if (!script_ || !fresh || *fresh == *script_) {
        return;
    }
    script_ = std::move(fresh);
    for (zone::ZoneState* state : states_) {
        const auto* before = dynamic_cast<const scripting::ScriptRules*>(state->rules.get());
        if (before == nullptr) {
            continue;  // rules with faults on purpose
        }
        auto rules = std::make_unique<scripting::ScriptRules>(
            *script_, rules_settings_, *state->settings.types, script_log(script_->name));
        const std::string wrong = rules->go_on_from(*before);
        if (wrong.empty()) {
            state->rules = std::move(rules);
        } else {
            log_of(LogArea::kWorld)
                .error("zone {} keeps its script: {}", state->settings.id.value, wrong);
        }
    }
}

std::uint64_t World::script_errors() const {
    std::uint64_t all = 0;
    for (const zone::ZoneState* state : states_) {
        const auto* rules = dynamic_cast<const scripting::ScriptRules*>(state->rules.get());
        all += rules != nullptr ? rules->errors() : 0;
    }
    return all;
}

}  // namespace zoned::app
