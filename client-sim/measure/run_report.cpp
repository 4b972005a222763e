#include "client-sim/measure/run_report.h"

#include "shared/core/json.h"

#include <cstdarg>
#include <cstdio>

namespace zoned::measure {

namespace {

const char* name_of(audit::FindingKind kind) {
    using audit::FindingKind;
    switch (kind) {
        case FindingKind::kPosition:
            return "position";
        case FindingKind::kOrientation:
            return "orientation";
        case FindingKind::kMissing:
            return "missing";
        case FindingKind::kExtra:
            return "extra";
        case FindingKind::kField:
            return "field";
    }
    return "?";
}

void write_range(core::JsonWriter& json,
                 const std::string& name,
                 const core::Histogram& h,
                 bool max) {
    json.field(name + "_p50", h.percentile(0.5));
    json.field(name + "_p99", h.percentile(0.99));
    if (max) {
        json.field(name + "_max", h.max());
    }
}

void write_audit(core::JsonWriter& json, const audit::Tally& t) {
    write_range(json, "position_error_m", t.displayed_m, true);
    write_range(json, "predicted_error_m", t.predicted_m, true);
    write_range(json, "orientation_error_rad", t.displayed_rad, true);
    write_range(json, "predicted_orientation_error_rad", t.predicted_rad, true);
    json.field("bound_violations", t.position_violations + t.orientation_violations);
    json.field("position_violations", t.position_violations);
    json.field("orientation_violations", t.orientation_violations);
    json.field("samples", t.samples);
    json.field("samples_after_loss", t.samples_after_loss);
    json.field("samples_lost_again", t.samples_lost_again);
    json.field("samples_stale", t.samples_stale);
    json.field("samples_widened", t.samples_widened);
    json.field("samples_unbounded", t.samples_unbounded);
    json.field("missing_told", t.missing_notified);
    json.field("audit_records", t.records);
    json.field("audits_skipped_late", t.skipped_late);
    json.field("audits_skipped_unsettled", t.skipped_unsettled);
    json.field("audits_skipped_undisplayed", t.skipped_undisplayed);
    json.field("audits_skipped_unmeasured", t.skipped_unmeasured);
    json.field("samples_skipped_discontinuity", t.skipped_discontinuity);
    json.field("samples_skipped_leaving", t.skipped_leaving);
    write_range(json, "news_age_s", t.update_age_s, true);
    write_range(json, "usual_news_age_s", t.usual_age_s, true);
    json.field("slow_samples", t.environment_samples);
    json.field("slow_violations", t.environment_violations);
    json.field("missing_entities", t.missing);
    json.field("extra_entities", t.extra);
    json.field("field_samples", t.field_samples);
    json.field("field_violations", t.field_violations);
    json.field("field_recent", t.field_recent);
    json.field("field_notified", t.field_notified);
}

void write_findings(core::JsonWriter& json, const audit::Tally& t) {
    json.key("worst").begin_array();
    for (const audit::Finding& f : t.worst) {
        json.begin_object();
        json.field("kind", name_of(f.kind));
        json.field("bot", static_cast<std::uint64_t>(f.client));
        json.field("tick", static_cast<std::uint64_t>(f.tick));
        json.field("entity", static_cast<std::uint64_t>(f.entity.value));
        json.field("type", f.type);
        json.field("error", f.error);
        json.field("allowed", f.allowed);
        json.field("news_age_s", f.age_s);
        json.field("distance_m", f.distance_m);
        json.field("after_loss", f.loss);
        json.end_object();
    }
    json.end_array();
}

double missing_share(const RunReport& r) {
    return r.input_ticks == 0
               ? 0.0
               : static_cast<double>(r.input_ticks_missing) / static_cast<double>(r.input_ticks);
}

void write_transport(core::JsonWriter& json, const RunReport& r) {
    json.field("packets_received", r.packets_received);
    json.field("packets_lost", r.packets_lost);
    json.field("packets_replayed", r.replayed);
    json.field("packets_unauthenticated", r.unauthenticated);
    json.field("packets_malformed", r.malformed);
    json.field("records_malformed", r.malformed_records);
    json.key("fields_refused").begin_object();
    for (std::size_t fault = 1; fault < wire::kDeclaredFaults; ++fault) {
        if (r.refused_fields[fault] > 0) {
            json.field(wire::kDeclaredFaultTexts[fault], r.refused_fields[fault]);
        }
    }
    json.end_object();
    json.field("slow_told", r.environment_updates);
    json.field("slow_corrected", r.environment_corrected);
    json.field("bursts", r.bursts);
    json.field("bursts_malformed", r.bursts_malformed);
    json.field("bursts_refused", r.bursts_refused);
    json.field("unknown_keyframes", r.unknown_keyframes);
    json.field("server_silences", r.server_silences);
    json.field("clock_set_backs", r.clock_set_backs);
    json.field("silent_bots", r.silent_bots);
    json.field("tunnelled", r.tunnelled_bots > 0);
    json.field("tunnelled_bots", r.tunnelled_bots);
    json.field("streams_lost", r.streams_lost);
    json.field("resumed", r.resumed);
    json.field("recovered", r.recovered);
    json.field("sessions_lost", r.sessions_lost);
    json.field("travels", r.travels);
    json.field("travels_prepared", r.travels_prepared);
    json.field("redirects", r.redirects);
    json.field("travel_gap_ms_p50", r.travel_gap_ms.percentile(0.5));
    json.field("travel_gap_ms_p99", r.travel_gap_ms.percentile(0.99));
    json.field("view_resets", r.view_resets);
    json.field("handoffs_seen", r.zone_changes);
    json.field("input_missing", r.input_missing);
    json.field("input_missing_share", missing_share(r));
    json.field("publications_absolute", r.publications_absolute);
    json.field("publications_order_0", r.publications_by_order[0]);
    json.field("publications_order_1", r.publications_by_order[1]);
    json.field("publications_order_2", r.publications_by_order[2]);
    json.field("publications_ballistic", r.publications_by_order[3]);
    json.field("publications_turning", r.publications_by_order[4]);
    json.field("send_drops", r.send_drops);
    if (r.bottleneck) {
        json.field("bottleneck_wait_ms_p50", 1e3 * r.bottleneck_wait_s.percentile(0.5));
        json.field("bottleneck_wait_ms_p95", 1e3 * r.bottleneck_wait_s.percentile(0.95));
        json.field("bottleneck_wait_ms_p99", 1e3 * r.bottleneck_wait_s.percentile(0.99));
        json.field("bottleneck_utilisation", r.bottleneck_utilisation);
        json.field("bottleneck_dropped", r.bottleneck_dropped);
    }
    json.field("process_cpu_s", r.process_cpu_s);
    write_range(json, "loop_ms", r.loop.turn_ms(), true);
    json.field("loop_late_share", r.loop.late_share());
}

/// printf into a string: tables are about columns.
__attribute__((format(printf, 2, 3))) void line(std::string& out, const char* format, ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    out += text;
    out += '\n';
}

void row(std::string& out, const char* name, const core::Histogram& h, const char* unit) {
    line(out,
         "  %-30s %10.4g %10.4g %10.4g  %s",
         name,
         h.percentile(0.5),
         h.percentile(0.99),
         h.max(),
         unit);
}

unsigned long long wide(std::uint64_t n) {
    return n;
}

}  // namespace

std::string to_json(const RunReport& r) {
    core::JsonWriter json;
    json.begin_object();
    json.field("behaviour", r.script);
    json.field("convergence", r.convergence);
    json.field("view", r.view);
    json.field("predictor", r.predictor);
    json.field("seed", r.seed);
    json.field("bots_asked", r.bots_asked);
    json.field("bots_joined", r.bots_joined);
    json.field("bots_lost", r.bots_lost);
    json.field("seconds", r.seconds);
    write_range(json, "down_bytes_per_s", r.down_bytes_per_s, false);
    write_range(json, "up_bytes_per_s", r.up_bytes_per_s, false);
    write_range(json, "down_stream_bytes_per_s", r.down_stream_bytes_per_s, false);
    write_range(json, "audit_bytes_per_s", r.audit_bytes_per_s, false);
    json.field("updates_per_s", r.updates_per_s);
    write_audit(json, r.audit);
    json.field("events_sent", r.events_sent);
    json.field("events_delivered", r.events_delivered);
    json.field("events_lost", r.events_lost);
    json.field("events_unheard", r.events_unheard);
    json.field("events_duplicated", r.events_duplicated);
    json.field("decisions_diverged", r.decisions_diverged);
    json.field("events_out_of_order", r.events_out_of_order);
    json.field("commands_sent", r.commands_sent);
    json.field("commands_resent", r.commands_resent);
    write_range(json, "event_spread_ms", r.event_spread_ms, true);
    write_range(json, "input_to_remote_display_ms", r.input_to_remote_display_ms, true);
    for (std::size_t i = 0; i < kStages; ++i) {
        write_range(json,
                    std::string("latency_") + stage_name(static_cast<Stage>(i)) + "_ms",
                    r.latency_stages_ms[i],
                    true);
    }
    json.field("latency_unknown", r.latency_unknown);
    json.field("input_changes_unseen", r.input_changes_unseen);
    write_range(json, "rtt_ms", r.rtt_ms, true);
    write_range(json, "clock_error_ms", r.clock_error_ms, true);
    json.field("clock_error_bound_ms", r.clock_bound_ms);
    write_range(json, "own_correction_m", r.own_correction_m, true);
    json.field("own_jumps", r.own_jump_m.count());
    json.field("own_jump_m_max", r.own_jump_m.max());
    write_range(json, "view_delay_ticks", r.view_delay_ticks, true);
    write_range(json, "input_lead_ticks", r.lead_ticks, true);
    write_transport(json, r);
    if (r.traffic.packets() > 0) {
        json.key("traffic").begin_object();
        wire::write_traffic(json, r.traffic, r.traffic_types);
        json.end_object();
    }
    json.field("freeze_asked", r.freeze_asked);
    json.field("frozen_bots", r.frozen_bots);
    json.field("converged_bots", r.converged_bots);
    write_findings(json, r.audit);
    json.key("troubles").begin_object();
    for (const auto& [text, count] : r.troubles) {
        json.field(text, count);
    }
    json.end_object();
    json.field("verdict", verdict_of(r));
    json.field("inconclusive", r.inconclusive);
    json.key("reasons").begin_array();
    for (const std::string& reason : r.reasons) {
        json.value(reason);
    }
    json.end_array();
    json.key("warnings").begin_array();
    for (const std::string& warning : r.warnings) {
        json.value(warning);
    }
    json.end_array();
    json.end_object();
    return json.text() + "\n";
}

std::string to_table(const RunReport& r) {
    std::string out;
    line(out,
         "bots %llu of %llu joined, %.1f s, %s",
         wide(r.bots_joined),
         wide(r.bots_asked),
         r.seconds,
         r.script.c_str());
    line(out, "  %-30s %10s %10s %10s", "", "p50", "p99", "max");
    row(out, "displayed position error", r.audit.displayed_m, "m");
    row(out, "predicted position error", r.audit.predicted_m, "m");
    row(out, "predicted orientation error", r.audit.predicted_rad, "rad");
    row(out, "age of news", r.audit.update_age_s, "s");
    row(out, "own correction", r.own_correction_m, "m");
    row(out, "round trip", r.rtt_ms, "ms");
    row(out, "clock error", r.clock_error_ms, "ms");
    row(out, "event spread", r.event_spread_ms, "ms");
    row(out, "input to remote display", r.input_to_remote_display_ms, "ms");
    for (std::size_t i = 0; i < kStages; ++i) {
        const std::string name = std::string("  of it: ") + stage_name(static_cast<Stage>(i));
        row(out, name.c_str(), r.latency_stages_ms[i], "ms");
    }
    row(out, "input lead", r.lead_ticks, "ticks");
    if (r.loop.turn_ms().count() > 0) {
        row(out, "turn of this process", r.loop.turn_ms(), "ms");
    }
    row(out, "down per bot (with headers)", r.down_bytes_per_s, "bytes/s");
    row(out, "up per bot (with headers)", r.up_bytes_per_s, "bytes/s");
    line(out,
         "  compared %llu samples (%llu after loss): %llu bound violations, %llu missing, %llu "
         "leaked",
         wide(r.audit.samples),
         wide(r.audit.samples_after_loss),
         wide(r.audit.position_violations + r.audit.orientation_violations),
         wide(r.audit.missing),
         wide(r.audit.extra));
    line(out,
         "  events %llu of %llu delivered, %llu doubled, %llu out of order",
         wide(r.events_delivered),
         wide(r.events_sent),
         wide(r.events_duplicated),
         wide(r.events_out_of_order));
    line(out,
         "  packets %llu received, %llu lost; %llu resumes, %llu view resets, %llu handoffs "
         "seen%s",
         wide(r.packets_received),
         wide(r.packets_lost),
         wide(r.resumed),
         wide(r.view_resets),
         wide(r.zone_changes),
         r.tunnelled_bots > 0 ? "; states TUNNELLED over TCP" : "");
    if (r.travels > 0) {
        line(out,
             "  %llu travels to another world, gap %.0f ms at p50, %.0f ms at p99",
             wide(r.travels),
             r.travel_gap_ms.percentile(0.5),
             r.travel_gap_ms.percentile(0.99));
    }
    if (r.bottleneck) {
        line(out,
             "  bottleneck down: %.0f %% used, queue %.1f ms at p95, %llu dropped",
             100.0 * r.bottleneck_utilisation,
             1e3 * r.bottleneck_wait_s.percentile(0.95),
             wide(r.bottleneck_dropped));
    }
    if (r.freeze_asked) {
        line(out,
             "  frozen world: %llu of %llu views converged exactly",
             wide(r.converged_bots),
             wide(r.auditing_bots));
    }
    for (const std::string& warning : r.warnings) {
        out += "  WARNING: " + warning + "\n";
    }
    return out;
}

}  // namespace zoned::measure
