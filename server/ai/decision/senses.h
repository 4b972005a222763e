// Senses: what agents know of the world, as numbers in columns, and conditions on them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::ai {

enum class Compare : std::uint8_t {
    kBelow,
    kAbove
};

using SenseIndex = std::uint16_t;

/// Stands in a condition for the time since the state was entered, s: no column, every brain
/// knows it by itself. In a brain of brains it is the time of the state that has the condition.
inline constexpr SenseIndex kStateTime = 0xFFFF;

/// Columns of equal length: `column[k][i]` is sense k of the i-th agent. Not owned.
struct SenseColumns {
    std::span<const float* const> column;
    std::size_t count = 0;  ///< of agents
};

/// Strictly below or above: with equality neither holds, and with no number (NaN) neither does.
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
