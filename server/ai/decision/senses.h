// Senses: the world as an agent's brain reads it: numbers in columns, and conditions on them.
#pragma once

#include <cstdint>

namespace zoned::ai {

enum class Compare : std::uint8_t {
    kBelow,
    kAbove
};

using SenseIndex = std::uint16_t;

/// Stands in a condition for the time since the state was entered, s. It needs no column, because
/// every brain keeps that time itself. In nested state machines it is the time of the state that
/// has the condition.
inline constexpr SenseIndex kStateTime = 0xFFFF;

/// A sense strictly below or above a threshold. With equality or NaN neither holds.
struct Condition {
    SenseIndex sense = 0;
    Compare compare = Compare::kBelow;
    float threshold = 0.0F;  ///< in the sense's unit
};

inline bool holds(const Condition& condition, float value) {
    return condition.compare == Compare::kBelow ? value < condition.threshold
                                                : value > condition.threshold;
}

}  // namespace zoned::ai
