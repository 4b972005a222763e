#include "shared/wire/quantize.h"

#include "shared/core/elementary/elementary.h"

#include <cmath>
#include <numbers>

namespace zoned::wire {
namespace {

std::int32_t limit_of(float maximum, float step) {
    const double steps = static_cast<double>(maximum) / static_cast<double>(step);
    if (!(steps >= 1.0)) {
        return 1;
    }
    return steps >= kMaxQuantizedIndex ? kMaxQuantizedIndex
                                       : static_cast<std::int32_t>(std::lrint(steps));
}

std::int32_t quantize_component(float value, float step, std::int32_t limit) {
    const double steps = static_cast<double>(value) / static_cast<double>(step);
    if (std::isnan(steps)) {
        return 0;
    }
    const double clamped = std::clamp<double>(steps, -limit, limit);
    return static_cast<std::int32_t>(std::lrint(clamped));
}

float dequantize_component(std::int32_t index, float step) {
    return static_cast<float>(static_cast<double>(index) * static_cast<double>(step));
}

std::array<std::int32_t, 3> quantize_vector(const Vec3& v, float step, std::int32_t limit) {
    return {quantize_component(v.x(), step, limit),
            quantize_component(v.y(), step, limit),
            quantize_component(v.z(), step, limit)};
}

Vec3 dequantize_vector(const std::array<std::int32_t, 3>& v, float step) {
    return {dequantize_component(v[0], step),
            dequantize_component(v[1], step),
            dequantize_component(v[2], step)};
}

bool is_zero(const std::array<std::int32_t, 3>& v) {
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

// ---------------------------------------------------------------- upright

/// The turn about y that is nearest to an orientation is its twist (the w and y parts).
std::int32_t quantize_yaw(const Quat& orientation, std::int32_t steps) {
    const double half_angle = elementary::atan2(static_cast<double>(orientation.y()),
                                                static_cast<double>(orientation.w()));
    if (std::isnan(half_angle)) {
        return 0;
    }
    const long index = std::lrint(half_angle / std::numbers::pi * steps);
    return static_cast<std::int32_t>(index & (steps - 1));
}

Quat dequantize_yaw(std::int32_t yaw, std::int32_t steps) {
    // A turn of more than half is replaced by the shorter one, so that w is never negative.
    const std::int32_t short_path = yaw >= steps / 2 ? yaw - steps : yaw;
    const double half_angle = std::numbers::pi * short_path / steps;
    const auto [sine, cosine] = elementary::sincos(half_angle);
    return {static_cast<float>(cosine), 0.0F, static_cast<float>(sine), 0.0F};
}

// ---------------------------------------------------------------- smallest three

/// A quaternion on the grid: all four components in units of 1 / (limit sqrt 2), so that 1 / sqrt
/// 2, the most that a component can be without being the largest, is `limit` units. The component
/// at `largest` is not stored; its square in units is the integer 2 limit^2 - (sum of the others').
struct GridOrientation {
    std::array<std::int32_t, 4> n{};  ///< w, x, y, z
    int largest = 0;
};

std::int32_t left_out_squared(const GridOrientation& g, std::int32_t limit) {
    std::int32_t sum = 0;
    for (int j = 0; j < 4; ++j) {
        sum += j == g.largest ? 0 : g.n[j] * g.n[j];
    }
    return 2 * limit * limit - sum;
}

/// round(sqrt(square)), exactly: (r + 1/2)^2 = r^2 + r + 1/4 lies between integers, so there is
/// never a tie.
std::int32_t rounded_root(std::int32_t square) {
    auto r = static_cast<std::int32_t>(std::sqrt(static_cast<double>(square)));
    return square > r * r + r ? r + 1 : r;
}

/// Index of the first component of greatest magnitude among those that are stored.
int greatest_stored(const GridOrientation& g) {
    int best = -1;
    for (int j = 0; j < 4; ++j) {
        if (j != g.largest && (best < 0 || std::abs(g.n[j]) > std::abs(g.n[best]))) {
            best = j;
        }
    }
    return best;
}

bool is_canonical(const GridOrientation& g, std::int32_t limit) {
    const std::int32_t square = left_out_squared(g, limit);
    if (square < 0) {
        return false;
    }
    const std::int32_t root = rounded_root(square);
    const int j = greatest_stored(g);
    const std::int32_t other = std::abs(g.n[j]);
    return other < root || (other == root && j > g.largest);
}

/// Brings a grid orientation (left_out_squared >= 0) into canonical form. One exchange is enough.
/// Let L be the root and r = round(L). If n_j > r is exchanged, the new left-out component has
/// L'^2 = L^2 + n_j^2 - r^2 >= n_j^2 - r + 1/4 > (n_j - 1/2)^2, so it rounds to n_j at least, which
/// was the first greatest. If n_j = r with j < i, then L' = L and the first of the equals is left
/// out.
void make_canonical(GridOrientation& g, std::int32_t limit) {
    if (is_canonical(g, limit)) {
        return;
    }
    const int j = greatest_stored(g);
    g.n[g.largest] = rounded_root(left_out_squared(g, limit));
    if (g.n[j] < 0) {
        for (std::int32_t& n : g.n) {
            n = -n;
        }
    }
    g.largest = j;
}

std::array<double, 4> components(const GridOrientation& g, std::int32_t limit) {
    const double unit = 1.0 / (limit * std::numbers::sqrt2);
    std::array<double, 4> q{};
    for (int j = 0; j < 4; ++j) {
        q[j] = j == g.largest ? std::sqrt(static_cast<double>(left_out_squared(g, limit))) * unit
                              : g.n[j] * unit;
    }
    return q;
}

/// Chooses the nearest of the canonical forms that rounding leads to. Two different canonical
/// orientations are at least half a unit apart: with the same component left out they differ in an
/// integer; otherwise, were both left-out components to round to what the other form stores, each
/// form would claim its own component to be the first greatest. A canonical orientation that comes
/// back from floats is off by less than a hundredth of a unit, so it is its own nearest, and
/// its left-out component is within two units of the greatest: quantising is idempotent.
GridOrientation nearest_grid_orientation(const std::array<double, 4>& q, std::int32_t limit) {
    constexpr std::int32_t kNearlyGreatest = 4;
    std::array<std::int32_t, 4> rounded{};
    std::int32_t greatest = 0;
    for (int j = 0; j < 4; ++j) {
        rounded[j] = static_cast<std::int32_t>(std::lrint(q[j] * limit * std::numbers::sqrt2));
        greatest = std::max(greatest, std::abs(rounded[j]));
    }
    GridOrientation best;
    double best_dot = -1.0;
    for (int i = 0; i < 4; ++i) {
        if (std::abs(rounded[i]) < greatest - kNearlyGreatest) {
            continue;
        }
        GridOrientation candidate;
        candidate.largest = i;
        for (int j = 0; j < 4; ++j) {
            const std::int32_t n = rounded[i] < 0 ? -rounded[j] : rounded[j];
            candidate.n[j] = std::clamp(n, -limit, limit);
        }
        if (left_out_squared(candidate, limit) < 0) {
            continue;
        }
        make_canonical(candidate, limit);
        const std::array<double, 4> c = components(candidate, limit);
        const double dot = std::abs(c[0] * q[0] + c[1] * q[1] + c[2] * q[2] + c[3] * q[3]);
        if (dot > best_dot) {
            best = candidate;
            best_dot = dot;
        }
    }
    return best;
}

void quantize_smallest_three(const Quat& orientation, std::int32_t limit, QuantizedState& out) {
    std::array<double, 4> q{orientation.w(), orientation.x(), orientation.y(), orientation.z()};
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(norm > 0.0) || !std::isfinite(norm)) {
        return;  // The identity is all zeros: w is left out.
    }
    for (double& component : q) {
        component /= norm;
    }
    const GridOrientation g = nearest_grid_orientation(q, limit);
    out.orientation_largest = g.largest;
    int slot = 0;
    for (int j = 0; j < 4; ++j) {
        if (j != g.largest) {
            out.orientation[slot++] = g.n[j];
        }
    }
}

GridOrientation grid_orientation(std::int32_t largest,
                                 const std::array<std::int32_t, 3>& smallest_three) {
    GridOrientation g;
    g.largest = largest;
    int slot = 0;
    for (int j = 0; j < 4; ++j) {
        g.n[j] = j == largest ? 0 : smallest_three[slot++];
    }
    return g;
}

}  // namespace

RateSteps rate_steps(float position_bound_m, float orientation_bound_rad, float horizon_s) {
    const auto power_below = [](float step, float least, float most) {
        int exponent = 0;
        std::frexp(step, &exponent);  // step = [0.5, 1) 2^exponent
        return std::clamp(std::ldexp(1.0F, exponent - 1), least, most);
    };
    return {power_below(0.5F * position_bound_m / horizon_s, 0x1p-10F, 1.0F),
            power_below(position_bound_m / (horizon_s * horizon_s), 0x1p-8F, 8.0F),
            power_below(0.5F * orientation_bound_rad / horizon_s, 0x1p-10F, 1.0F)};
}

Quantization at_lod(const Quantization& q, std::uint8_t lod) {
    const LodShift shift = q.lod_shift[std::min<std::size_t>(lod, kLods - 1)];
    Quantization out = q;
    out.lod_shift = {};
    if (shift == LodShift{}) {
        return out;
    }
    const auto coarser = [](float step, int by, float most) {
        return std::min(std::ldexp(step, by), std::max(step, most));
    };
    out.position_step_m = coarser(q.position_step_m, shift.place, 1.0F);
    out.velocity_step_mps = coarser(q.velocity_step_mps, shift.place, 1.0F);
    out.acceleration_step_mps2 = coarser(q.acceleration_step_mps2, shift.place, 10.0F);
    out.angular_velocity_step_rps = coarser(q.angular_velocity_step_rps, shift.turn, 10.0F);
    out.orientation_bits =
        std::max(std::min(q.orientation_bits, 5), q.orientation_bits - shift.turn);
    out.yaw_bits = std::max(std::min(q.yaw_bits, 5), q.yaw_bits - shift.turn);
    return out;
}

LodShift lod_shift(float nearest_position_m,
                   float nearest_orientation_rad,
                   float position_m,
                   float orientation_rad) {
    const auto doublings = [](float ratio, int most) {
        int exponent = 0;
        std::frexp(ratio, &exponent);  // ratio = [0.5, 1) 2^exponent
        return static_cast<std::uint8_t>(std::clamp(exponent - 1, 0, most));
    };
    return {doublings(position_m / nearest_position_m, 10),
            doublings(orientation_rad / nearest_orientation_rad, 5)};
}

namespace {

std::int32_t orientation_limit(const Quantization& q) {
    return (1 << (std::clamp(q.orientation_bits, 5, 15) - 1)) - 1;
}

std::int32_t yaw_steps(const Quantization& q) {
    return 1 << std::clamp(q.yaw_bits, 5, 16);
}

}  // namespace

QuantizationLimits limits_of(const Quantization& q) {
    QuantizationLimits limits;
    limits.horizontal = limit_of(q.horizontal_extent_m, q.position_step_m);
    limits.vertical = limit_of(q.vertical_extent_m, q.position_step_m);
    limits.velocity = limit_of(q.max_speed_mps, q.velocity_step_mps);
    limits.acceleration = limit_of(kMaxAccelerationMps2, q.acceleration_step_mps2);
    limits.angular_velocity = limit_of(kMaxAngularSpeedRps, q.angular_velocity_step_rps);
    limits.orientation = orientation_limit(q);
    limits.yaw_steps = yaw_steps(q);
    return limits;
}

float Quantization::orientation_quantum_rad(bool upright) const {
    constexpr double kFloatRounding = 1e-6;  // of unit quaternions of floats, as an angle
    const QuantizationLimits limits = limits_of(*this);
    if (upright) {
        return static_cast<float>(std::numbers::pi / limits.yaw_steps + kFloatRounding);
    }
    // u is one unit of the grid. Rounding moves the three stored components by at most
    // (sqrt 3 / 2) u together; on the unit sphere this is longer by at most 1 / w, where w is the
    // smaller of the left-out component before (>= 1/2) and after (w^2 >= 1/4 - 3u/2 - 3u^2/4).
    // Making the form canonical may then move one component by u / 2, and another that is about as
    // large with it. The angle of a rotation is twice that of its quaternion.
    const double u = 1.0 / (limits.orientation * std::numbers::sqrt2);
    const double w = 0.5 * std::sqrt(1.0 - 6.0 * u - 3.0 * u * u);
    const double ratio = 1.0 / (1.0 - u / w);
    const double rounding = 0.5 * std::numbers::sqrt3 * u / w;
    const double exchange = 0.5 * u * std::sqrt(1.0 + ratio * ratio);
    return static_cast<float>(2.0 * (rounding + exchange) + kFloatRounding);
}

bool is_canonical_orientation(std::int32_t largest,
                              const std::array<std::int32_t, 3>& smallest_three,
                              std::int32_t limit) {
    if (largest < 0 || largest > 3) {
        return false;
    }
    for (const std::int32_t n : smallest_three) {
        if (n < -limit || n > limit) {
            return false;
        }
    }
    return is_canonical(grid_orientation(largest, smallest_three), limit);
}

QuantizedState quantize(const motion::KinematicState& state,
                        motion::PredictorOrder order,
                        bool upright,
                        bool at_rest,
                        std::uint16_t appearance,
                        const Quantization& q) {
    // Each limit is a division: only those that are needed are looked at.
    const std::int32_t horizontal = limit_of(q.horizontal_extent_m, q.position_step_m);
    const std::int32_t vertical = limit_of(q.vertical_extent_m, q.position_step_m);
    QuantizedState out;
    out.order = order;
    out.appearance = appearance;
    out.position = {quantize_component(state.position.x(), q.position_step_m, horizontal),
                    quantize_component(state.position.y(), q.position_step_m, vertical),
                    quantize_component(state.position.z(), q.position_step_m, horizontal)};
    if (upright) {
        out.orientation[0] = quantize_yaw(state.orientation, yaw_steps(q));
    } else {
        quantize_smallest_three(state.orientation, orientation_limit(q), out);
    }
    const bool resting = order == motion::PredictorOrder::kStatic;
    if (resting && !at_rest) {
        return out;
    }
    const std::int32_t fastest_turn = limit_of(kMaxAngularSpeedRps, q.angular_velocity_step_rps);
    const auto velocity = quantize_vector(
        state.velocity, q.velocity_step_mps, limit_of(q.max_speed_mps, q.velocity_step_mps));
    auto angular =
        quantize_vector(state.angular_velocity, q.angular_velocity_step_rps, fastest_turn);
    if (upright) {
        angular[0] = 0;
        angular[2] = 0;
    }
    if (resting) {
        out.at_rest = is_zero(velocity) && is_zero(angular);
        return out;
    }
    out.velocity = velocity;
    out.angular_velocity = angular;
    const bool turning = order == motion::PredictorOrder::kTurning;
    if (order == motion::PredictorOrder::kQuadratic || turning) {
        out.acceleration =
            quantize_vector(state.acceleration,
                            q.acceleration_step_mps2,
                            limit_of(kMaxAccelerationMps2, q.acceleration_step_mps2));
    }
    if (turning) {
        out.turn = quantize_vector(state.turn, q.angular_velocity_step_rps, fastest_turn);
    }
    if (order == motion::PredictorOrder::kBallistic) {
        out.floor =
            std::min(quantize_component(state.floor, q.position_step_m, vertical), out.position[1]);
    }
    return out;
}

motion::KinematicState dequantize(const QuantizedState& state,
                                  bool upright,
                                  const Quantization& q) {
    motion::KinematicState out;
    out.position = dequantize_vector(state.position, q.position_step_m);
    out.velocity = dequantize_vector(state.velocity, q.velocity_step_mps);
    out.acceleration = dequantize_vector(state.acceleration, q.acceleration_step_mps2);
    out.angular_velocity = dequantize_vector(state.angular_velocity, q.angular_velocity_step_rps);
    out.turn = dequantize_vector(state.turn, q.angular_velocity_step_rps);
    if (state.order == motion::PredictorOrder::kBallistic) {
        out.acceleration = Vec3(0.0F, -q.gravity_mps2, 0.0F);
        out.floor = dequantize_component(state.floor, q.position_step_m);
    }
    if (upright) {
        out.orientation = dequantize_yaw(state.orientation[0], yaw_steps(q));
    } else {
        const std::array<double, 4> c = components(
            grid_orientation(state.orientation_largest, state.orientation), orientation_limit(q));
        out.orientation = Quat(static_cast<float>(c[0]),
                               static_cast<float>(c[1]),
                               static_cast<float>(c[2]),
                               static_cast<float>(c[3]));
    }
    return out;
}

}  // namespace zoned::wire
