#include "shared/wire/record/extrapolate.h"

#include "shared/wire/record/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::wire::record {

namespace {

/// Steps of `value`, a quantity in SI units, within a limit.
std::int32_t steps(double value, float step, std::int32_t limit) {
    const double whole = std::floor(value / static_cast<double>(step) + 0.5);
    return static_cast<std::int32_t>(
        std::clamp(whole, -static_cast<double>(limit), static_cast<double>(limit)));
}

/// Moves the orientation on by angular velocity, both in columns of their own quantisations.
void turn(const CodedRecord& base,
          double elapsed_s,
          const LevelFormat& from,
          const LevelFormat& to,
          QuantizedState& out) {
    const QuantizationLimits& before = from.limits;
    const QuantizationLimits& now = to.limits;
    const double rate = static_cast<double>(from.quantization.angular_velocity_step_rps);
    if (base.upright) {
        const double turns =
            (static_cast<double>(base.state.orientation[0]) / before.yaw_steps) +
            rate * base.state.angular_velocity[1] * elapsed_s / (2.0 * std::numbers::pi);
        const double whole = std::floor((turns - std::floor(turns)) * now.yaw_steps + 0.5);
        out.orientation = {static_cast<std::int32_t>(whole) % now.yaw_steps, 0, 0};
        return;
    }
    const std::array<std::int32_t, 3>& w = base.state.angular_velocity;
    const auto scale = static_cast<float>(rate * elapsed_s);
    const Rotation rotation = turned(rotation_of(base.state, before.orientation),
                                     {scale * static_cast<float>(w[0]),
                                      scale * static_cast<float>(w[1]),
                                      scale * static_cast<float>(w[2])});
    out.orientation_largest = greatest_component(rotation);
    out.orientation = smallest_three(rotation, out.orientation_largest, now.orientation);
}

}  // namespace

Columns extrapolate(const CodedRecord& base,
                    Tick tick,
                    std::uint8_t lod,
                    const RecordFormat& format) {
    const Quantization& from = format.levels[base.lod].quantization;
    const Quantization& to = format.levels[lod].quantization;
    const QuantizationLimits& limits = format.levels[lod].limits;
    const double elapsed_s =
        static_cast<double>(tick - base.tick) * static_cast<double>(format.tick_s);
    QuantizedState out = base.state;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double acceleration =
            static_cast<double>(from.acceleration_step_mps2) * base.state.acceleration[axis];
        if (axis == 1 && base.state.order == motion::PredictorOrder::kBallistic) {
            acceleration = -static_cast<double>(from.gravity_mps2);
        }
        const double velocity =
            static_cast<double>(from.velocity_step_mps) * base.state.velocity[axis];
        double place = static_cast<double>(from.position_step_m) * base.state.position[axis] +
                       (velocity + 0.5 * acceleration * elapsed_s) * elapsed_s;
        if (axis == 1 && base.state.order == motion::PredictorOrder::kBallistic) {
            place = std::max(place, static_cast<double>(from.position_step_m) * base.state.floor);
        }
        out.position[axis] =
            steps(place, to.position_step_m, axis == 1 ? limits.vertical : limits.horizontal);
        out.velocity[axis] =
            steps(velocity + acceleration * elapsed_s, to.velocity_step_mps, limits.velocity);
        out.acceleration[axis] =
            steps(acceleration, to.acceleration_step_mps2, limits.acceleration);
        const double rate = static_cast<double>(from.angular_velocity_step_rps);
        out.angular_velocity[axis] = steps(rate * base.state.angular_velocity[axis],
                                           to.angular_velocity_step_rps,
                                           limits.angular_velocity);
        out.turn[axis] = steps(
            rate * base.state.turn[axis], to.angular_velocity_step_rps, limits.angular_velocity);
    }
    out.floor = base.state.order == motion::PredictorOrder::kBallistic
                    ? steps(static_cast<double>(from.position_step_m) * base.state.floor,
                            to.position_step_m,
                            limits.vertical)
                    : out.position[1];
    turn(base, elapsed_s, format.levels[base.lod], format.levels[lod], out);
    return columns_of(out);
}

Columns beside(const CodedRecord& other, std::uint8_t lod, const RecordFormat& format) {
    const Quantization& from = format.levels[other.lod].quantization;
    const Quantization& to = format.levels[lod].quantization;
    const QuantizationLimits& limits = format.levels[lod].limits;
    QuantizedState out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        out.position[axis] =
            steps(static_cast<double>(from.position_step_m) * other.state.position[axis],
                  to.position_step_m,
                  axis == 1 ? limits.vertical : limits.horizontal);
    }
    out.floor = out.position[1];
    return columns_of(out);
}

}  // namespace zoned::wire::record
