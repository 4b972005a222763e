// Quantisation: kinematic state as integers, so that both sides know the sent state to the last
// bit.
#pragma once

#include "shared/motion/dead_reckoning.h"
#include "shared/motion/kinematic_state.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace zoned::wire {

/// Components of accelerations and angular velocities are clamped to these.
inline constexpr float kMaxAccelerationMps2 = 512.0F;
inline constexpr float kMaxAngularSpeedRps = 128.0F;
/// No quantised component exceeds this. A float's 24 bits then distinguish neighbouring steps,
/// which is what makes dequantize() reversible.
inline constexpr std::int32_t kMaxQuantizedIndex = (1 << 22) - 1;

/// How much coarser a level of detail is written than the nearest: number of doublings of the
/// steps.
struct LodShift {
    std::uint8_t place = 0;  ///< position, velocity, acceleration; 0..10
    std::uint8_t turn = 0;   ///< angular velocity, the turn of an acceleration; bits taken off
                             ///< orientation and yaw; 0..5

    friend bool operator==(const LodShift&, const LodShift&) = default;
};

/// Levels of detail that there can be, 0 is the nearest.
inline constexpr int kLods = 4;

/// Steps of quantisation; a constant of the world, sent once at login. Positions are zone-local.
/// The steps are those of the nearest level of detail; at_lod() gives those of another level.
struct Quantization {
    float position_step_m = 0.01F;                   ///< (0, 1]
    float velocity_step_mps = 1.0F / 64.0F;          ///< (0, 1]
    float acceleration_step_mps2 = 1.0F / 32.0F;     ///< (0, 10]
    float angular_velocity_step_rps = 1.0F / 32.0F;  ///< rad/s
    int orientation_bits = 10;                       ///< bits per smallest-three component, 5..15
    int yaw_bits = 10;                               ///< bits of the yaw of upright entities, 5..16
    float horizontal_extent_m =
        2048.0F;  ///< |x|, |z| of zone-local positions never exceed this; clamped
    float vertical_extent_m = 1024.0F;        ///< |y| likewise
    float max_speed_mps = 256.0F;             ///< velocity components are clamped to this
    std::array<LodShift, kLods> lod_shift{};  ///< [0] is zero
    float gravity_mps2 =
        kGravity;  ///< downwards: falling entities are predicted with it; it is not sent per entity

    /// Largest distance between a position within the extents and its quantised value: half a step
    /// along each axis, as a length, and what rounding to float takes at the rim of the zone (half
    /// of its last place, 2^-24 of the value, with a little to spare for the last half step).
    [[nodiscard]] float position_quantum_m() const {
        const float rounding_m = 0x1.1p-24F * std::max(horizontal_extent_m, vertical_extent_m);
        return 1.7320509F * (0.5F * position_step_m + rounding_m);
    }

    /// Largest angle between an orientation and its quantised value, rad.
    [[nodiscard]] float orientation_quantum_rad(bool upright) const;
};

/// Steps of the rates that suit a promised bound.
struct RateSteps {
    float velocity_mps = 0.0F;
    float acceleration_mps2 = 0.0F;
    float angular_velocity_rps = 0.0F;
};

/// A prediction over T seconds is only as good as the steps of its start state: half a step of
/// velocity is off by s T / 2, half a step of acceleration by s T^2 / 4, half a step of angular
/// velocity by s T / 2. Each may take a quarter of its bound after `horizon_s` (> 0), so that along
/// one axis half of the bound is left for the entity's own motion: steps of b / (2 T), b / T^2 and
/// b / (2 T), rounded down to powers of two (then multiples of steps are exact in floats) and
/// brought into [2^-10, 1], [2^-8, 8] and [2^-10, 1]. Finer steps cost a bit per component for each
/// halving and gain less than half of the error they halve. Coarser steps cause updates of their
/// own.
RateSteps rate_steps(float position_bound_m, float orientation_bound_rad, float horizon_s);

/// The quantisation of a level of detail: its records are written and dequantised with it. Its own
/// lod_shift is zero. Levels beyond the last count as it; steps and bits stay within the ranges.
Quantization at_lod(const Quantization& q, std::uint8_t lod);

/// How much coarser a level may be written than one with the nearest bounds: by the ratio of their
/// bounds, rounded down to a power of two, so that each step's share of the bound is that of the
/// nearest level or less.
LodShift lod_shift(float nearest_position_m,
                   float nearest_orientation_rad,
                   float position_m,
                   float orientation_rad);

/// Largest magnitude of the quantised components.
struct QuantizationLimits {
    std::int32_t horizontal = 1;
    std::int32_t vertical = 1;
    std::int32_t velocity = 1;
    std::int32_t acceleration = 1;
    std::int32_t angular_velocity = 1;
    std::int32_t orientation = 1;  ///< smallest-three components: 2^(bits-1) - 1
    std::int32_t yaw_steps = 1;    ///< steps per turn: yaws are 0..yaw_steps-1
};

/// Never fails: no extent has more than kMaxQuantizedIndex steps, and values out of range are
/// clamped.
QuantizationLimits limits_of(const Quantization& q);

/// The fields of one publication as integers. Members excluded by a flag are zero.
struct QuantizedState {
    std::array<std::int32_t, 3> position{};
    std::array<std::int32_t, 3> velocity{};
    std::array<std::int32_t, 3> acceleration{};  ///< only for order 2 and turning
    std::array<std::int32_t, 3>
        orientation{};  ///< smallest three, or {yaw, 0, 0} for upright entities
    std::int32_t orientation_largest =
        0;  ///< index 0..3 of the component left out (w, x, y, z); 0 for upright
    std::array<std::int32_t, 3> angular_velocity{};  ///< {0, wy, 0} for upright entities
    std::array<std::int32_t, 3> turn{};              ///< of the acceleration; only for turning
    std::int32_t floor = 0;        ///< only for ballistic: height, never above the position;
                                   ///< the lower limit where no floor is known
    std::uint16_t appearance = 0;  ///< rules' visible state of the entity
    motion::PredictorOrder order = motion::PredictorOrder::kStatic;
    bool at_rest = false;  ///< velocity, acceleration and angular velocity are exactly zero

    friend bool operator==(const QuantizedState&, const QuantizedState&) = default;
};

/// Rounds to the nearest step, clamped to the ranges. `upright` entities keep only their yaw. An
/// order 0 state carries no velocity, only order 2 and turning carry acceleration, only turning its
/// turn, only ballistic a floor; a state whose velocities all round to zero under order 0 is at
/// rest if `at_rest`. Not a number counts as 0, infinity as the limit, an orientation without a
/// direction as the identity (upright: yaw 0).
QuantizedState quantize(const motion::KinematicState& state,
                        motion::PredictorOrder order,
                        bool upright,
                        bool at_rest,
                        std::uint16_t appearance,
                        const Quantization& q);

/// Whether an orientation is one that quantize() can give: the component left out is the largest
/// when all four are rounded to the grid, the first of them where several are. There is exactly one
/// such form of every orientation on the grid. `limit` is QuantizationLimits::orientation.
bool is_canonical_orientation(std::int32_t largest,
                              const std::array<std::int32_t, 3>& smallest_three,
                              std::int32_t limit);

/// The state that both sides predict from. Exact inverse on integers: quantize(dequantize(s)) == s
/// for every s that quantize() gives.
motion::KinematicState dequantize(const QuantizedState& state, bool upright, const Quantization& q);

}  // namespace zoned::wire
