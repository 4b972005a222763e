#include "server/physics/shapes/material.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

float combined(float a, float b, Combine rule) {
    switch (rule) {
        case Combine::kAverage:
            return 0.5F * (a + b);
        case Combine::kMinimum:
            return std::min(a, b);
        case Combine::kMultiply:
            return a * b;
        case Combine::kMaximum:
            return std::max(a, b);
        case Combine::kDefault:
        case Combine::kGeometricMean:
            break;
    }
    return std::sqrt(a * b);
}

Combine rule_of(Combine a, Combine b, Combine by_default) {
    const Combine rule = std::max(a, b);
    return rule == Combine::kDefault ? by_default : rule;
}

}  // namespace

Grip combine(const Material& a, const Material& b) {
    return {combined(a.friction,
                     b.friction,
                     rule_of(a.friction_rule, b.friction_rule, Combine::kGeometricMean)),
            combined(a.restitution,
                     b.restitution,
                     rule_of(a.restitution_rule, b.restitution_rule, Combine::kMaximum)),
            std::max(a.rolling_m, b.rolling_m),
            std::max(a.spinning_m, b.spinning_m)};
}

}  // namespace zoned::physics
