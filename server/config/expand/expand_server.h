// expand_server: expands network, sessions, threads, topics and faults of a config into plain
// structs.
#pragma once

#include "server/config/server_settings.h"

namespace zoned::proto::config {
class Config;
}

namespace zoned::config {

ServerSettings expand_server(const proto::config::Config& config);

}  // namespace zoned::config
