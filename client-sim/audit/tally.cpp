#include "client-sim/audit/tally.h"

#include <algorithm>

namespace zoned::audit {

void Tally::add(const Finding& finding) {
    switch (finding.kind) {
        case FindingKind::kPosition:
            ++position_violations;
            break;
        case FindingKind::kOrientation:
            ++orientation_violations;
            break;
        case FindingKind::kMissing:
            ++missing;
            break;
        case FindingKind::kExtra:
            ++extra;
            break;
        case FindingKind::kField:
            ++field_violations;
            break;
    }
    const auto beyond = [](const Finding& f) {
        return f.error - f.allowed;
    };
    const auto place =
        std::upper_bound(worst.begin(), worst.end(), finding, [&](const auto& a, const auto& b) {
            return beyond(a) > beyond(b);
        });
    worst.insert(place, finding);
    if (worst.size() > kWorst) {
        worst.pop_back();
    }
}

}  // namespace zoned::audit
