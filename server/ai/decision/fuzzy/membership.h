// Membership: the degrees of eight values at a time in a fuzzy term (a trapezoid).
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"
#include "server/spatial/box_lanes.h"

#include <cmath>

namespace zoned::ai::fuzzy {

using Lanes = spatial::Array8;
inline constexpr std::size_t kLanes = spatial::kLanes;

/// A trapezoid as two lines that both limit the degree: 1 + (x - b) rise and 1 + (c - x) fall.
struct FlatTerm {
    float b = 0.0F;
    float c = 0.0F;
    float rise = 0.0F;
    float fall = 0.0F;
};

/// The slope of an upright edge: it rises within 1e-30 of the unit.
inline constexpr float kUpright = 1e30F;

inline FlatTerm flat(const Term& term) {
    const auto slope = [](float length) {
        return length > 0.0F ? std::min(1.0F / length, kUpright) : kUpright;
    };
    return {term.b, term.c, slope(term.b - term.a), slope(term.d - term.c)};
}

/// The degree of each value, [0, 1]; the values must be numbers.
inline Lanes degree(const FlatTerm& term, const Lanes& x) {
    const Lanes up = 1.0F + (x - term.b) * term.rise;
    const Lanes down = 1.0F + (term.c - x) * term.fall;
    return up.min(down).min(1.0F).max(0.0F);
}

/// Values clamped to [low, high]; NaN becomes low.
inline Lanes clamped(const Lanes& x, float low, float high) {
    return (x > low).select(x, low).min(high);
}

}  // namespace zoned::ai::fuzzy
