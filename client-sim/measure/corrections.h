// Corrections: separates errors of a client's own prediction from jumps that it could not predict.
#pragma once

#include "shared/core/histogram.h"
#include "shared/core/ids.h"

#include <deque>

namespace zoned::measure {

/// Corrections of one bot. The server's own states do not report that the avatar was moved
/// elsewhere (a respawn, a teleport); audits do. So corrections wait for the next audit: the first
/// one at or after a discontinuity is a jump, all others are errors of the prediction.
class Corrections {
  public:
    /// Ticks ascend.
    void add(Tick tick, double distance_m);

    /// An audit of `tick`: the avatar was last moved elsewhere at `discontinuity_tick`.
    void decide(Tick tick,
                Tick discontinuity_tick,
                core::Histogram& errors,
                core::Histogram& jumps);

    /// The end of the run. Where no audit ever came, all corrections are errors. Otherwise
    /// corrections after the last audit are not counted.
    void finish(core::Histogram& errors);

    static constexpr std::size_t kMaxWaiting = 4096;

  private:
    struct PendingCorrection {
        Tick tick = 0;
        double distance_m = 0.0;
    };

    std::deque<PendingCorrection> waiting_;
    Tick jumped_tick_ = -1;  // newest discontinuity whose jump was seen
    bool audited_ = false;
};

}  // namespace zoned::measure
