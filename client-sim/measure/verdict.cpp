#include "client-sim/audit/audit_verdict.h"
#include "client-sim/measure/run_report.h"

namespace zoned::measure {

namespace {

using audit::count_of;
using audit::number_text;

/// Allowance beyond the error bound of the clocks, for the granularity of polling.
constexpr double kClockSlackMs = 5.0;
/// Above this share of the run in turns longer than a tick the bots were the bottleneck, and what
/// they found wrong may be their own doing.
constexpr double kLateLoop = 0.05;

/// By the rules for one client.
void judge_clients(RunReport& r) {
    audit::AuditVerdict verdict;
    audit::judge(r.audit, r.audits_expected, verdict);
    audit::judge(static_cast<const audit::SessionFaults&>(r), verdict);
    r.reasons.insert(r.reasons.end(), verdict.reasons.begin(), verdict.reasons.end());
    r.warnings.insert(r.warnings.end(), verdict.warnings.begin(), verdict.warnings.end());
}

void judge_events(RunReport& r) {
    if (r.events_unheard > 0) {
        r.reasons.push_back("events: " + std::to_string(r.events_unheard) +
                            " to everybody not heard by somebody");
    }
    if (r.decisions_diverged > 0) {
        r.reasons.push_back("decisions: " + std::to_string(r.decisions_diverged) +
                            " that a client did not hold as they were made");
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
    judge_clients(r);
    judge_events(r);
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
        r.reasons.push_back("clock: error of " + number_text(clock_ms) + " ms at p99, " +
                            number_text(r.clock_bound_ms) + " ms are possible by the round trips");
    }
    judge_frozen(r);
    r.consistent = r.reasons.empty();
    r.inconclusive.clear();
    // A promise that was kept all the same was kept.
    if (!r.consistent && r.loop.late_share() > kLateLoop) {
        r.inconclusive = "the bots were the bottleneck: for " +
                         number_text(100.0 * r.loop.late_share()) +
                         " % of the run this process served them less than once a tick (turns of " +
                         number_text(r.loop.turn_ms().percentile(0.99)) +
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
