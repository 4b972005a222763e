// expand_server: network, sessions, threads, topics and faults of a config as plain structs.
#pragma once

#include "server/config/server_settings.h"

namespace zoned::proto::config {
class Config;
}

namespace zoned::config {

ServerSettings expand_server(const proto::config::Config& config);

}  // namespace zoned::config
