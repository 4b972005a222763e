#include "server/app/runtime/counter_watch.h"

#include "server/app/log/log.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>

namespace zoned::app {

namespace {

constexpr double kTellEvery_s = 10.0;

struct WatchRow {
    LogArea area;
    std::uint64_t (*count)(const WatchedCounters&);
    const char* text;  ///< after the count
};

std::uint64_t lines_lost(const WatchedCounters&) {
    return Log::counts().dropped;
}

constexpr auto kRows = std::to_array<WatchRow>({
    {LogArea::kTick,
     [](const WatchedCounters& c) { return c.loop.dropped_ticks; },
     "ticks were left out: the loop was too far behind (run.max_catch_up_ticks)"},
    {LogArea::kTick,
     [](const WatchedCounters& c) { return c.held_ticks; },
     "ticks waited: the network thread does not keep up with what they send"},
    {LogArea::kTick,
     [](const WatchedCounters& c) { return c.loop.inbox_dropped; },
     "messages to zones were dropped: the mailbox is full (run.mailbox_capacity)"},
    {LogArea::kWorld,
     [](const WatchedCounters& c) { return c.loop.quarantined; },
     "bodies were taken out of the physics: their state was not finite"},
    {LogArea::kWorld,
     [](const WatchedCounters& c) { return c.loop.out_of_world; },
     "entities left the world and were put back"},
    {LogArea::kWorld,
     [](const WatchedCounters& c) { return c.loop.substep_limited; },
     "times a group of bodies would have needed more substeps than there are"},
    {LogArea::kWorld,
     [](const WatchedCounters& c) { return c.loop.slowed; },
     "times a body was cut to the highest speed or spin that the physics has"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.tls.queue_overflow; },
     "connections were closed: their clients took too little of what waited for them"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.tls.refused_total + c.tls.refused_address; },
     "connections were refused: too many, in all or from one address"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.tls.accept_errors; },
     "connections could not be accepted (are there file descriptors left?)"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.tls.handshake_failed + c.tls.handshake_timeout; },
     "TLS handshakes failed or took too long"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.udp.dropped_full; },
     "datagrams were dropped: the socket's send buffer is full (network.socket_buffer_bytes)"},
    {LogArea::kNetwork,
     [](const WatchedCounters& c) { return c.udp.dropped_error; },
     "datagrams were refused by the system (no route, or a firewall)"},
    {LogArea::kServer,
     lines_lost,
     "lines of this log were lost: standard error is not read fast enough"},
});

/// Refusals that belong to ordinary play, or have lines of their own.
bool is_ordinary(const std::string& reason) {
    static const std::set<std::string> kOrdinary{"out_no_session",
                                                 "out_suspended",
                                                 "out_tunnel_backlog",
                                                 "input_late",
                                                 "input_missed",
                                                 "command_duplicate",
                                                 "silence"};
    return kOrdinary.count(reason) != 0 || reason.starts_with("login_");
}

}  // namespace

void CounterWatch::look(const WatchedCounters& counters, double now_s) {
    watched_.resize(kRows.size());
    for (std::size_t r = 0; r < kRows.size(); ++r) {
        Watched& watched = watched_[r];
        const std::uint64_t count = kRows[r].count(counters);
        if (count <= watched.logged || now_s - watched.logged_s < kTellEvery_s) {
            continue;
        }
        log_of(kRows[r].area)
            .warn("{} {}; {} since the start", count - watched.logged, kRows[r].text, count);
        watched.logged = count;
        watched.logged_s = now_s;
    }
    look_at_zones(counters, now_s);
    look_at_refusals(counters.host.rejected, now_s);
}

void CounterWatch::look_at_zones(const WatchedCounters& counters, double now_s) {
    const config::Settings* settings = counters.settings;
    const std::vector<ZoneSample>& zones = counters.loop.zones;
    if (settings == nullptr || zones.size() != settings->zones.size()) {
        return;
    }
    const double period_s = 1.0 / settings->tick_rate_hz;
    const std::optional<std::size_t> full = balance_.look(zones, period_s, now_s);
    if (!full) {
        return;
    }
    log_of(LogArea::kWorld)
        .warn(
            "zone {} takes {:.1f} of the {:.1f} ms of a tick, the others {:.1f} ms on average: {} "
            "players gather there; more zones, or other borders, share the work (zones)",
            settings->zones[*full].name,
            balance_.step_ms(*full),
            1e3 * period_s,
            balance_.others_ms(*full),
            zones[*full].viewers);
}

void CounterWatch::look_at_refusals(const std::map<std::string, std::uint64_t>& rejected,
                                    double now_s) {
    if (now_s - rejected_logged_s_ < kTellEvery_s) {
        return;
    }
    std::string text;
    for (const auto& [reason, count] : rejected) {
        std::uint64_t& logged = rejected_logged_[reason];
        if (count > logged && !is_ordinary(reason)) {
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", reason, count - logged);
        }
        logged = count;
    }
    if (!text.empty()) {
        rejected_logged_s_ = now_s;
        log_of(LogArea::kNetwork).info("not carried out, by reason: {}", text);
    }
}

}  // namespace zoned::app
