// Report: the figures of a run that `zoned serve --report` writes, as JSON.
#pragma once

#include "shared/core/json.h"
#include "shared/wire/traffic.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace zoned::recording {

/// Of a measured time, ms.
struct Percentiles {
    double p50 = 0.0;
    double p99 = 0.0;
    double p999 = 0.0;
    double max = 0.0;
};

/// One pass of the step over all ticks and zones.
struct PassFigures {
    std::string name;
    std::uint64_t zones = 0;          ///< that ran it at least once
    std::uint64_t ticks_run = 0;      ///< (tick, zone) pairs in which it ran
    std::uint64_t ticks_skipped = 0;  ///< and in which it did not
    double total_ms = 0.0;
    std::uint64_t count = 0;  ///< units of work
    std::string skip_reason;  ///< of the last skip; empty when it always ran
};

struct ZoneFigures {
    std::string name;
    std::uint64_t entities = 0;
    std::uint64_t state_hash = 0;
};

/// Two states between which NPCs go to and fro.
struct FlappingFigures {
    std::string brain;
    std::pair<std::string, std::string> states;
    std::string forth;         ///< the transition from the first to the second, and its trigger
    std::string back;          ///< and the one back
    std::uint64_t count = 0;   ///< of times that one was found at it
    std::uint32_t entity = 0;  ///< the last one
    std::uint64_t tick = 0;    ///< and when
};

/// The use of the bytes.
struct TrafficFigures {
    wire::TrafficTable table;        ///< of the bodies that the zones made
    std::vector<std::string> types;  ///< their names
    std::uint64_t sent_packets = 0;  ///< sealed and sent, over the stream too
    std::uint64_t sent_bytes = 0;    ///< of them, UDP payload: headers and seal counted
    std::map<std::string, std::uint64_t> stream_bytes;  ///< frames over TCP, by message
};

/// Figures of one run. Field names in JSON are those of the members, with units; `extra` holds
/// further counts of a caller, in order of name.
struct ServerReport {
    std::string world;
    std::string config_digest;
    double seconds = 0.0;
    std::uint64_t ticks = 0;
    double tick_rate_hz = 0.0;
    std::uint64_t threads = 0;
    Percentiles tick_ms;       ///< by the wall
    Percentiles tick_cpu_ms;   ///< of all threads that stepped
    Percentiles tick_late_ms;  ///< from when a tick was due to its start
    double cpu_cores = 0.0;    ///< CPU time of the process / seconds, without its start
    std::uint64_t overruns = 0;
    std::map<std::string, std::uint64_t> overruns_by_reason;
    std::uint64_t dropped_ticks = 0;
    std::uint64_t entities = 0;
    std::uint64_t awake_bodies = 0;
    std::uint64_t sessions_max = 0;
    std::uint64_t packets_in = 0;
    std::uint64_t packets_out = 0;
    std::uint64_t bytes_in = 0;
    std::uint64_t bytes_out = 0;
    std::map<std::string, std::uint64_t> rejected;  ///< reason -> count
    std::uint64_t handoffs = 0;
    std::uint64_t client_handoffs = 0;
    std::uint64_t state_hash = 0;  ///< over the zones
    std::map<std::string, double> extra;
    std::vector<ZoneFigures> zones;
    std::vector<PassFigures> passes;
    std::vector<FlappingFigures> state_flapping;
    std::optional<TrafficFigures> traffic;  ///< where the meter is on
};

std::string to_json(const ServerReport& report);

}  // namespace zoned::recording
