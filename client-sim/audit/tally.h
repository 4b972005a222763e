// Tally: what audits have found, of one client or of many.
#pragma once

#include "shared/core/histogram.h"
#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::audit {

enum class FindingKind : std::uint8_t {
    kPosition,     ///< predicted position beyond the promised bound
    kOrientation,  ///< predicted orientation beyond the promised bound
    kMissing,      ///< must be known, is not in the view
    kExtra,        ///< in the view, must not be known: a leak
    kField,        ///< a declared field has another value, and had time to come
};

/// One departure from the promise.
struct Finding {
    FindingKind kind = FindingKind::kPosition;
    std::size_t client = 0;  ///< index of the client in its run
    Tick tick = 0;
    EntityId entity;
    std::string type;
    double error = 0.0;    ///< m or rad
    double allowed = 0.0;  ///< m or rad
    double age_s = 0.0;    ///< D
    double distance_m = 0.0;
    bool loss = false;
};

/// The findings of an auditor, or of all auditors of a run.
struct Tally {
    static constexpr std::size_t kWorst = 20;

    core::Histogram predicted_m;
    core::Histogram displayed_m;
    core::Histogram predicted_rad;
    core::Histogram displayed_rad;
    core::Histogram update_age_s;
    core::Histogram usual_age_s;  ///< the age on the same network path without any disturbance
    std::uint64_t records = 0;
    std::uint64_t samples = 0;
    std::uint64_t samples_after_loss = 0;  ///< of samples: judged with the allowance for a resend
    std::uint64_t samples_lost_again =
        0;                                ///< of these: with more than one resend, see update_age.h
    std::uint64_t samples_stale = 0;      ///< of samples: judged with an age that is_stale()
    std::uint64_t skipped_late = 0;       ///< records older than the history
    std::uint64_t skipped_unsettled = 0;  ///< records before clock and view had settled
    std::uint64_t skipped_undisplayed = 0;  ///< records of ticks that an interpolating view jumped
    std::uint64_t skipped_unmeasured = 0;   ///< records without any packet around
    std::uint64_t skipped_discontinuity = 0;  ///< samples within D after a spawn or teleport
    std::uint64_t skipped_leaving = 0;        ///< samples of entities whose removal was in flight
    std::uint64_t samples_widened = 0;  ///< of samples: under bounds that the server declared wider
    std::uint64_t samples_unbounded = 0;  ///< not judged: the server declared no bound
    /// Not judged: the budget delayed exactly these, and the client was notified that entities are
    /// missing.
    std::uint64_t missing_notified = 0;
    std::uint64_t position_violations = 0;
    std::uint64_t orientation_violations = 0;
    std::uint64_t missing = 0;
    std::uint64_t extra = 0;
    std::uint64_t malformed = 0;
    std::uint64_t field_samples = 0;  ///< values of declared fields
    std::uint64_t field_violations = 0;
    std::uint64_t field_recent = 0;    ///< not judged: changed so lately that it may be on its way
    std::uint64_t field_notified = 0;  ///< not judged: the client was notified that it is late
    std::uint64_t environment_samples = 0;     ///< values of clocks and shared variables
    std::uint64_t environment_violations = 0;  ///< of these: values that differ from the server's
    double environment_error_max = 0.0;
    std::vector<Finding> worst;  ///< by the excess over the allowed error, largest first

    void add(const Finding& finding);
};

}  // namespace zoned::audit
