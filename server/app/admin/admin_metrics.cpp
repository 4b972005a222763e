#include "server/admin/metrics_text.h"
#include "server/app/admin/admin_figures.h"
#include "server/app/log/log.h"
#include "server/replication/packer.h"
#include "proto/session.pb.h"

#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

namespace zoned::app {

namespace {

using admin::MetricsText;

double number(std::uint64_t count) {
    return static_cast<double>(count);
}

/// The histogram's samples are ms.
void summary(MetricsText& out,
             const char* name,
             const char* help,
             const core::Histogram& histogram) {
    out.family(name, "summary", help);
    out.sample(1e-3 * histogram.percentile(0.5), {{"quantile", "0.5"}});
    out.sample(1e-3 * histogram.percentile(0.99), {{"quantile", "0.99"}});
    out.sample(1e-3 * histogram.max(), {{"quantile", "1"}});
    out.sample_of("_sum", 1e-3 * histogram.mean() * number(histogram.count()));
    out.sample_of("_count", number(histogram.count()));
}

void write_ticks(MetricsText& out, const LoopStats& loop) {
    out.single("zoned_ticks_total",
               "counter",
               "Ticks of the world.",
               number(static_cast<std::uint64_t>(loop.ticks)));
    summary(out,
            "zoned_tick_seconds",
            "Time of a tick from its start to its end, since the start of the server.",
            loop.wall_ms);
    summary(out,
            "zoned_tick_cpu_seconds",
            "Time of a tick in CPU time of all threads that step zones.",
            loop.cpu_ms);
    summary(out,
            "zoned_tick_late_seconds",
            "Time from when a tick was due to its start.",
            loop.late_ms);
    summary(out,
            "zoned_turn_seconds",
            "Time of the loop for a tick and all that goes with it, of the last whole ten seconds.",
            loop.turn_ms);
    summary(out, "zoned_turn_cpu_seconds", "The same in CPU time.", loop.turn_cpu_ms);
    out.family("zoned_tick_overruns_total",
               "counter",
               "Ticks that took longer than their period, by cause.");
    for (const auto& [cause, count] : loop.overrun_causes) {
        out.sample(number(count), {{"cause", cause}});
    }
    out.single("zoned_ticks_dropped_total",
               "counter",
               "Ticks left out because the loop was too far behind.",
               number(loop.dropped_ticks));
}

void write_passes(MetricsText& out, const LoopStats& loop) {
    const auto each = [&](auto value) {
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            const std::string name(zone::pass_name(static_cast<zone::Pass>(p)));
            out.sample(value(loop.passes[p]), {{"pass", name}});
        }
    };
    out.family("zoned_pass_seconds_total", "counter", "CPU time of a pass over all zones.");
    each([](const PassTotals& pass) { return 1e-9 * number(pass.ns); });
    out.family("zoned_pass_runs_total", "counter", "Ticks and zones in which a pass ran.");
    each([](const PassTotals& pass) { return number(pass.ran); });
    out.family("zoned_pass_skips_total", "counter", "Ticks and zones that did not need a pass.");
    each([](const PassTotals& pass) { return number(pass.skipped); });
}

void write_world(MetricsText& out, const config::Settings& settings, const LoopStats& loop) {
    const auto each = [&](auto value) {
        for (std::size_t i = 0; i < loop.zones.size(); ++i) {
            out.sample(value(loop.zones[i]), {{"zone", settings.zones[i].name}});
        }
    };
    out.family("zoned_zone_entities", "gauge", "Entities that a zone owns.");
    each([](const ZoneSample& zone) { return number(zone.entities); });
    out.family("zoned_zone_ghosts", "gauge", "Copies of entities that neighbour zones own.");
    each([](const ZoneSample& zone) { return number(zone.ghosts); });
    out.family("zoned_zone_awake_bodies", "gauge", "Dynamic bodies of a zone that are awake.");
    each([](const ZoneSample& zone) { return number(zone.awake_bodies); });
    out.family("zoned_zone_viewers", "gauge", "Clients whose avatar is in a zone.");
    each([](const ZoneSample& zone) { return number(zone.viewers); });
    out.family("zoned_zone_step_seconds", "gauge", "Time of the passes of a zone's last tick.");
    each([](const ZoneSample& zone) { return 1e-9 * number(zone.step_ns); });
    out.single("zoned_handoffs_total",
               "counter",
               "Entities that changed their zone.",
               number(loop.handoffs));
    out.single("zoned_limit_exceeded_total",
               "counter",
               "Entities and ticks beyond the declared acceleration or velocity jump.",
               number(loop.limit_exceeded));
    out.family("zoned_rules_total", "counter", "What the rules count, by its name.");
    for (const auto& [name, value] : loop.rules.counts) {
        out.sample(value, {{"name", name}});
    }
    out.family("zoned_rules_value", "gauge", "Values that the rules tell, by name and zone.");
    for (const auto& [key, value] : loop.rules.gauges) {
        out.sample(value, {{"name", key.first}, {"zone", settings.zones[key.second].name}});
    }
    out.single("zoned_rules_figures_refused_total",
               "counter",
               "Figures of the rules with a name that is none, no number, or one name too many.",
               number(loop.rules.refused));
    out.single("zoned_fields_clamped_total",
               "counter",
               "Numbers that the rules set beyond the range of a declared field.",
               number(loop.fields_clamped));
    out.single("zoned_fields_refused_total",
               "counter",
               "Values that the rules set and that a declared field cannot hold.",
               number(loop.fields_refused));
    out.single("zoned_zones_stopped",
               "gauge",
               "Zones that stand still because the rules threw.",
               number(loop.stopped.size()));
    out.single("zoned_inbox_dropped_total",
               "counter",
               "Messages to zones for which the mailbox had no room.",
               number(loop.inbox_dropped));
    out.single("zoned_undeliverable_total",
               "counter",
               "Messages for clients or entities that nobody owns.",
               number(loop.undeliverable));
    out.single("zoned_script_errors_total",
               "counter",
               "Calls of the rules' script that failed or overran, since it was read.",
               number(loop.script_errors));
    out.single("zoned_parties", "gauge", "Parties of players.", number(loop.parties));
    out.single("zoned_party_orders_refused_total",
               "counter",
               "Orders of the rules to parties that could not be carried out.",
               number(loop.party_orders_refused));
    out.single("zoned_quarantined_bodies_total",
               "counter",
               "Bodies whose state was not finite.",
               number(loop.quarantined));
    out.single("zoned_deformations_beyond_total",
               "counter",
               "Ticks of soft bodies whose control points could not keep the bound of their shape.",
               number(loop.deformations_beyond));
    out.single("zoned_inputs_missing_total",
               "counter",
               "Commands of players that were not there in time.",
               number(loop.inputs_missing));
    out.single("zoned_publications_total",
               "counter",
               "Encoded states of entities.",
               number(loop.publications));
    out.single("zoned_records_sent_total",
               "counter",
               "Copies of encoded states in packets to clients.",
               number(loop.records_sent));
    out.single("zoned_records_resent_total",
               "counter",
               "Of these: again, after a loss or ahead of the next one.",
               number(loop.records_resent));
    out.single("zoned_records_repeated_total",
               "counter",
               "Of these: ahead of the next loss, on paths that are new or lose packets.",
               number(loop.records_repeated));
    out.single("zoned_packets_given_up_total",
               "counter",
               "State packets without an acknowledgement, whose updates were sent again.",
               number(loop.packets_given_up));
    out.single("zoned_packets_found_total",
               "counter",
               "Of these: acknowledged after all, so sent again for nothing.",
               number(loop.packets_found));
    out.single("zoned_clients_late",
               "gauge",
               "Clients whose acknowledgements come much later than their path explains, in the "
               "last tick.",
               number(loop.late_clients));
    out.single("zoned_clients_widened",
               "gauge",
               "Clients that were notified of bounds wider than promised, in the last tick.",
               number(loop.widened_clients));
    out.single("zoned_clients_unreached",
               "gauge",
               "Clients without a stream or a live address, for which no packets are made.",
               number(loop.unreached));
}

void write_recording(MetricsText& out, const recording::RecorderFigures& recording) {
    out.single("zoned_recorded_ticks_total",
               "counter",
               "Ticks whose inputs were written.",
               number(recording.ticks));
    out.single("zoned_recording_bytes", "gauge", "Size of the recording.", number(recording.bytes));
    out.single("zoned_recording_failures_total",
               "counter",
               "Times that a recording could not be written.",
               number(recording.failures));
}

void write_network(MetricsText& out, const NetworkSample& n) {
    const session::HostStats& host = n.host;
    out.single("zoned_sessions", "gauge", "Clients that are logged in.", number(host.sessions));
    out.single(
        "zoned_load",
        "gauge",
        "Share of the time in which the busier of tick loop and network works, of the last second.",
        host.load);
    out.single("zoned_logins_refused_for_load",
               "gauge",
               "1 while logins are refused because of the load (network.max_load).",
               host.refusing ? 1.0 : 0.0);
    out.single("zoned_overload_ceiling_bytes_per_second",
               "gauge",
               "What a client may cost because of the load; +Inf: as ever.",
               host.ceiling_bytes_per_s);
    out.single(
        "zoned_connections", "gauge", "Open TCP connections of clients.", number(n.connections));
    out.family("zoned_datagrams_total", "counter", "Datagrams, by direction.");
    out.sample(number(host.packets_in), {{"direction", "in"}});
    out.sample(number(host.packets_out), {{"direction", "out"}});
    out.family("zoned_datagram_bytes_total", "counter", "UDP payload, by direction.");
    out.sample(number(host.bytes_in), {{"direction", "in"}});
    out.sample(number(host.bytes_out), {{"direction", "out"}});
    out.family("zoned_frames_total", "counter", "Messages over TCP, by direction.");
    out.sample(number(host.frames_in), {{"direction", "in"}});
    out.sample(number(host.frames_out), {{"direction", "out"}});
    out.family("zoned_frame_bytes_total", "counter", "Bytes of messages over TCP, by direction.");
    out.sample(number(host.frame_bytes_in), {{"direction", "in"}});
    out.sample(number(host.frame_bytes_out), {{"direction", "out"}});
    out.family("zoned_rejected_total",
               "counter",
               "What came from clients or zones and was not carried out, by reason.");
    for (const auto& [reason, count] : host.rejected) {
        out.sample(number(count), {{"reason", reason}});
    }
    out.family("zoned_rtt_seconds", "gauge", "Round trips of sessions, now.");
    out.sample(1e-3 * n.rtt.p50_ms, {{"percentile", "50"}});
    out.sample(1e-3 * n.rtt.p99_ms, {{"percentile", "99"}});
    out.single("zoned_tls_handshakes_failed_total",
               "counter",
               "TLS handshakes that failed.",
               number(n.tls.handshake_failed));
    out.single("zoned_tls_left_early_total",
               "counter",
               "Connections that their clients closed before they said anything.",
               number(n.tls.left_early + n.web.left_early));
    out.single("zoned_websockets", "gauge", "Open WebSockets of clients.", number(n.websockets));
    out.family(
        "zoned_websocket_refused_total",
        "counter",
        "WebSockets that were not opened, or were ended for a fault of the client, by reason.");
    for (const auto& [reason, count] : n.web.websocket_refused) {
        out.sample(number(count), {{"reason", reason}});
    }
    out.single("zoned_udp_dropped_total",
               "counter",
               "Datagrams that the system did not take.",
               number(n.udp.dropped_full + n.udp.dropped_error));
}

/// The table is empty where nothing meters the bytes.
void write_traffic(MetricsText& out, const wire::TrafficTable& traffic) {
    if (traffic.packets() == 0) {
        return;
    }
    out.family("zoned_state_bytes_total", "counter", "Bytes of state packets, by reason.");
    for (std::size_t r = 0; r < wire::kTrafficReasons; ++r) {
        const auto reason = static_cast<wire::TrafficReason>(r);
        out.sample(number(traffic.bits(reason)) / 8.0, {{"reason", wire::kTrafficReasonNames[r]}});
    }
}

void write_admin(MetricsText& out, const AdminFigures& f) {
    out.family("zoned_admin_answers_total", "counter", "Answers of the admin server, by status.");
    for (const auto& [status, count] : f.stats.answers) {
        out.sample(number(count), {{"status", std::to_string(status)}});
    }
    out.family("zoned_admin_refused_total",
               "counter",
               "Requests and connections that the admin server refused, by reason.");
    for (const auto& [reason, count] : f.router.refused()) {
        out.sample(number(count), {{"reason", reason}});
    }
    out.single(
        "zoned_viewers", "gauge", "Viewers that look at the world.", number(f.stats.viewers));
    out.single("zoned_admin_connections",
               "gauge",
               "Open connections of the admin server.",
               number(f.stats.connections));
}

void write_process(MetricsText& out, const AdminFigures& f) {
    timespec cpu{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    out.single("process_cpu_seconds_total",
               "counter",
               "CPU time of the process.",
               static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec));
    std::ifstream statm("/proc/self/statm");
    double pages = 0.0;
    double resident = 0.0;
    if (statm >> pages >> resident) {
        out.single("process_resident_memory_bytes",
                   "gauge",
                   "Memory of the process in RAM.",
                   resident * static_cast<double>(sysconf(_SC_PAGESIZE)));
    }
    out.single("zoned_uptime_seconds", "gauge", "Since the start of the server.", f.uptime_s);
    out.family("zoned_build_info", "gauge", "Always 1; version, target and world as labels.");
    out.sample(1.0,
               {{"version", ZONED_VERSION},
                {"target", ZONED_TARGET_NAME},
                {"world", f.settings.world_name}});
    const LogCounts lines = Log::counts();
    out.family("zoned_log_lines_lost_total", "counter", "Lines of the log that were not written.");
    out.sample(number(lines.left_out), {{"reason", "lines_per_s"}});
    out.sample(number(lines.dropped), {{"reason", "queue_full"}});
    out.single("zoned_draining", "gauge", "1 while no logins are taken.", f.draining ? 1.0 : 0.0);
}

void write_store(MetricsText& out, const AdminFigures& f) {
    if (!f.store) {
        return;
    }
    const store::StoreFigures& store = *f.store;
    const auto total = [&out](const char* name, const char* help, std::uint64_t count) {
        out.single(name, "counter", help, number(count));
    };
    total("zoned_store_commits_total", "Transactions of the store.", store.commits);
    total("zoned_store_changes_total", "Changes that are durable.", store.changes);
    total("zoned_store_reads_total", "Records that rules asked for.", store.reads);
    total("zoned_store_failures_total",
          "Transactions and reads that failed; transactions are tried again.",
          store.failures);
    total("zoned_store_checkpoint_failures_total",
          "Checkpoints that failed; the log of the store grows meanwhile.",
          store.checkpoint_failures);
    total("zoned_store_refused_total",
          "Requests for which no room was left while others waited.",
          store.refused);
    total("zoned_store_events_refused_total",
          "Durable events that were not sent because they were not stored.",
          f.network.refused_events);
    out.single("zoned_store_waiting_bytes",
               "gauge",
               "Changes that wait for the store.",
               number(store.waiting_bytes));
    out.single("zoned_store_events_waiting",
               "gauge",
               "Durable events that wait for the store.",
               number(f.network.held_events));
    out.single("zoned_store_failing",
               "gauge",
               "1 while the last transaction failed.",
               store.failing.empty() ? 0.0 : 1.0);
    summary(out, "zoned_store_commit_seconds", "Time of a transaction.", store.commit_ms);
}

void write_cluster(MetricsText& out, const AdminFigures& f) {
    if (!f.network.cluster) {
        return;
    }
    const ClusterFigures& cluster = *f.network.cluster;
    const auto total = [&out](const char* name, const char* help, std::uint64_t count) {
        out.single(name, "counter", help, number(count));
    };
    out.single("zoned_cluster_lease_held",
               "gauge",
               "1 while the lease of the world has not ended.",
               cluster.held ? 1.0 : 0.0);
    out.single("zoned_cluster_lease_left_seconds",
               "gauge",
               "Time until the lease ends; below 0: since when it has.",
               cluster.lease_left_s);
    out.single("zoned_cluster_connected",
               "gauge",
               "1 while the way to the cluster's board is up.",
               cluster.connected ? 1.0 : 0.0);
    out.single("zoned_cluster_epoch",
               "gauge",
               "Fencing number of this server's claim to its world.",
               number(cluster.epoch));
    total("zoned_cluster_lease_lapses_total",
          "Times that the lease ended before it was renewed.",
          cluster.lapses);
    out.family("zoned_cluster_travels_total", "counter", "Accounts that changed worlds.");
    out.sample(number(cluster.travels_in), {{"direction", "in"}});
    out.sample(number(cluster.travels_out), {{"direction", "out"}});
    out.single("zoned_cluster_travelling",
               "gauge",
               "Characters that have left, and whose account is not given away yet.",
               number(cluster.travelling));
    total("zoned_cluster_redirects_total",
          "Logins that were sent to another server.",
          cluster.redirects);
    total("zoned_cluster_refused_total",
          "Logins and travels refused for the state of the cluster.",
          cluster.refused);
}

void write_recovery(MetricsText& out, const AdminFigures& f) {
    if (!f.network.recovery) {
        return;
    }
    const RecoveryFigures& recovery = *f.network.recovery;
    out.single("zoned_recoveries_total",
               "counter",
               "Times that the world came back after its server died, since it began anew.",
               number(recovery.recoveries));
    out.single("zoned_recovery_seconds",
               "gauge",
               "Time that this process took to bring the world back.",
               recovery.seconds);
    out.single("zoned_recovery_ticks",
               "gauge",
               "Ticks that this process simulated again.",
               number(recovery.ticks));
    out.single("zoned_recovery_tick",
               "gauge",
               "Tick after which the world went on.",
               static_cast<double>(recovery.tick));
    out.family("zoned_recovery_sessions", "gauge", "Sessions of the world as it came back.");
    out.sample(number(recovery.sessions), {{"account", "here"}});
    out.sample(number(recovery.elsewhere), {{"account", "elsewhere"}});
}

}  // namespace

std::string metrics_of(const AdminFigures& f) {
    MetricsText out;
    write_ticks(out, f.loop);
    write_passes(out, f.loop);
    write_world(out, f.settings, f.loop);
    write_recording(out, f.loop.recording);
    write_network(out, f.network);
    write_store(out, f);
    write_recovery(out, f);
    write_cluster(out, f);
    write_traffic(out, f.loop.traffic);
    write_admin(out, f);
    write_process(out, f);
    return out.text();
}

}  // namespace zoned::app
