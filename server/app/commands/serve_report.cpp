#include "server/app/commands/serve_report.h"

#include "server/app/log/log.h"
#include "server/recording/report.h"
#include "server/replication/packer.h"
#include "proto/session.pb.h"

#include <cstdio>
#include <ctime>

namespace zoned::app {

double process_cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

namespace {

recording::Percentiles percentiles(const core::Histogram& h) {
    return {h.percentile(0.5), h.percentile(0.99), h.percentile(0.999), h.max()};
}

void add_loop(const LoopStats& loop, recording::ServerReport& report) {
    report.ticks = static_cast<std::uint64_t>(loop.ticks);
    report.tick_ms = percentiles(loop.wall_ms);
    report.tick_cpu_ms = percentiles(loop.cpu_ms);
    report.tick_late_ms = percentiles(loop.late_ms);
    report.overruns = loop.overruns;
    report.overruns_by_reason = loop.overrun_causes;
    report.dropped_ticks = loop.dropped_ticks;
    report.entities = loop.entities;
    report.awake_bodies = loop.awake_bodies;
    report.handoffs = loop.handoffs;
    report.client_handoffs = loop.client_handoffs;
    report.state_hash = loop.state_hash;
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        const PassTotals& from = loop.passes[p];
        recording::PassFigures& to = report.passes.emplace_back();
        to.name = zone::pass_name(static_cast<zone::Pass>(p));
        to.zones = from.zones;
        to.ticks_run = from.ran;
        to.ticks_skipped = from.skipped;
        to.total_ms = static_cast<double>(from.ns) * 1e-6;
        to.count = from.count;
        to.skip_reason = from.skip_reason;
    }
    report.extra["recorded_ticks"] = static_cast<double>(loop.recording.ticks);
    report.extra["recording_bytes"] = static_cast<double>(loop.recording.bytes);
    report.extra["recording_failures"] = static_cast<double>(loop.recording.failures);
    report.extra["recording_behind_ticks_max"] =
        static_cast<double>(loop.recording.behind_ticks_max);
    report.extra["recording_cpu_ms"] = 1e-6 * static_cast<double>(loop.recording.writer_cpu_ns);
    report.extra["undeliverable"] = static_cast<double>(loop.undeliverable);
    report.extra["script_errors"] = static_cast<double>(loop.script_errors);
    report.extra["inbox_dropped"] = static_cast<double>(loop.inbox_dropped);
    report.extra["limit_exceeded"] = static_cast<double>(loop.limit_exceeded);
    report.extra["fields_clamped"] = static_cast<double>(loop.fields_clamped);
    report.extra["fields_refused"] = static_cast<double>(loop.fields_refused);
    report.extra["out_of_world"] = static_cast<double>(loop.out_of_world);
    report.extra["quarantined_bodies"] = static_cast<double>(loop.quarantined);
    report.extra["strained_islands"] = static_cast<double>(loop.substep_limited);
    report.extra["far_bodies"] = static_cast<double>(loop.far_bodies);
    report.extra["held_back_bodies"] = static_cast<double>(loop.held_back);
    report.extra["slowed_bodies"] = static_cast<double>(loop.slowed);
    report.extra["clients_over_budget"] = static_cast<double>(loop.over_budget);
    report.extra["inputs"] = static_cast<double>(loop.inputs);
    report.extra["inputs_missing"] = static_cast<double>(loop.inputs_missing);
    report.extra["publications"] = static_cast<double>(loop.publications);
    report.extra["records_sent"] = static_cast<double>(loop.records_sent);
    report.extra["records_resent"] = static_cast<double>(loop.records_resent);
    report.extra["records_repeated"] = static_cast<double>(loop.records_repeated);
    report.extra["packets_given_up"] = static_cast<double>(loop.packets_given_up);
    report.extra["packets_found"] = static_cast<double>(loop.packets_found);
    report.extra["particles"] = static_cast<double>(loop.particles);
    report.extra["bursts_told"] = static_cast<double>(loop.bursts_sent);
    report.extra["device_particle_steps"] = static_cast<double>(loop.device_particles);
    report.extra["device_faults"] = static_cast<double>(loop.device_faults);
    report.extra["interest_broadcast_ticks"] = static_cast<double>(loop.broadcast_ticks);
}

void add_network(const Network& network, recording::ServerReport& report) {
    const session::HostStats& s = network.sessions();
    report.sessions_max = s.sessions_max;
    report.packets_in = s.packets_in;
    report.packets_out = s.packets_out;
    report.bytes_in = s.bytes_in;
    report.bytes_out = s.bytes_out;
    report.rejected = network.rejected();
    const net::TlsStats web = network.web();
    for (const auto& [reason, count] : web.websocket_refused) {
        report.rejected["websocket_" + reason] = count;
    }
    report.extra["websockets_opened"] = static_cast<double>(web.opened);
    const net::UdpStats& udp = network.udp();
    report.extra["udp_receive_calls"] = static_cast<double>(udp.receive_calls);
    report.extra["udp_send_calls"] = static_cast<double>(udp.send_calls);
    report.extra["udp_dropped_full"] = static_cast<double>(udp.dropped_full);
    report.extra["udp_dropped_error"] = static_cast<double>(udp.dropped_error);
    report.extra["tcp_frames_in"] = static_cast<double>(s.frames_in);
    report.extra["tcp_frames_out"] = static_cast<double>(s.frames_out);
    report.extra["tcp_bytes_in"] = static_cast<double>(s.frame_bytes_in);
    report.extra["tcp_bytes_out"] = static_cast<double>(s.frame_bytes_out);
    report.extra["tls_opened"] = static_cast<double>(network.tls().opened);
    report.extra["tls_handshake_failed"] = static_cast<double>(network.tls().handshake_failed);
    report.extra["sessions_resumed"] = static_cast<double>(s.resumed);
    report.extra["tunnelled_packets"] = static_cast<double>(s.tunnelled);
    report.extra["address_changes"] = static_cast<double>(s.address_changes);
}

recording::TrafficFigures traffic_figures(const ServeFigures& figures, const LoopStats& loop) {
    const session::HostStats& s = figures.network.sessions();
    recording::TrafficFigures traffic;
    traffic.table = loop.traffic;
    for (const world::EntityType& type : figures.settings.types) {
        traffic.types.push_back(type.name);
    }
    traffic.sent_packets = s.packets_out + s.tunnelled;
    traffic.sent_bytes = s.bytes_out + s.tunnelled_bytes;
    const auto* messages = proto::ServerMessage::descriptor();
    for (const auto& [number, bytes] : s.frame_bytes_by_message) {
        const auto* field = messages->FindFieldByNumber(static_cast<int>(number));
        traffic.stream_bytes[field != nullptr ? field->name() : "empty"] += bytes;
    }
    return traffic;
}

}  // namespace

