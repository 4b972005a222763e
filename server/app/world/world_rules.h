// World rules: the rules that a config asks for, its script's or those that the server is linked
// with.
#pragma once

#include "server/config/settings.h"
#include "server/zone/rules.h"

#include <memory>

namespace zoned::app {

/// Throws std::runtime_error as zone::make_rules does. A script writes into the log of the world.
std::unique_ptr<zone::Rules> make_world_rules(const config::Settings& settings,
                                              const world::TypeTable& types);

}  // namespace zoned::app
