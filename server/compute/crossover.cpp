#include "server/compute/crossover.h"

#include <algorithm>
#include <cmath>

namespace zoned::compute {

namespace {

/// A device must be faster by this share: changing sides for less is not worth it, and the two
/// measured lines are no better known.
constexpr double kGain = 0.95;

}  // namespace

SideCost cost_through(std::size_t few, double few_us, std::size_t many, double many_us) {
    SideCost cost;
    const double span = static_cast<double>(many) - static_cast<double>(few);
    cost.item_us = span > 0.0 ? std::max(0.0, (many_us - few_us) / span) : 0.0;
    cost.launch_us = std::max(0.0, few_us - cost.item_us * static_cast<double>(few));
    return cost;
}

Side Crossover::choose(std::size_t items, bool hashed, bool exact) const {
    if (!measured_ || items == 0 || (hashed && !exact)) {
        return Side::kCpu;
    }
    return device_.of(items) < kGain * cpu_.of(items) ? Side::kDevice : Side::kCpu;
}

std::size_t Crossover::threshold() const {
    if (!measured_) {
        return SIZE_MAX;
    }
    // device.launch + n device.item < kGain (cpu.launch + n cpu.item)
    const double start = device_.launch_us - kGain * cpu_.launch_us;
    const double gain = kGain * (cpu_.item_us + cpu_.copy_us) - device_.item_us - device_.copy_us;
    if (start < 0.0 && gain >= 0.0) {
        return 1;
    }
    if (gain <= 0.0) {
        return SIZE_MAX;
    }
    return static_cast<std::size_t>(std::floor(start / gain)) + 1;
}

}  // namespace zoned::compute
