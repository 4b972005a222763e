// NatsBoard: the board of a realm in NATS servers with JetStream.
#pragma once

#include "server/cluster/board.h"

#include <string>
#include <vector>

namespace zoned::cluster {

struct NatsSettings {
    std::vector<std::string> urls;  ///< of one group of servers, see parse_cluster_urls()
    std::string realm = "zoned";
    std::string name = "zoned";  ///< of this connection, for the operator of the NATS servers
    int replicas = 1;            ///< of a board that is made
    double patience_s = 2.0;     ///< for an answer
    double connect_s = 2.0;
};

/// Connects, and makes the board of the realm where there is none. The error is a text for an
/// operator, without secrets. A connection that is lost later is made again by itself.
[[nodiscard]] core::Result<std::unique_ptr<Board>> connect_nats_board(const NatsSettings& settings);

}  // namespace zoned::cluster
