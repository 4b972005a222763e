#include "server/session/overload_control.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::session {

namespace {

constexpr double kMemory_s = 1.0;
constexpr double kMoveEvery_s = 1.0;
constexpr double kEnds = 0.9;  // of max_load
constexpr double kCut = 0.8;
constexpr double kGrow = 1.25;
/// The cost of fewer sessions than this is as much that of joining, and of whoever else uses the
/// machine: it counts as if there were so many.
constexpr double kFew = 16.0;
/// So much more than clients cost before the first cut is no ceiling.
constexpr double kRoom = 2.0;

}  // namespace

void OverloadControl::measured(double load,
                               std::size_t sessions,
                               double bytes_per_s,
                               double floor,
                               double max_load,
                               double now_s) {
    if (measured_s_ < 0.0) {
        moved_s_ = now_s;
    }
    const double weight =
        measured_s_ < 0.0 ? 1.0 : 1.0 - elementary::exp((measured_s_ - now_s) / kMemory_s);
    measured_s_ = now_s;
    load_ += weight * (load - load_);
    sessions_ += weight * (static_cast<double>(sessions) - sessions_);
    bytes_per_s_ += weight * (bytes_per_s - bytes_per_s_);
    if (sessions == 0 && sessions_ < 0.5) {
        idle_load_ = load_;
    }
    if (refusing_) {
        admits(sessions, max_load);
    }
    if (now_s - moved_s_ >= kMoveEvery_s) {
        moved_s_ = now_s;
        move_ceiling(sessions, floor, max_load);
    }
}

double OverloadControl::expected(std::size_t sessions) const {
    const double per_session = std::max(0.0, load_ - idle_load_) / std::max(kFew, sessions_);
    return load_ + per_session * (static_cast<double>(sessions) - sessions_);
}

bool OverloadControl::admits(std::size_t sessions, double max_load) {
    // Somebody is always let in: where the world alone is too much, refusing all would not help.
    refusing_ = sessions > 0 && expected(sessions + 1) > (refusing_ ? kEnds : 1.0) * max_load;
    return !refusing_;
}

void OverloadControl::move_ceiling(std::size_t sessions, double floor, double max_load) {
    const double too_much = max_load + 0.5 * std::max(0.0, 1.0 - max_load);
    if (sessions > 0 && load_ > too_much) {
        const double mean = bytes_per_s_ / std::max(1.0, sessions_);
        usual_ = ceiling_ == kNoCeiling ? mean : usual_;
        ceiling_ = std::max(floor, kCut * std::min(ceiling_, mean));
    } else if (ceiling_ != kNoCeiling && load_ < kEnds * max_load) {
        ceiling_ *= kGrow;
        ceiling_ = ceiling_ > kRoom * std::max(usual_, floor) ? kNoCeiling : ceiling_;
    }
}

}  // namespace zoned::session