void log_traffic(const ServeFigures& figures, wire::TrafficTable& before, double seconds) {
    wire::TrafficTable now = figures.loop.stats().traffic;
    const std::uint64_t packets = now.packets() - before.packets();
    if (packets == 0 || !(seconds > 0.0)) {
        return;
    }
    std::string text;
    for (std::size_t r = 0; r < wire::kTrafficReasons; ++r) {
        const auto reason = static_cast<wire::TrafficReason>(r);
        const double bytes = static_cast<double>(now.bits(reason) - before.bits(reason)) / 8.0;
        if (bytes > 0.0) {
            text += fmt::format(" {} {:.0f}", wire::kTrafficReasonNames[r], bytes / seconds);
        }
    }
    log_of(LogArea::kServer)
        .info("traffic, bytes/s: seal and headers {:.0f}{}",
              static_cast<double>(packets * replication::kPacketOverheadBytes) / seconds,
              text);
    before = std::move(now);
}

void log_summary(const ServeFigures& figures) {
    const LoopStats loop = figures.loop.stats();
    log_of(LogArea::kServer)
        .info(
            "{} ticks, tick p50 {:.2f} ms, p99 {:.2f} ms, CPU p99 {:.2f} ms, {} overruns, {} "
            "handoffs, "
            "{:.1f} % of a core",
            loop.ticks,
            loop.wall_ms.percentile(0.5),
            loop.wall_ms.percentile(0.99),
            loop.cpu_ms.percentile(0.99),
            loop.overruns,
            loop.handoffs,
            100.0 * figures.cpu_seconds / figures.seconds);
    const recording::TrafficFigures traffic = traffic_figures(figures, loop);
    std::fputs(wire::traffic_text(
                   loop.traffic, traffic.types, figures.seconds, replication::kPacketOverheadBytes)
                   .c_str(),
               stderr);
}

std::string serve_report(const ServeFigures& figures) {
    const LoopStats loop = figures.loop.stats();
    recording::ServerReport report;
    report.world = figures.settings.world_name;
    report.config_digest = figures.settings.digest;
    report.seconds = figures.seconds;
    report.tick_rate_hz = figures.settings.tick_rate_hz;
    report.threads = figures.threads;
    report.cpu_cores = figures.cpu_seconds / figures.seconds;
    add_loop(loop, report);
    add_network(figures.network, report);
    report.state_flapping = loop.state_flapping;
    if (loop.traffic.packets() > 0) {
        report.traffic = traffic_figures(figures, loop);
    }
    for (std::size_t i = 0; i < figures.settings.zones.size() && i < loop.zones.size(); ++i) {
        report.zones.push_back(
            {figures.settings.zones[i].name, loop.zones[i].entities, loop.zones[i].state_hash});
    }
    return recording::to_json(report);
}

}  // namespace zoned::app
