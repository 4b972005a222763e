// CounterWatch: turns counters that grow into log lines: what is dropped, refused or in trouble is
// logged when it happens, and at most once in a while.
#pragma once

#include "server/app/runtime/tick_loop.h"
#include "server/app/runtime/zone_balance.h"
#include "server/config/settings.h"
#include "server/net/stream_connection.h"
#include "server/net/udp_endpoint.h"
#include "server/session/host/session_host.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace zoned::app {

/// The counters of a process at one moment.
struct WatchedCounters {
    const LoopStats& loop;
    const session::HostStats& host;
    const net::TlsStats& tls;
    const net::UdpStats& udp;
    std::uint64_t held_ticks = 0;                ///< that waited for the network thread
    const config::Settings* settings = nullptr;  ///< of the world; null: zones are not compared
};

class CounterWatch {
  public:
    /// Compares with the look before, and logs; call about once a second. A counter is told at
    /// once when it begins to grow, then at most every ten seconds, with the sum.
    void look(const WatchedCounters& counters, double now_s);

  private:
    struct Watched {
        std::uint64_t logged = 0;  ///< count of the last line
        double logged_s = -1e9;    ///< its time
    };

    void look_at_zones(const WatchedCounters& counters, double now_s);
    void look_at_refusals(const std::map<std::string, std::uint64_t>& rejected, double now_s);

    std::vector<Watched> watched_;
    ZoneBalance balance_;
    std::map<std::string, std::uint64_t> rejected_logged_;
    double rejected_logged_s_ = -1e9;
};

}  // namespace zoned::app
