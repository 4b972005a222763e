// ZoneBalance: notices that one zone has much more to do than the others, because players gather
// there.
#pragma once

#include "server/app/runtime/tick_loop.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

namespace zoned::app {

/// Fixed zones serve an even spread of players. Where one takes more than half of a tick's time and
/// twice what the others take on average, the world is full long before its machine is.
class ZoneBalance {
  public:
    /// Call about once a second with the zones after their last tick, and the period of a tick. The
    /// zone that has too much to do, once in ten minutes at most.
    std::optional<std::size_t> look(std::span<const ZoneSample> zones,
                                    double period_s,
                                    double now_s) {
        step_ms_.resize(zones.size());
        for (std::size_t z = 0; z < zones.size(); ++z) {
            step_ms_[z] += kSmooth * (1e-6 * static_cast<double>(zones[z].step_ns) - step_ms_[z]);
        }
        if (zones.size() < 2 || now_s - logged_s_ < kTellEvery_s) {
            return std::nullopt;
        }
        const auto fullest = static_cast<std::size_t>(
            std::max_element(step_ms_.begin(), step_ms_.end()) - step_ms_.begin());
        if (step_ms_[fullest] < kPartOfPeriod * 1e3 * period_s ||
            step_ms_[fullest] < kTimesTheOthers * others_ms(fullest)) {
            return std::nullopt;
        }
        logged_s_ = now_s;
        return fullest;
    }

    /// Mean time of a step of a zone over about the last ten seconds, ms.
    [[nodiscard]] double step_ms(std::size_t zone) const { return step_ms_[zone]; }

    /// Mean over all zones but one, ms.
    [[nodiscard]] double others_ms(std::size_t zone) const {
        const double all = std::accumulate(step_ms_.begin(), step_ms_.end(), 0.0);
        return (all - step_ms_[zone]) / static_cast<double>(step_ms_.size() - 1);
    }

  private:
    static constexpr double kTellEvery_s = 600.0;
    static constexpr double kSmooth = 0.1;  ///< share of a new sample: some ten seconds
    static constexpr double kPartOfPeriod = 0.5;
    static constexpr double kTimesTheOthers = 2.0;

    std::vector<double> step_ms_;
    double logged_s_ = -1e9;
};

}  // namespace zoned::app
