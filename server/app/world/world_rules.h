// World rules: the rules that a config asks for, its script's or those that the server is linked
// with.
#pragma once

#include "server/config/settings.h"
#include "server/scripting/script_settings.h"
#include "server/zone/rules.h"

#include <memory>
#include <optional>
#include <string>

namespace zoned::app {

/// Throws std::runtime_error as zone::make_rules does.
std::unique_ptr<zone::Rules> make_world_rules(
    const std::optional<scripting::ScriptSettings>& script,
    const zone::RulesSettings& settings,
    const world::TypeTable& types);

/// Adds the fields that the rules of a world declare to its types, and brings the digest up to
/// date: once, when a config has been read, and before a world is made of it. Throws as
/// zone::make_rules does, also where a declaration has a mistake.
void declare_fields(config::Settings& settings);

/// Makes the rules of a world, gives its brains their code, and lets go of both. Throws as
/// zone::make_rules does, also where a brain names code that these rules do not have.
void try_world_rules(const config::Settings& settings);

/// Into the log of the world, each line after the script's name.
scripting::ScriptLog script_log(const std::string& name);

}  // namespace zoned::app
