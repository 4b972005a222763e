#include "shared/motion/convergence.h"

#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace zoned::motion {

namespace {

/// What remains of the offset between shown and predicted at s = elapsed / period in [0, 1]:
/// offset(t) = position (shown - predicted in position at begin) + velocity (the same in velocity).
/// The rates are the derivatives with respect to time.
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
    }
    return {};
}

/// Runs over the whole blend while in progress; false: nothing is left to blend.
bool in_progress(ConvergenceMethod method, float elapsed_s, float period_s) {
    return method != ConvergenceMethod::kSnap && elapsed_s < period_s;
}

}  // namespace

void Convergence::begin(const KinematicState& shown, float period_s) {
    shown_ = shown;
    period_s_ = period_s;
}

KinematicState Convergence::display(ConvergenceMethod method,
                                    const KinematicState& predicted,
                                    float elapsed_s) const {
    if (!in_progress(method, elapsed_s, period_s_)) {
        return predicted;
    }
    const float elapsed = std::max(elapsed_s, 0.0F);
    const Remainder left = remainder_at(method, elapsed / period_s_, period_s_);
    // Where the new prediction was at begin(): its own motion, backwards.
    const KinematicState start = predict(predicted, PredictorOrder::kQuadratic, -elapsed);
    const Vec3 jump = shown_.position - start.position;
    const Vec3 velocity_jump = shown_.velocity - start.velocity;

    KinematicState display = predicted;
    display.position += jump * left.position + velocity_jump * left.velocity;
    display.velocity += jump * left.position_rate + velocity_jump * left.velocity_rate;

    // The turn from predicted to shown at begin(), of which a part remains. Of the two ways round
    // the shorter one is taken.
    Quat turn = shown_.orientation * start.orientation.conjugate();
    if (turn.w() < 0.0F) {
        turn.coeffs() = -turn.coeffs();
    }
    const float sine = turn.vec().norm();
    if (sine > 0.0F) {
        const Vec3 axis = turn.vec() / sine;
        const float angle = 2.0F * std::atan2(sine, turn.w());
        const float half = 0.5F * angle * left.position;
        const Vec3 part = axis * std::sin(half);
        const Quat remaining(std::cos(half), part.x(), part.y(), part.z());
        display.orientation = remaining * predicted.orientation;
        display.angular_velocity =
            remaining * predicted.angular_velocity + axis * (angle * left.position_rate);
    }
    return display;
}

float Convergence::owed(ConvergenceMethod method,
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
