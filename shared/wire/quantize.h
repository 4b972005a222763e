// Quantisation: kinematic state as integers, so that what was sent is known to the last bit on both
// sides.
#pragma once

#include "shared/motion/dead_reckoning.h"
#include "shared/motion/kinematic_state.h"

#include <array>
#include <cstdint>

namespace zoned::wire {

/// Steps of quantisation; a constant of the world, sent once at login. Positions are zone-local.
struct Quantization {
    float position_step_m = 0.01F;                   ///< (0, 1]
    float velocity_step_mps = 1.0F / 64.0F;          ///< (0, 1]
    float acceleration_step_mps2 = 0.25F;            ///< (0, 10]
    float angular_velocity_step_rps = 1.0F / 32.0F;  ///< rad/s
    int orientation_bits = 10;                       ///< bits per smallest-three component, 5..15
    int yaw_bits = 10;                               ///< bits of the yaw of upright entities, 5..16
    float horizontal_extent_m =
        2048.0F;  ///< |x|, |z| of zone-local positions never exceed this; clamped
    float vertical_extent_m = 1024.0F;  ///< |y| likewise
    float max_speed_mps = 256.0F;       ///< velocity components are clamped to this

    /// Largest distance between a position and its quantised value: half a step along each axis, as
    /// a length.
    [[nodiscard]] float position_quantum_m() const { return 0.5F * position_step_m * 1.7320508F; }

    /// Largest angle between an orientation and its quantised value, rad.
    [[nodiscard]] float orientation_quantum_rad(bool upright) const;
};

/// The fields of one publication as integers. Members that a flag rules out are zero.
struct QuantizedState {
    std::array<std::int32_t, 3> position{};
    std::array<std::int32_t, 3> velocity{};
    std::array<std::int32_t, 3> acceleration{};  ///< only for order 2
    std::array<std::int32_t, 3>
        orientation{};  ///< smallest three, or {yaw, 0, 0} for upright entities
    std::int32_t orientation_largest =
        0;  ///< index 0..3 of the component left out (w, x, y, z); 0 for upright
    std::array<std::int32_t, 3> angular_velocity{};  ///< {0, wy, 0} for upright entities
    std::uint16_t appearance = 0;                    ///< rules' visible state of the entity
    motion::PredictorOrder order = motion::PredictorOrder::kStatic;
    bool at_rest = false;  ///< velocity, acceleration and angular velocity are exactly zero

    friend bool operator==(const QuantizedState&, const QuantizedState&) = default;
};

/// Rounds to the nearest step, clamped to the ranges. `upright` entities keep only their yaw. An
/// order 0 state carries no velocity, only order 2 carries acceleration; a state whose velocities
/// all round to zero under order 0 is at rest if `at_rest`.
QuantizedState quantize(const motion::KinematicState& state,
                        motion::PredictorOrder order,
                        bool upright,
                        bool at_rest,
                        std::uint16_t appearance,
                        const Quantization& q);

/// The state that both sides predict from. Exact inverse on integers: quantize(dequantize(s)) == s.
motion::KinematicState dequantize(const QuantizedState& state, bool upright, const Quantization& q);

}  // namespace zoned::wire
