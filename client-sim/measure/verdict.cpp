#include "client-sim/measure/run_report.h"

#include <cmath>
#include <cstdio>

namespace zoned::measure {

namespace {

/// Allowance beyond the error bound of the clocks, for the granularity of polling.
constexpr double kClockSlackMs = 5.0;
/// Above this share of stale samples the verdict warns; where most are stale, it shows nothing.
constexpr double kStaleWarning = 0.05;
constexpr double kStaleShare = 0.5;
/// Above this share of the run in turns longer than a tick the bots were the bottleneck, and what
/// they found wrong may be their own doing.
constexpr double kLateLoop = 0.05;

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.4g", value);
    return text;
}

std::string count_of(std::uint64_t n, const std::string& one, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// The worst finding of a kind, in words.
std::string worst_of(const Tally& tally, FindingKind kind) {
    for (const Finding& f : tally.worst) {
        if (f.kind == kind) {
            return " (worst: bot " + std::to_string(f.bot) + ", tick " + std::to_string(f.tick) +
                   ", entity " + std::to_string(f.entity.value) + " " + f.type + ": " +
                   number(f.error) + ", allowed " + number(f.allowed) + ")";
        }
    }
    return {};
}

void judge_audit(RunReport& r) {
    const Tally& t = r.audit;
    if (r.audits_expected && t.samples == 0) {
        r.reasons.push_back(
            "nothing was compared: no audit came (does the ticket carry the right to audit, are "
            "audits on?)");
    }
    if (t.position_violations > 0) {
        r.reasons.push_back("bound: " + count_of(t.position_violations, "position", "positions") +
                            " beyond the promised bound" + worst_of(t, FindingKind::kPosition));
    }
    if (t.orientation_violations > 0) {
        r.reasons.push_back(
            "bound: " + count_of(t.orientation_violations, "orientation", "orientations") +
            " beyond the promised bound" + worst_of(t, FindingKind::kOrientation));
    }
    if (t.missing > 0) {
        r.reasons.push_back("missing: " + count_of(t.missing, "entity", "entities") +
                            " that ought to be known" + worst_of(t, FindingKind::kMissing));
    }
    if (t.extra > 0) {
        r.reasons.push_back("leak: " + count_of(t.extra, "entity", "entities") +
                            " in a view that must not know them" +
                            worst_of(t, FindingKind::kExtra));
    }
    if (t.field_violations > 0) {
        r.reasons.push_back("fields: " + count_of(t.field_violations, "value", "values") +
                            " of declared fields other than the server's" +
                            worst_of(t, FindingKind::kField));
    }
    if (t.environment_violations > 0) {
        r.reasons.push_back(
            "shared environment: " + count_of(t.environment_violations, "value", "values") +
            " of shared clocks or shared variables other than the server's (by up to " +
            number(t.environment_error_max) + ")");
    }
    if (t.malformed > 0) {
        r.reasons.push_back(count_of(t.malformed, "malformed audit", "malformed audits"));
    }
}

/// A comparison says little when its allowance grew with the age of the updates.
void judge_staleness(RunReport& r) {
    const Tally& t = r.audit;
    if (t.samples == 0) {
        return;
    }
    const double share = static_cast<double>(t.samples_stale) / static_cast<double>(t.samples);
    if (share <= kStaleWarning) {
        return;
    }
    const std::string text =
        "stale: " + number(100.0 * share) +
        " % of the samples were compared with news older than the paths explain (" +
        number(t.update_age_s.percentile(0.99)) + " s at p99, usual were " +
        number(t.usual_age_s.percentile(0.99)) +
        " s), so what was allowed is large: is a machine overloaded, or the network cut?";
    (share > kStaleShare ? r.reasons : r.warnings).push_back(text);
}

/// A client without a declared bound gets no false promise, but no promise either.
void judge_pressure(RunReport& r) {
    const Tally& t = r.audit;
    const double all = static_cast<double>(t.samples + t.samples_unbounded);
    const double share = all > 0.0 ? static_cast<double>(t.samples_unbounded) / all : 0.0;
    if (share > kStaleWarning || t.missing_notified > 0) {
        const std::string text = "pressure: " + number(100.0 * share) +
                                 " % of the samples without a bound, " +
                                 count_of(t.missing_notified, "entity", "entities") +
                                 " told to be missing: the budget or the path is too narrow";
        (share > kStaleShare ? r.reasons : r.warnings).push_back(text);
    }
}

void judge_events(RunReport& r) {
    if (r.events_lost > 0) {
        r.reasons.push_back("events: " + std::to_string(r.events_lost) + " lost");
    }
    if (r.events_unheard > 0) {
        r.reasons.push_back("events: " + std::to_string(r.events_unheard) +
                            " to everybody not heard by somebody");
    }
    if (r.decisions_diverged > 0) {
        r.reasons.push_back("decisions: " + std::to_string(r.decisions_diverged) +
                            " that a client did not hold as they were made");
    }
    if (r.events_duplicated > 0) {
        r.reasons.push_back("events: " + std::to_string(r.events_duplicated) + " delivered twice");
    }
    if (r.events_out_of_order > 0) {
        r.reasons.push_back("events: " + std::to_string(r.events_out_of_order) + " out of order");
    }
}

void judge_frozen(RunReport& r) {
    if (!r.freeze_asked) {
        return;
    }
    if (r.frozen_bots == 0) {
        r.reasons.push_back("frozen: no record of the frozen world came");
    } else if (r.converged_bots < r.auditing_bots) {
        r.reasons.push_back(
            "frozen: " + count_of(r.auditing_bots - r.converged_bots, "view", "views") +
            " did not converge to the server's state" +
            (r.frozen_difference.empty() ? "" : " (" + r.frozen_difference + ")"));
    }
}

}  // namespace

void judge(RunReport& r) {
    r.reasons.clear();
    r.warnings.clear();
    if (r.bots_joined < r.bots_asked || r.bots_joined == 0) {
        r.reasons.push_back("joined: " + std::to_string(r.bots_joined) + " of " +
                            std::to_string(r.bots_asked) + " bots" +
                            (r.troubles.empty() ? "" : " (" + r.troubles.begin()->first + ")"));
    }
    if (r.bots_lost > 0) {
        r.reasons.push_back("lost: " + count_of(r.bots_lost, "session", "sessions") +
                            " ended before the run" +
                            (r.troubles.empty() ? "" : " (" + r.troubles.begin()->first + ")"));
    }
    judge_audit(r);
    judge_staleness(r);
    judge_pressure(r);
    judge_events(r);
    if (r.server_silences > 0) {
        r.reasons.push_back("stall: the server was silent for too long " +
                            count_of(r.server_silences, "time", "times"));
    }
    if (r.clock_set_backs > 0) {
        // Its clients waited, and their views went back with it: no promise was broken.
        r.warnings.push_back("stall: the server dropped ticks and set its clock back, as " +
                             count_of(r.clock_set_backs, "view", "views") + " noticed");
    }
    if (r.recovered > 0) {
        r.warnings.push_back("crash: the server died and came back, as " +
                             count_of(r.recovered, "client", "clients") + " noticed");
    }
    if (r.silent_bots > 0) {
        r.reasons.push_back("stall: " + count_of(r.silent_bots, "client", "clients") +
                            " heard nothing at the end of the run");
    }
    if (r.sessions_lost > 0) {
        r.reasons.push_back("sessions: " + std::to_string(r.sessions_lost) +
                            " could not be resumed");
    }
    if (r.malformed > 0 || r.malformed_records > 0) {
        r.reasons.push_back("wire: " + std::to_string(r.malformed + r.malformed_records) +
                            " malformed packets or records");
        for (std::size_t fault = 1; fault < wire::kDeclaredFaults; ++fault) {
            if (r.refused_fields[fault] > 0) {
                r.reasons.back() += ", " + std::to_string(r.refused_fields[fault]) + " for " +
                                    wire::kDeclaredFaultTexts[fault];
            }
        }
    }
    if (r.bursts_malformed > 0) {
        r.reasons.push_back("particles: " + count_of(r.bursts_malformed, "burst", "bursts") +
                            " that no client can replay");
    }
    if (r.bursts_refused > 0) {
        r.warnings.push_back("particles: " + count_of(r.bursts_refused, "burst", "bursts") +
                             " more than a client displays at a time");
    }
    const double clock_ms = r.clock_error_ms.percentile(0.99);
    if (clock_ms > r.clock_bound_ms + kClockSlackMs) {
        r.reasons.push_back("clock: error of " + number(clock_ms) + " ms at p99, " +
                            number(r.clock_bound_ms) + " ms are possible by the round trips");
    }
    judge_frozen(r);
    r.consistent = r.reasons.empty();
    r.inconclusive.clear();
    // A promise that was kept all the same was kept.
    if (!r.consistent && r.loop.late_share() > kLateLoop) {
        r.inconclusive = "the bots were the bottleneck: for " +
                         number(100.0 * r.loop.late_share()) +
                         " % of the run this process served them less than once a tick (turns of " +
                         number(r.loop.turn_ms().percentile(0.99)) +
                         " ms at p99): take fewer bots, or a machine of their own";
    }
}

const char* verdict_of(const RunReport& report) {
    if (!report.inconclusive.empty()) {
        return "inconclusive";
    }
    return report.consistent ? "consistent" : "inconsistent";
}

}  // namespace zoned::measure
