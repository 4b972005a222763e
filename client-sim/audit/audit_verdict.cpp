#include "client-sim/audit/audit_verdict.h"

#include <cstdio>

namespace zoned::audit {

namespace {

/// Above this share of stale samples the verdict warns; where most are stale, it shows nothing.
constexpr double kStaleWarning = 0.05;
constexpr double kStaleShare = 0.5;

/// The worst finding of a kind, in words.
std::string worst_of(const Tally& tally, FindingKind kind) {
    for (const Finding& f : tally.worst) {
        if (f.kind == kind) {
            return " (worst: client " + std::to_string(f.client) + ", tick " +
                   std::to_string(f.tick) + ", entity " + std::to_string(f.entity.value) + " " +
                   f.type + ": " + number_text(f.error) + ", allowed " + number_text(f.allowed) +
                   ")";
        }
    }
    return {};
}

void judge_audit(const Tally& t, bool expected, AuditVerdict& v) {
    if (expected && t.samples == 0) {
        v.reasons.push_back(
            t.records == 0
                ? "nothing was compared: no audit came (does the ticket carry the right to audit, "
                  "are audits on?)"
                : "nothing was compared: " + count_of(t.records, "audit", "audits") +
                      " came, and nobody ever had anything to compare in view (have the types of "
                      "players a nimbus?)");
    }
    if (t.position_violations > 0) {
        v.reasons.push_back("bound: " + count_of(t.position_violations, "position", "positions") +
                            " beyond the promised bound" + worst_of(t, FindingKind::kPosition));
    }
    if (t.orientation_violations > 0) {
        v.reasons.push_back(
            "bound: " + count_of(t.orientation_violations, "orientation", "orientations") +
            " beyond the promised bound" + worst_of(t, FindingKind::kOrientation));
    }
    if (t.missing > 0) {
        v.reasons.push_back("missing: " + count_of(t.missing, "entity", "entities") +
                            " that ought to be known" + worst_of(t, FindingKind::kMissing));
    }
    if (t.extra > 0) {
        v.reasons.push_back("leak: " + count_of(t.extra, "entity", "entities") +
                            " in a view that must not know them" +
                            worst_of(t, FindingKind::kExtra));
    }
    if (t.field_violations > 0) {
        v.reasons.push_back("fields: " + count_of(t.field_violations, "value", "values") +
                            " of declared fields other than the server's" +
                            worst_of(t, FindingKind::kField));
    }
    if (t.environment_violations > 0) {
        v.reasons.push_back(
            "shared environment: " + count_of(t.environment_violations, "value", "values") +
            " of shared clocks or shared variables other than the server's (by up to " +
            number_text(t.environment_error_max) + ")");
    }
    if (t.malformed > 0) {
        v.reasons.push_back(count_of(t.malformed, "malformed audit", "malformed audits"));
    }
}

/// A comparison says little when its allowance grew with the age of the updates.
void judge_staleness(const Tally& t, AuditVerdict& v) {
    if (t.samples == 0) {
        return;
    }
    const double share = static_cast<double>(t.samples_stale) / static_cast<double>(t.samples);
    if (share <= kStaleWarning) {
        return;
    }
    const std::string text =
        "stale: " + number_text(100.0 * share) +
        " % of the samples were compared with news older than the paths explain (" +
        number_text(t.update_age_s.percentile(0.99)) + " s at p99, usual were " +
        number_text(t.usual_age_s.percentile(0.99)) +
        " s), so what was allowed is large: is a machine overloaded, or the network cut?";
    (share > kStaleShare ? v.reasons : v.warnings).push_back(text);
}

/// A client without a declared bound gets no false promise, but no promise either.
void judge_pressure(const Tally& t, AuditVerdict& v) {
    const double all = static_cast<double>(t.samples + t.samples_unbounded);
    const double share = all > 0.0 ? static_cast<double>(t.samples_unbounded) / all : 0.0;
    if (share > kStaleWarning || t.missing_notified > 0) {
        const std::string text = "pressure: " + number_text(100.0 * share) +
                                 " % of the samples without a bound, " +
                                 count_of(t.missing_notified, "entity", "entities") +
                                 " told to be missing: the budget or the path is too narrow";
        (share > kStaleShare ? v.reasons : v.warnings).push_back(text);
    }
}

}  // namespace

std::string number_text(double value) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.4g", value);
    return text;
}

std::string count_of(std::uint64_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

void SessionFaults::add(const view::Player& player) {
    const link::Client& client = player.client();
    events_lost += client.events().lost();
    events_duplicated += client.events().duplicated();
    events_out_of_order += client.events().out_of_order();
    server_silences += client.datagrams().server_silences;
    sessions_lost += client.stats().sessions_lost;
    malformed += client.datagrams().malformed + client.stats().malformed_frames;
    if (player.view() != nullptr) {
        const view::ViewStats& stats = player.view()->stats();
        malformed_records +=
            stats.malformed_records + stats.undecoded_packets + stats.environment_malformed;
        for (std::size_t fault = 0; fault < wire::kDeclaredFaults; ++fault) {
            refused_fields[fault] += stats.refused_fields[fault];
        }
    }
}

std::string AuditVerdict::text() const {
    std::string text = reasons.empty() ? "consistent" : "inconsistent";
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        text += (i == 0 ? ": " : "; ") + reasons[i];
    }
    return text;
}

void judge(const Tally& tally, bool expected, AuditVerdict& verdict) {
    judge_audit(tally, expected, verdict);
    judge_staleness(tally, verdict);
    judge_pressure(tally, verdict);
}

void judge(const SessionFaults& faults, AuditVerdict& v) {
    if (faults.events_lost > 0) {
        v.reasons.push_back("events: " + std::to_string(faults.events_lost) + " lost");
    }
    if (faults.events_duplicated > 0) {
        v.reasons.push_back("events: " + std::to_string(faults.events_duplicated) +
                            " delivered twice");
    }
    if (faults.events_out_of_order > 0) {
        v.reasons.push_back("events: " + std::to_string(faults.events_out_of_order) +
                            " out of order");
    }
    if (faults.server_silences > 0) {
        v.reasons.push_back("stall: the server was silent for too long " +
                            count_of(faults.server_silences, "time", "times"));
    }
    if (faults.sessions_lost > 0) {
        v.reasons.push_back("sessions: " + std::to_string(faults.sessions_lost) +
                            " could not be resumed");
    }
    if (const std::uint64_t malformed = faults.malformed + faults.malformed_records;
        malformed > 0) {
        v.reasons.push_back("wire: " + std::to_string(malformed) + " malformed packets or records");
        for (std::size_t fault = 1; fault < wire::kDeclaredFaults; ++fault) {
            if (faults.refused_fields[fault] > 0) {
                v.reasons.back() += ", " + std::to_string(faults.refused_fields[fault]) + " for " +
                                    wire::kDeclaredFaultTexts[fault];
            }
        }
    }
}

}  // namespace zoned::audit
