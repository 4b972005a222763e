// Penalty forces: springs and dampers where shapes overlap.
#include "server/physics/solver_variants/collision_response.h"
#include "shared/core/elementary/elementary.h"

#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// Constants of the springs, per kilogram.
struct Spring {
    double stiffness = 0.0;  // 1/s2
    double rate = 0.0;       // w, 1/s
    double damping = 0.0;    // 1/s
    double seconds = 0.0;

    Spring(const VariantSettings& settings, double h, double for_seconds) : seconds(for_seconds) {
        const auto zeta = static_cast<double>(settings.penalty_damping_ratio);
        const double w = static_cast<double>(settings.penalty_share) * penalty_limit(zeta) / h;
        stiffness = w * w;
        rate = w;
        damping = 2.0 * zeta * w;
    }

    /// Of a contact whose materials have restitution e.
    [[nodiscard]] double damping_for(double e) const {
        if (e <= 0.0) {
            return damping;
        }
        const double loss = elementary::log(std::min(e, 1.0));
        const double zeta = -loss / std::sqrt(std::numbers::pi * std::numbers::pi + loss * loss);
        return std::min(damping, 2.0 * zeta * rate);
    }
};

/// The impulse of a normal or joint row.
double push_of(const RowSystem& s, std::size_t i, const Spring& spring) {
    const double mass = 1.0 / s.split[i];
    if (s.undoes[i] != 0) {
        const double force = -mass * (spring.stiffness * s.gap[i] +
                                      spring.damping_for(s.restitution[i]) * s.speed(i));
        return std::min(std::max(spring.seconds * force, s.low[i]), s.high[i]);
    }
    if (s.role[i] == RowRole::kNormal || (s.low[i] == 0.0 && s.gap[i] >= 0.0)) {
        return 0.0;  // not there yet
    }
    // Motors and the springs of joints: a step of Jacobi, which mass splitting keeps stable.
    const double step = -(s.speed(i) + s.bias[i]) / (s.split[i] + s.soft[i]);
    return std::min(std::max(step, s.low[i]), s.high[i]);
}

/// The gain of friction's spring within the time, plus that of its damper.
void stretch(RowSystem& s, std::size_t i, const Spring& spring) {
    const double mass = 1.0 / s.split[i];
    const double slip = s.speed(i);
    s.lambda[i] -= mass * spring.stiffness * spring.seconds * spring.seconds * slip;
    s.scratch.speeds[i] = s.lambda[i] - mass * spring.damping * spring.seconds * slip;
}

/// Bounds of friction on both.
void slide(RowSystem& s, std::size_t i) {
    std::vector<double>& push = s.scratch.speeds;
    if (s.role[i] == RowRole::kConeFirst) {
        const double limit = s.friction_limit(i);
        project_on_disc(limit, s.lambda[i], s.lambda[i + 1]);
        project_on_disc(limit, push[i], push[i + 1]);
        return;
    }
    const bool bounded = s.role[i] == RowRole::kBounded;
    const double high = bounded ? s.high[i] : s.friction_limit(i);
    const double low = bounded ? s.low[i] : -high;
    s.lambda[i] = std::min(std::max(s.lambda[i], low), high);
    push[i] = std::min(std::max(push[i], low), high);
}

}  // namespace

double penalty_limit(double damping_ratio) {
    return 2.0 * (std::sqrt(1.0 + damping_ratio * damping_ratio) - damping_ratio);
}

void respond_by_penalties(const VariantSettings& settings, double h, double seconds, RowSystem& s) {
    const Spring spring(settings, h, seconds);
    s.scratch.speeds.assign(s.size(), 0.0);
    const auto rubs = [&](std::size_t i) {
        return s.rub[i] != 0 && s.split[i] > 0.0;
    };
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (rubs(i)) {
            stretch(s, i, spring);
        } else if (s.split[i] > 0.0) {
            s.lambda[i] = s.scratch.speeds[i] = push_of(s, i, spring);
        }
    }
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (rubs(i) && s.role[i] != RowRole::kConeSecond) {
            slide(s, i);
        }
    }
    for (std::size_t i = 0; i < s.size(); ++i) {
        s.push(i, s.scratch.speeds[i]);
    }
}

}  // namespace zoned::physics
