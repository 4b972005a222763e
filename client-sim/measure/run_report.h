// RunReport: all measurements of a run of bots, with its verdict, as JSON and as a table.
#pragma once

#include "client-sim/audit/audit_verdict.h"
#include "client-sim/measure/latency.h"
#include "client-sim/measure/loop_meter.h"
#include "shared/core/histogram.h"
#include "shared/wire/traffic.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace zoned::measure {

struct RunReport : audit::SessionFaults {
    std::string script;
    std::string convergence;
    std::string view;       ///< extrapolate or interpolate
    std::string predictor;  ///< kind of prediction displayed: the published one, or none
    std::uint64_t seed = 0;
    std::uint64_t bots_asked = 0;
    std::uint64_t bots_joined = 0;
    std::uint64_t bots_lost = 0;                    ///< joined, but closed before the end
    std::map<std::string, std::uint64_t> troubles;  ///< why bots did not join or were lost
    double seconds = 0.0;

    core::Histogram down_bytes_per_s;  ///< datagrams per bot, IP and UDP headers counted
    core::Histogram up_bytes_per_s;
    core::Histogram down_stream_bytes_per_s;  ///< frames without audits, per bot
    core::Histogram audit_bytes_per_s;        ///< audits, per bot
    double updates_per_s = 0.0;               ///< publications displayed, mean per bot

    audit::Tally audit;
    bool audits_expected = true;

    std::uint64_t events_sent = 0;  ///< numbered by the server for these clients
    std::uint64_t events_delivered = 0;
    std::uint64_t events_unheard = 0;  ///< events to everybody that some client did not receive
    std::uint64_t decisions_diverged =
        0;  ///< clients whose ledger differs from the server's decisions
    std::uint64_t commands_sent = 0;
    std::uint64_t commands_resent = 0;
    core::Histogram event_spread_ms;
    core::Histogram input_to_remote_display_ms;
    Latency::Histograms latency_stages_ms;  ///< of the same actions, by Stage
    std::uint64_t latency_unknown = 0;      ///< of them: without stages
    std::uint64_t input_changes_unseen = 0;
    core::Histogram rtt_ms;
    core::Histogram clock_error_ms;
    double clock_bound_ms = 0.0;       ///< largest error that the round trips admit
    core::Histogram own_correction_m;  ///< between prediction and truth of the own avatar
    core::Histogram
        own_jump_m;  ///< the same where the avatar was moved elsewhere: spawned, teleported
    core::Histogram lead_ticks;
    core::Histogram view_delay_ticks;  ///< how far an interpolating view is behind the server

    std::uint64_t packets_lost = 0;
    std::uint64_t packets_received = 0;
    std::uint64_t replayed = 0;
    std::uint64_t unauthenticated = 0;
    std::uint64_t clock_set_backs = 0;  ///< times that a server dropped ticks, by all clients
    std::uint64_t silent_bots = 0;      ///< received nothing in the last seconds of the run
    std::uint64_t tunnelled_bots = 0;
    std::uint64_t streams_lost = 0;
    std::uint64_t resumed = 0;
    std::uint64_t recovered = 0;         ///< of these: by a server that had crashed in between
    std::uint64_t travels = 0;           ///< to another world of a cluster
    std::uint64_t travels_prepared = 0;  ///< of these: the stream to its server was open already
    std::uint64_t redirects = 0;         ///< logins that another server took
    core::Histogram travel_gap_ms;  ///< from the last word of one world to the avatar in the next
    std::uint64_t view_resets = 0;
    std::uint64_t unknown_keyframes = 0;
    std::uint64_t environment_updates = 0;    ///< events with the state of the shared environment
    std::uint64_t environment_corrected = 0;  ///< values that these events corrected
    std::uint64_t bursts = 0;                 ///< bursts of cosmetic particles, received as events
    std::uint64_t bursts_malformed = 0;
    std::uint64_t bursts_refused = 0;  ///< more at a time than a client displays
    std::uint64_t zone_changes = 0;    ///< handoffs that clients saw
    std::uint64_t input_missing = 0;
    std::uint64_t input_ticks = 0;          ///< ticks that the server has reported to bots
    std::uint64_t input_ticks_missing = 0;  ///< of these: the command was missing
    std::uint64_t publications_absolute = 0;
    std::array<std::uint64_t, motion::kPredictorOrders> publications_by_order{};
    std::uint64_t send_drops = 0;
    bool bottleneck = false;               ///< the link conditioner limits the traffic to clients
    core::Histogram bottleneck_wait_s;     ///< of datagrams to clients, in its queue
    double bottleneck_utilisation = 0.0;   ///< share of the capacity of all bottlenecks to clients
    std::uint64_t bottleneck_dropped = 0;  ///< found the queue full
    double process_cpu_s = 0.0;
    LoopMeter loop;                          ///< of the process that played the bots, over the run
    wire::TrafficTable traffic;              ///< of all state packets received
    std::vector<std::string> traffic_types;  ///< names of its types

    bool freeze_asked = false;
    std::uint64_t auditing_bots = 0;   ///< online at the end, with the right to audit
    std::uint64_t frozen_bots = 0;     ///< got a record of the frozen world
    std::uint64_t converged_bots = 0;  ///< of them: matched exactly
    std::string frozen_difference;     ///< of the first bot that did not match

    bool consistent = false;
    std::string inconclusive;  ///< why the run says nothing about the server; empty: it does
    std::vector<std::string> reasons;   ///< reasons against consistency
    std::vector<std::string> warnings;  ///< circumstances that weaken a good verdict
};

/// Fills `consistent`, `inconclusive`, `reasons` and `warnings` from everything else.
void judge(RunReport& report);

/// consistent, inconsistent or inconclusive.
[[nodiscard]] const char* verdict_of(const RunReport& report);

/// JSON object with the fields of the command line's contract, and more.
[[nodiscard]] std::string to_json(const RunReport& report);
/// A table for people.
[[nodiscard]] std::string to_table(const RunReport& report);

}  // namespace zoned::measure
