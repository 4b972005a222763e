// Field table: the fields of a publication, written once; encoding, decoding, skipping and the
// documentation's test all follow it.
#pragma once

#include "shared/wire/quantize.h"

#include <array>
#include <bit>
#include <cstdint>

namespace zoned::wire {

/// The range of a field's values; the Quantization decides the number of values.
enum class Range : std::uint8_t {
    kMotion,           ///< 0..5, see Motion
    kHorizontal,       ///< -limit..limit in position_step_m
    kVertical,         ///< likewise
    kVelocity,         ///< in velocity_step_mps
    kAcceleration,     ///< in acceleration_step_mps2
    kAngularVelocity,  ///< in angular_velocity_step_rps
    kYaw,              ///< 0..2^yaw_bits-1, wraps round
    kLeftOut,          ///< 0..3: w, x, y, z
    kSmallestThree,    ///< -limit..limit in 1 / (limit sqrt 2)
    kAppearance,       ///< 0..65535
};

inline constexpr int kRanges = 10;

/// Kind of prediction and rest in one number: the value of the first field.
enum class Motion : std::uint8_t {
    kAtRest = 0,
    kStatic = 1,
    kLinear = 2,
    kQuadratic = 3,
    kBallistic = 4,
    kTurning = 5,
};

inline constexpr std::int32_t kMotions = 6;

/// When a field is in a record; absent fields are zero.
enum class Presence : std::uint8_t {
    kAlways,
    kMoving,          ///< motion is linear, quadratic, ballistic or turning
    kAccelerating,    ///< motion is quadratic or turning
    kFalling,         ///< motion is ballistic
    kTurning,         ///< motion is turning
    kUpright,         ///< the type turns about y only
    kUprightMoving,   ///< both
    kTumbling,        ///< the type turns freely
    kTumblingMoving,  ///< both
};

/// Size class of the whole range: the value itself, not a difference.
inline constexpr std::uint8_t kFull = 0xFF;

/// Widths in bits, ascending, of the size classes of a field. A selector of 0, 1 or 2 bits (for 1,
/// 2 or 4 classes) chooses the class of all components of the field: the first that holds all
/// differences to the reference.
struct SizeClasses {
    std::array<std::uint8_t, 4> bits{};
    std::uint8_t count = 1;

