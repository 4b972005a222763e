// agent_report: says why an agent does what it does, from the state after a tick.
#pragma once

#include "server/config/settings.h"
#include "server/zone/zone.h"

#include <string>

namespace zoned::app {

/// Lines of text; empty where the zone does not own the entity, or it has no agent. Between two
/// ticks only; the zone stays as it is.
std::string agent_report(const config::Settings& settings,
                         zone::Zone& zone,
                         EntityId entity,
                         Tick now);

}  // namespace zoned::app
