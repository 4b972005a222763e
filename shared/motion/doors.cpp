#include "shared/motion/doors.h"

#include <algorithm>

namespace zoned::motion {

Tick Timetable::phase(Tick tick) const {
    // The remainder first: so nothing overflows, whatever the tick.
    const Tick at = tick % period + shift;
    return at < 0 ? at + period : at % period;
}

bool Timetable::open_at(Tick tick) const {
    if (tick == kAllDoorsOpen) {
        return true;
    }
    const Tick at = phase(tick);
    const auto behind = std::upper_bound(
        open.begin(), open.end(), at, [](Tick t, const OpenSpan& s) { return t < s.from; });
    return behind != open.begin() && at < std::prev(behind)->to;
}

Tick Timetable::next_change(Tick tick) const {
    const bool now = open_at(tick);
    const Tick at = phase(tick);
    Tick best = kNever;
    const auto consider = [&](Tick edge) {
        // 1 to `period` ticks ahead.
        const Tick ahead = edge > at ? edge - at : edge - at + period;
        if (ahead < best && open_at(tick + ahead) != now) {
            best = ahead;
        }
    };
    for (const OpenSpan& span : open) {
        consider(span.from);
        consider(span.to);
    }
    return best == kNever ? kNever : tick + best;
}

}  // namespace zoned::motion
