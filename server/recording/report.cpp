#include "server/recording/report.h"

#include "shared/wire/packet.h"

#include <cstdio>

namespace zoned::recording {

namespace {

std::string hex(std::uint64_t value) {
    char buffer[20];
    std::snprintf(buffer, sizeof(buffer), "%016llx", static_cast<unsigned long long>(value));
    return buffer;
}

void write_percentiles(core::JsonWriter& json, const std::string& name, const Percentiles& p) {
    json.field(name + "_p50", p.p50)
        .field(name + "_p99", p.p99)
        .field(name + "_p999", p.p999)
        .field(name + "_max", p.max);
}

void write_zones(core::JsonWriter& json, const std::vector<ZoneFigures>& zones) {
    json.key("zones").begin_array();
    for (const ZoneFigures& zone : zones) {
        json.begin_object()
            .field("name", zone.name)
            .field("entities", zone.entities)
            .field("state_hash", hex(zone.state_hash))
            .end_object();
    }
    json.end_array();
}

void write_flapping(core::JsonWriter& json, const std::vector<FlappingFigures>& state_flapping) {
    json.key("wavering").begin_array();
    for (const FlappingFigures& pair : state_flapping) {
        json.begin_object()
            .field("machine", pair.brain)
            .field("forth", pair.forth)
            .field("back", pair.back)
            .field("count", pair.count)
            .field("entity", static_cast<std::uint64_t>(pair.entity))
            .field("tick", pair.tick)
            .end_object();
    }
    json.end_array();
}

void write_passes(core::JsonWriter& json, const std::vector<PassFigures>& passes) {
    json.key("passes").begin_array();
    for (const PassFigures& pass : passes) {
        json.begin_object()
            .field("name", pass.name)
            .field("zones", pass.zones)
            .field("ticks_run", pass.ticks_run)
            .field("ticks_skipped", pass.ticks_skipped)
            .field("total_ms", pass.total_ms)
            .field("count", pass.count)
            .field("skip_reason", pass.skip_reason)
            .end_object();
    }
    json.end_array();
}

/// Bodies that were made and not sent: the session had gone, or its stream was full.
void write_traffic_figures(core::JsonWriter& json, const TrafficFigures& traffic) {
    constexpr std::uint64_t kAround =
        wire::kDatagramHeaderBytes + wire::kSealTagBytes + wire::kDownTransportBytes;
    json.key("traffic").begin_object();
    wire::write_traffic(json, traffic.table, traffic.types);
    const std::uint64_t sent_bodies = traffic.sent_bytes - kAround * traffic.sent_packets;
    json.field("seal_and_header_bytes", kAround * traffic.sent_packets);
    json.field("sent_body_bytes", sent_bodies);
    json.field("withheld_body_bytes", traffic.table.bits() / 8 - sent_bodies);
    json.field("stream_bytes", traffic.stream_bytes);
    json.end_object();
}

}  // namespace

std::string to_json(const ServerReport& report) {
    core::JsonWriter json;
    json.begin_object()
        .field("world", report.world)
        .field("config_digest", report.config_digest)
        .field("seconds", report.seconds)
        .field("ticks", report.ticks)
        .field("tick_rate_hz", report.tick_rate_hz)
        .field("threads", report.threads);
    write_percentiles(json, "tick_ms", report.tick_ms);
    write_percentiles(json, "tick_cpu_ms", report.tick_cpu_ms);
    write_percentiles(json, "tick_late_ms", report.tick_late_ms);
    json.field("cpu_cores", report.cpu_cores).field("overruns", report.overruns);
    json.field("overruns_by_reason", report.overruns_by_reason);
    json.field("dropped_ticks", report.dropped_ticks)
        .field("entities", report.entities)
        .field("awake_bodies", report.awake_bodies)
        .field("sessions_max", report.sessions_max)
        .field("packets_in", report.packets_in)
        .field("packets_out", report.packets_out)
        .field("bytes_in", report.bytes_in)
        .field("bytes_out", report.bytes_out);
    json.field("rejected", report.rejected);
    json.field("handoffs", report.handoffs)
        .field("client_handoffs", report.client_handoffs)
        .field("state_hash", hex(report.state_hash));
    for (const auto& [name, number] : report.extra) {
        json.field(name, number);
    }
    write_zones(json, report.zones);
    write_passes(json, report.passes);
    write_flapping(json, report.state_flapping);
    if (report.traffic) {
        write_traffic_figures(json, *report.traffic);
    }
    json.end_object();
    return json.text() + "\n";
}

}  // namespace zoned::recording
