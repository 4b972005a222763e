#include "server/app/ctl/ctl_tables.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <vector>

namespace zoned::app {

namespace {

std::string duration_text(double seconds) {
    const auto s = static_cast<long>(seconds);
    return s >= 3600 ? fmt::format("{} h {:02} min", s / 3600, s / 60 % 60)
                     : fmt::format("{} min {:02} s", s / 60, s % 60);
}

std::string time_text(double unix_s) {
    if (unix_s == 0.0) {
        return "for ever";
    }
    const auto time = static_cast<std::time_t>(unix_s);
    std::tm utc{};
    gmtime_r(&time, &utc);
    char text[32];
    return std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M UTC", &utc) > 0 ? text : "";
}

/// "admin info, session error", by name.
std::string levels_text(const proto::admin::Status& status) {
    const std::map<std::string, std::string> sorted(status.log_levels().begin(),
                                                    status.log_levels().end());
    std::string out;
    for (const auto& [area, level] : sorted) {
        out += fmt::format("{}{} {}", out.empty() ? "" : ", ", area, level);
    }
    return out;
}

}  // namespace

std::string status_text(const proto::admin::Status& s) {
    std::string out = fmt::format(
        "world       {}{}\n"
        "server      zoned {}, {}, up {}\n"
        "ticks       {:.0f} at {} Hz, {:.0f} overruns, {:.0f} dropped\n"
        "tick        p50 {:.2f} ms, p99 {:.2f} ms, max {:.2f} ms\n"
        "world holds {} entities in {} zones, {} bodies awake\n"
        "sessions    {} (most {}), round trip p50 {:.1f} ms, p99 {:.1f} ms\n"
        "datagrams   {:.1f} MB in, {:.1f} MB out\n"
        "log level   {}\n"
        "state hash  {}\n",
        s.world(),
        s.draining() ? ", draining" : "",
        s.version(),
        s.target(),
        duration_text(s.uptime_s()),
        s.tick(),
        s.tick_rate_hz(),
        s.overruns(),
        s.dropped_ticks(),
        s.tick_ms().p50(),
        s.tick_ms().p99(),
        s.tick_ms().max(),
        s.entities(),
        s.zones(),
        s.awake_bodies(),
        s.sessions(),
        s.sessions_max(),
        s.rtt_ms_p50(),
        s.rtt_ms_p99(),
        1e-6 * s.bytes_in(),
        1e-6 * s.bytes_out(),
        s.log_level() == "mixed" ? "mixed: " + levels_text(s) : s.log_level(),
        s.state_hash());
    for (const proto::admin::StoppedZone& zone : s.stopped_zones()) {
        out += fmt::format("stopped     zone {} at tick {:.0f} in {}: {}\n",
                           zone.zone(),
                           zone.tick(),
                           zone.place(),
                           zone.text());
    }
    for (const proto::admin::SettingChange& change : s.waiting_changes()) {
        out += fmt::format("waits       for a restart: {} {} -> {}\n",
                           change.path(),
                           change.before(),
                           change.after());
    }
    const auto counts = [&](const char* title, const auto& map) {
        std::vector<std::pair<std::string, double>> sorted(map.begin(), map.end());
        std::sort(sorted.begin(), sorted.end());
        for (const auto& [reason, count] : sorted) {
            out += fmt::format("{:<11} {} {:.0f}\n", title, reason, count);
        }
    };
    counts("rejected", s.rejected());
    counts("refused", s.admin_refused());
    return out;
}

std::string passes_text(const proto::admin::Status& status, int most) {
    std::vector<proto::admin::PassTime> passes(status.passes().begin(), status.passes().end());
    std::stable_sort(passes.begin(), passes.end(), [](const auto& a, const auto& b) {
        return a.share() > b.share();
    });
    std::string out = fmt::format("{:<16} {:>10} {:>7}\n", "pass", "us a tick", "share");
    for (int p = 0; p < std::min(most, static_cast<int>(passes.size())); ++p) {
        const proto::admin::PassTime& pass = passes[static_cast<std::size_t>(p)];
        out += fmt::format(
            "{:<16} {:>10.1f} {:>6.1f}%\n", pass.name(), pass.mean_us(), 100.0 * pass.share());
    }
    return out;
}

std::string sessions_text(const proto::admin::SessionList& list) {
    std::string out = fmt::format("{:>7} {:<16} {:<16} {:>4} {:>8} {:<24} {:>7} {:>9} {:>9}  {}\n",
                                  "client",
                                  "account",
                                  "name",
                                  "zone",
                                  "avatar",
                                  "address",
                                  "rtt ms",
                                  "kB in",
                                  "kB out",
                                  "state");
    for (const proto::admin::SessionFigures& s : list.sessions()) {
        out +=
            fmt::format("{:>7} {:<16} {:<16} {:>4} {:>8} {:<24} {:>7.1f} {:>9.1f} {:>9.1f}  {}\n",
                        s.client(),
                        s.account(),
                        s.name(),
                        s.zone(),
                        s.avatar(),
                        s.address(),
                        s.rtt_ms(),
                        1e-3 * s.bytes_in(),
                        1e-3 * s.bytes_out(),
                        !s.connected() ? "away" : (s.udp() ? "udp" : "stream"));
    }
    return out + fmt::format("{} of {} sessions\n", list.sessions_size(), list.total());
}

std::string zones_text(const proto::admin::ZoneList& list) {
    std::string out = fmt::format("{:>4} {:<20} {:>9} {:>7} {:>7} {:>8} {:>9}  {}\n",
                                  "zone",
                                  "name",
                                  "entities",
                                  "ghosts",
                                  "awake",
                                  "viewers",
                                  "step ms",
                                  "state hash");
    for (const proto::admin::ZoneFigures& z : list.zones()) {
        out += fmt::format("{:>4} {:<20} {:>9} {:>7} {:>7} {:>8} {:>9.3f}  {}\n",
                           z.id(),
                           z.name(),
                           z.entities(),
                           z.ghosts(),
                           z.awake_bodies(),
                           z.viewers(),
                           z.step_ms(),
                           z.state_hash());
    }
    return out;
}

std::string bans_text(const proto::admin::BanList& list) {
    std::string out = fmt::format("{:<24} {:<22} {}\n", "account", "until", "reason");
    for (const proto::admin::Ban& ban : list.bans()) {
        out += fmt::format(
            "{:<24} {:<22} {}\n", ban.account(), time_text(ban.until_unix_s()), ban.reason());
    }
    return out;
}

std::string entity_text(const proto::admin::EntityFigures& e) {
    const auto numbers = [](const auto& values) {
        std::string out;
        for (const double value : values) {
            out += fmt::format("{}{:.3f}", out.empty() ? "" : ", ", value);
        }
        return out;
    };
    std::string out = fmt::format(
        "entity      {}, a {} in zone {}, tick {:.0f}\n"
        "position    {} m\n"
        "velocity    {} m/s{}\n"
        "orientation {} (w, x, y, z)\n"
        "stance      {}, appearance {}{}\n",
        e.id(),
        e.type(),
        e.zone(),
        e.tick(),
        numbers(e.position_m()),
        numbers(e.velocity_mps()),
        e.at_rest() ? ", at rest" : "",
        numbers(e.orientation()),
        e.stance(),
        e.appearance(),
        e.hidden() ? ", hidden" : "");
    if (e.client() != 0) {
        out += fmt::format("client      {}\n", e.client());
    }
    for (const proto::admin::FieldFigures& field : e.fields()) {
        out += fmt::format("field       {}: {}\n", field.name(), field.value());
    }
    out += fmt::format("sent        {:.0f} bytes in {:.0f} records of {:.0f} publications\n",
                       e.sent_bytes(),
                       e.sent_records(),
                       e.publications());
    return out + e.agent();
}

}  // namespace zoned::app
