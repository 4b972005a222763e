// ClusterFigures: the figures of a server in a cluster, for metrics.
#pragma once

#include <cstdint>

namespace zoned::app {

/// Since the start, but for the first four and `travelling`.
struct ClusterFigures {
    bool held = false;  ///< the lease has not ended
    bool connected = false;
    double lease_left_s = 0.0;
    std::uint64_t epoch = 0;
    std::uint64_t lapses = 0;       ///< of the lease
    std::uint64_t travels_out = 0;  ///< accounts that were given to another world
    std::uint64_t travels_in = 0;
    std::uint64_t travelling = 0;  ///< avatars that have left and whose account is not given yet
    std::uint64_t redirects = 0;   ///< logins sent to another server
    std::uint64_t refused = 0;     ///< wishes to travel and logins that the cluster's state forbids
};

}  // namespace zoned::app
