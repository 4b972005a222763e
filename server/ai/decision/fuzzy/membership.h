// Membership: the degree of a value in a fuzzy term (a trapezoid).
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"

#include <algorithm>

namespace zoned::ai::fuzzy {

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

/// The degree of a value, [0, 1]; it must be a number.
inline float degree(const FlatTerm& term, float x) {
    const float up = 1.0F + (x - term.b) * term.rise;
    const float down = 1.0F + (term.c - x) * term.fall;
    return std::max(std::min(std::min(up, down), 1.0F), 0.0F);
}

/// The value clamped to [low, high]; NaN becomes low.
inline float clamped(float x, float low, float high) {
    return std::min(x > low ? x : low, high);
}

}  // namespace zoned::ai::fuzzy