    [[nodiscard]] constexpr int selector_bits() const { return std::bit_width(count) - 1; }
};

inline constexpr SizeClasses kFullOnly{{kFull}, 1};

struct Field {
    const char* name;
    const char* unit;
    std::uint8_t first;       ///< index of the first component in Columns
    std::uint8_t components;  ///< 1..3
    Presence presence;
    Range range;
    SizeClasses absolute;  ///< differences to zero
    SizeClasses delta;     ///< differences to the keyframe
};

/// A QuantizedState as one row of integers, in the order in which fields are written.
inline constexpr int kColumns = 22;
using Columns = std::array<std::int32_t, kColumns>;

// Widths: the cheapest for walking characters and tumbling props. Characters are published at a
// dead reckoning error of 0.05 m or 0.1 rad, with a keyframe every 8 publications. clang-format off
inline constexpr std::array<Field, 17> kFields{{
    {"motion", "-", 0, 1, Presence::kAlways, Range::kMotion, kFullOnly, kFullOnly},
    {"position_xz",
     "position_step_m",
     1,
     2,
     Presence::kAlways,
     Range::kHorizontal,
     kFullOnly,
     {{0, 9, 12, kFull}, 4}},
    {"position_y",
     "position_step_m",
     3,
     1,
     Presence::kAlways,
     Range::kVertical,
     {{8, 12, 15, kFull}, 4},
     {{0, 5, 9, kFull}, 4}},
    {"velocity_xz",
     "velocity_step_mps",
     4,
     2,
     Presence::kMoving,
     Range::kVelocity,
     {{0, 8, 10, kFull}, 4},
     {{0, 8, 10, kFull}, 4}},
    {"velocity_y",
     "velocity_step_mps",
     6,
     1,
     Presence::kMoving,
     Range::kVelocity,
     {{0, 5, 8, kFull}, 4},
     {{0, 5, 8, kFull}, 4}},
    {"acceleration_xz",
     "acceleration_step_mps2",
     7,
     2,
     Presence::kAccelerating,
     Range::kAcceleration,
     {{0, 7, 10, kFull}, 4},
     {{0, 7, 10, kFull}, 4}},
    {"acceleration_y",
     "acceleration_step_mps2",
     9,
     1,
     Presence::kAccelerating,
     Range::kAcceleration,
     {{0, 7, 10, kFull}, 4},
     {{0, 7, 10, kFull}, 4}},
    {"acceleration_turn_xz",
     "angular_velocity_step_rps",
     18,
     2,
     Presence::kTurning,
     Range::kAngularVelocity,
     {{0, 6, 8, kFull}, 4},
     {{0, 6, 8, kFull}, 4}},
    {"acceleration_turn_y",
     "angular_velocity_step_rps",
     20,
     1,
     Presence::kTurning,
     Range::kAngularVelocity,
     {{0, 6, 8, kFull}, 4},
     {{0, 6, 8, kFull}, 4}},
    {"floor_y",
     "position_step_m",
     21,
     1,
     Presence::kFalling,
     Range::kVertical,
     {{8, 12, 15, kFull}, 4},
     {{0, 5, 9, kFull}, 4}},
    {"yaw",
     "turn / 2^yaw_bits",
     10,
     1,
     Presence::kUpright,
     Range::kYaw,
     kFullOnly,
     {{0, 7, 9, kFull}, 4}},
    {"turn_rate",
     "angular_velocity_step_rps",
     16,
     1,
     Presence::kUprightMoving,
     Range::kAngularVelocity,
     {{0, 6, 8, kFull}, 4},
     {{0, 8, 9, kFull}, 4}},
    {"left_out", "-", 13, 1, Presence::kTumbling, Range::kLeftOut, kFullOnly, {{0, kFull}, 2}},
    {"smallest_three",
     "1 / (limit sqrt 2)",
     10,
     3,
     Presence::kTumbling,
     Range::kSmallestThree,
     kFullOnly,
     {{0, 5, 8, kFull}, 4}},
    {"angular_velocity_xz",
     "angular_velocity_step_rps",
     14,
     2,
     Presence::kTumblingMoving,
     Range::kAngularVelocity,
     {{0, 5, 8, kFull}, 4},
     {{0, 5, 8, kFull}, 4}},
    {"angular_velocity_y",
     "angular_velocity_step_rps",
     16,
     1,
     Presence::kTumblingMoving,
     Range::kAngularVelocity,
     {{0, 5, 8, kFull}, 4},
     {{0, 5, 8, kFull}, 4}},
    {"appearance",
     "-",
     17,
     1,
     Presence::kAlways,
     Range::kAppearance,
     {{0, 5, 9, kFull}, 4},
     {{0, kFull}, 2}},
}};

// clang-format on

/// Whether a field is in a record of an entity with this motion.
constexpr bool is_present(Presence presence, Motion motion, bool upright) {
    const bool moving = motion >= Motion::kLinear;
    switch (presence) {
        case Presence::kAlways:
            return true;
        case Presence::kMoving:
            return moving;
        case Presence::kAccelerating:
            return motion == Motion::kQuadratic || motion == Motion::kTurning;
        case Presence::kFalling:
            return motion == Motion::kBallistic;
        case Presence::kTurning:
            return motion == Motion::kTurning;
        case Presence::kUpright:
            return upright;
        case Presence::kUprightMoving:
            return upright && moving;
        case Presence::kTumbling:
            return !upright;
        case Presence::kTumblingMoving:
            return !upright && moving;
    }
    return false;
}

/// Values of a range under a Quantization, and the bits of its full size class, which holds
/// value - minimum.
struct RangeLayout {
    std::int32_t minimum = 0;
    std::int32_t maximum = 0;
    int full_bits = 0;
    bool wraps = false;
};

/// All ranges under one Quantization.
class FieldLayout {
  public:
    explicit FieldLayout(const Quantization& q) {
        const QuantizationLimits limits = limits_of(q);
        set(Range::kMotion, 0, kMotions - 1);
        set(Range::kHorizontal, -limits.horizontal, limits.horizontal);
        set(Range::kVertical, -limits.vertical, limits.vertical);
        set(Range::kVelocity, -limits.velocity, limits.velocity);
        set(Range::kAcceleration, -limits.acceleration, limits.acceleration);
        set(Range::kAngularVelocity, -limits.angular_velocity, limits.angular_velocity);
        set(Range::kYaw, 0, limits.yaw_steps - 1);
        set(Range::kLeftOut, 0, 3);
        set(Range::kSmallestThree, -limits.orientation, limits.orientation);
        set(Range::kAppearance, 0, 65535);
        ranges_[static_cast<std::size_t>(Range::kYaw)].wraps = true;
    }

    [[nodiscard]] const RangeLayout& operator[](Range range) const {
        return ranges_[static_cast<std::size_t>(range)];
    }

  private:
    void set(Range range, std::int32_t minimum, std::int32_t maximum) {
        const auto span = static_cast<std::uint32_t>(maximum - minimum);
        ranges_[static_cast<std::size_t>(range)] = {
            minimum, maximum, static_cast<int>(std::bit_width(span)), false};
    }

    std::array<RangeLayout, kRanges> ranges_{};
};

/// The row of a state and back.
Columns columns_of(const QuantizedState& state);
QuantizedState state_of(const Columns& columns);

}  // namespace zoned::wire
