// audit_verdict: the reasons against consistency that audits and sessions give, for one client and
// for a run of many.
#pragma once

#include "client-sim/audit/tally.h"
#include "client-sim/view/player.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::audit {

/// Faults of the server that clients noticed in their sessions.
struct SessionFaults {
    std::uint64_t events_lost = 0;  ///< numbers passed over
    std::uint64_t events_duplicated = 0;
    std::uint64_t events_out_of_order = 0;
    std::uint64_t server_silences = 0;
    std::uint64_t sessions_lost = 0;
    std::uint64_t malformed = 0;  ///< packets and frames
    std::uint64_t malformed_records = 0;
    std::array<std::uint64_t, wire::kDeclaredFaults> refused_fields{};  ///< why, of declared fields

    void add(const view::Player& player);
};

struct AuditVerdict {
    std::vector<std::string> reasons;   ///< against consistency
    std::vector<std::string> warnings;  ///< circumstances that weaken a good verdict

    /// "consistent", or "inconsistent" with its reasons.
    [[nodiscard]] std::string text() const;
};

/// `expected`: nothing compared is a reason as well.
void judge(const Tally& tally, bool expected, AuditVerdict& verdict);
void judge(const SessionFaults& faults, AuditVerdict& verdict);

/// "1 entity" or "2 entities".
[[nodiscard]] std::string count_of(std::uint64_t n,
                                   const std::string& one,
                                   const std::string& many);
/// Four digits that count.
[[nodiscard]] std::string number_text(double value);

}  // namespace zoned::audit
