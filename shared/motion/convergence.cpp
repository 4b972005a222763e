#include "shared/motion/convergence.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::motion {

namespace {

/// The rest of the offset between shown and predicted at s = elapsed / period in [0, 1]: offset(t)
/// = position (shown - predicted in position at begin) + velocity (the same in velocity). The rates
/// are the derivatives with respect to time.
struct Remainder {
    float position = 0.0F;
    float velocity = 0.0F;  // s
    float position_rate = 0.0F;
    float velocity_rate = 0.0F;
};

Remainder remainder_at(ConvergenceMethod method, float s, float period_s) {
    switch (method) {
        case ConvergenceMethod::kSnap:
            break;
        case ConvergenceMethod::kLinear:
            return {1.0F - s, 0.0F, -1.0F / period_s, 0.0F};
        case ConvergenceMethod::kProjectiveVelocity: {
            // Murphy: the shown path p0 + V t with V blended from the old velocity to the new one,
            // against the new path: their difference is position + (1 - s) t velocity. It is faded
            // out by 1 - w.
            const float left = 1.0F - s;
            const float fade = left * left * (1.0F + 2.0F * s);  // 1 - w, w = 3 s^2 - 2 s^3
            const float fade_rate = -6.0F * s * left / period_s;
            const float drift = left * s * period_s;
            return {fade, fade * drift, fade_rate, fade_rate * drift + fade * (1.0F - 2.0F * s)};
        }
        case ConvergenceMethod::kHermite: {
            // The basis functions of the start: 2 s^3 - 3 s^2 + 1 and s (1 - s)^2; those of the end
            // carry an offset of zero.
            const float left = 1.0F - s;
            return {left * left * (1.0F + 2.0F * s),
                    left * left * s * period_s,
                    -6.0F * s * left / period_s,
                    left * (1.0F - 3.0F * s)};
        }
    }
    return {};
}

/// Runs over the whole blend while in progress; false: nothing is left to blend.
bool in_progress(ConvergenceMethod method, float elapsed_s, float period_s) {
    return method != ConvergenceMethod::kSnap && elapsed_s < period_s;
}

}  // namespace

void Convergence::begin(const KinematicState& shown,
                        const KinematicState& predicted,
                        float period_s) {
    period_s_ = period_s;
    jump_ = shown.position - predicted.position;
    velocity_jump_ = shown.velocity - predicted.velocity;
    // The shorter of the two rotations is taken.
    Quat turn = shown.orientation * predicted.orientation.conjugate();
    if (turn.w() < 0.0F) {
        turn.coeffs() = -turn.coeffs();
    }
    const float sine = turn.vec().norm();
    axis_ = sine > 0.0F ? Vec3(turn.vec() / sine) : Vec3(Vec3::Zero());
    angle_ = sine > 0.0F ? 2.0F * elementary::atan2(sine, turn.w()) : 0.0F;
}

KinematicState Convergence::display(ConvergenceMethod method,
                                    const KinematicState& predicted,
                                    float elapsed_s) const {
    if (!in_progress(method, elapsed_s, period_s_)) {
        return predicted;
    }
    const float elapsed = std::max(elapsed_s, 0.0F);
    const Remainder left = remainder_at(method, elapsed / period_s_, period_s_);
    KinematicState display = predicted;
    display.position += jump_ * left.position + velocity_jump_ * left.velocity;
    display.velocity += jump_ * left.position_rate + velocity_jump_ * left.velocity_rate;
    if (angle_ > 0.0F) {
        const float half = 0.5F * angle_ * left.position;
        const auto [sine, cosine] = elementary::sincos(half);
        const Vec3 part = axis_ * sine;
        const Quat remaining(cosine, part.x(), part.y(), part.z());
        display.orientation = remaining * predicted.orientation;
        display.angular_velocity =
            remaining * predicted.angular_velocity + axis_ * (angle_ * left.position_rate);
    }
    return display;
}

float Convergence::remaining_error(ConvergenceMethod method,
                                   float jump_m,
                                   float elapsed_s,
                                   float period_s,
                                   float velocity_jump_mps) {
    if (!in_progress(method, elapsed_s, period_s)) {
        return 0.0F;
    }
    const Remainder left = remainder_at(method, std::max(elapsed_s, 0.0F) / period_s, period_s);
    return jump_m * left.position + velocity_jump_mps * left.velocity;
}

}  // namespace zoned::motion
