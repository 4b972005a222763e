#include "server/zone/assemblies/assembly_def.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::zone {

namespace {

float on_ramps(const std::vector<MotorTarget::RampPoint>& points, double time_s) {
    const auto after = std::upper_bound(
        points.begin(), points.end(), time_s, [](double t, const MotorTarget::RampPoint& p) {
            return t < p.at_s;
        });
    if (after == points.begin()) {
        return points.front().value;
    }
    if (after == points.end()) {
        return points.back().value;
    }
    const MotorTarget::RampPoint& before = *(after - 1);
    const double share = (time_s - before.at_s) / (after->at_s - before.at_s);
    return before.value + static_cast<float>(share) * (after->value - before.value);
}

}  // namespace

float MotorTarget::at(double time_s) const {
    switch (form) {
        case Form::kConstant:
            break;
        case Form::kSine: {
            const double turns = time_s / period_s;
            const double angle = 2.0 * std::numbers::pi * (turns - std::floor(turns)) + phase_rad;
            return mean + amplitude * static_cast<float>(elementary::sin(angle));
        }
        case Form::kRamps:
            return on_ramps(
                points,
                period_s > 0.0 ? time_s - period_s * std::floor(time_s / period_s) : time_s);
    }
    return mean;
}

bool MotorTarget::changes_after(double time_s) const {
    switch (form) {
        case Form::kConstant:
            break;
        case Form::kSine:
            return true;
        case Form::kRamps:
            return period_s > 0.0 || time_s < points.back().at_s;
    }
    return false;
}

}  // namespace zoned::zone
