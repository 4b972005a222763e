// ENet as a peer of the server's network: datagrams to and from many clients, without encryption.
#pragma once

#include <cstddef>

namespace zoned::bench {

/// Clients that get one unreliable packet a tick, and send one.
struct DuplexLoad {
    int clients = 1;  ///< 1..4000
    double rate_hz = 20.0;
    std::size_t down_bytes = 1;  ///< payload of a packet
    std::size_t up_bytes = 1;
    double seconds = 1.0;  ///< measured, once all are connected
};

struct DuplexCost {
    double us_per_update = 0.0;  ///< CPU time of the server's thread for a client and a tick
    double down_per_s = 0.0;     ///< packets that a client got
    double up_per_s = 0.0;       ///< packets of a client that the server got
};

/// Server and clients on a thread each, over loopback. Throws std::runtime_error where ENet
/// refuses, or clients do not connect.
DuplexCost enet_duplex(const DuplexLoad& load);

}  // namespace zoned::bench
