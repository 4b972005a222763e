#include "client-sim/measure/corrections.h"

namespace zoned::measure {

void Corrections::add(Tick tick, double distance_m) {
    if (waiting_.size() >= kMaxWaiting) {
        waiting_.pop_front();
    }
    waiting_.push_back({tick, distance_m});
}

void Corrections::decide(Tick tick,
                         Tick discontinuity_tick,
                         core::Histogram& errors,
                         core::Histogram& jumps) {
    audited_ = true;
    while (!waiting_.empty() && waiting_.front().tick <= tick) {
        const PendingCorrection& c = waiting_.front();
        if (c.tick >= discontinuity_tick && jumped_tick_ < discontinuity_tick) {
            jumped_tick_ = discontinuity_tick;
            jumps.add(c.distance_m);
        } else {
            errors.add(c.distance_m);
        }
        waiting_.pop_front();
    }
}

void Corrections::finish(core::Histogram& errors) {
    for (const PendingCorrection& c : waiting_) {
        if (!audited_) {
            errors.add(c.distance_m);
        }
    }
    waiting_.clear();
}

}  // namespace zoned::measure
