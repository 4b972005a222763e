#include "shared/motion/dead_reckoning.h"

#include "shared/core/elementary/elementary.h"
#include "shared/motion/turn_integrals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::motion {

namespace {

/// Time for which the published motion goes on: all the time, or until it lands.
float in_motion(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    return order == PredictorOrder::kBallistic ? std::min(elapsed_s, landing_time(from))
                                               : elapsed_s;
}

/// p + v t + the acceleration, which turns, integrated twice.
Vec3 turning_position(const KinematicState& from, float t) {
    const Vec3& a = from.acceleration;
    const Vec3& w = from.turn;
    const TurnIntegrals i = turn_integrals(static_cast<double>(w.norm() * t));
    const Vec3 turned = a * static_cast<float>(i.versine) +
                        w.cross(a) * (t * static_cast<float>(i.arc)) +
                        w * (w.dot(a) * t * t * static_cast<float>(i.sagitta));
    return from.position + (from.velocity + turned * t) * t;
}

/// The acceleration, which turns, integrated once.
Vec3 turning_velocity(const KinematicState& from, float t) {
    const Vec3& a = from.acceleration;
    const Vec3& w = from.turn;
    const TurnIntegrals i = turn_integrals(static_cast<double>(w.norm() * t));
    return from.velocity +
           (a * static_cast<float>(i.sine) + w.cross(a) * (t * static_cast<float>(i.versine)) +
            w * (w.dot(a) * t * t * static_cast<float>(i.arc))) *
               t;
}

Quat turned_by(const Vec3& rate, float t, const Quat& orientation) {
    const float speed = rate.norm();
    if (speed == 0.0F) {
        return orientation;
    }
    // q(t) = exp(w t / 2) q(0) for a constant w in world axes.
    const float half_angle = 0.5F * speed * t;
    const auto [sine, cosine] = elementary::sincos(half_angle);
    const float s = sine / speed;
    return Quat(cosine, rate.x() * s, rate.y() * s, rate.z() * s) * orientation;
}

}  // namespace

float landing_time(const KinematicState& from) {
    const float drop = from.position.y() - from.floor;
    const float pull = -from.acceleration.y();
    const float rise = from.velocity.y();
    if (drop <= 0.0F && rise <= 0.0F) {
        return 0.0F;
    }
    if (!(pull > 0.0F) || !std::isfinite(drop)) {
        return std::numeric_limits<float>::infinity();
    }
    // drop + rise t - pull t^2 / 2 = 0, in the form in which nothing cancels.
    const float root = std::sqrt(std::max(0.0F, rise * rise + 2.0F * pull * drop));
    return rise >= 0.0F ? (rise + root) / pull : 2.0F * drop / (root - rise);
}

KinematicState predict(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    KinematicState to;
    to.position = predict_position(from, order, elapsed_s);
    to.velocity = predict_velocity(from, order, elapsed_s);
    to.orientation = predict_orientation(from, order, elapsed_s);
    const bool moves =
        order != PredictorOrder::kStatic && in_motion(from, order, elapsed_s) >= elapsed_s;
    if (!moves) {
        return to;
    }
    to.angular_velocity = from.angular_velocity;
    if (order == PredictorOrder::kQuadratic || order == PredictorOrder::kBallistic) {
        to.acceleration = from.acceleration;
    }
    if (order == PredictorOrder::kBallistic) {
        to.floor = from.floor;
    }
    if (order == PredictorOrder::kTurning) {
        to.acceleration = turned_by(from.turn, elapsed_s, Quat::Identity()) * from.acceleration;
        to.turn = from.turn;
    }
    return to;
}

Vec3 predict_position(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    switch (order) {
        case PredictorOrder::kStatic:
            break;
        case PredictorOrder::kLinear:
            return from.position + from.velocity * elapsed_s;
        case PredictorOrder::kQuadratic:
        case PredictorOrder::kBallistic: {
            const float t = in_motion(from, order, elapsed_s);
            return from.position + (from.velocity + from.acceleration * (0.5F * t)) * t;
        }
        case PredictorOrder::kTurning:
            return turning_position(from, elapsed_s);
    }
    return from.position;
}

Vec3 predict_velocity(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    switch (order) {
        case PredictorOrder::kStatic:
            break;
        case PredictorOrder::kLinear:
            return from.velocity;
        case PredictorOrder::kBallistic:
            if (in_motion(from, order, elapsed_s) < elapsed_s) {
                break;
            }
            [[fallthrough]];
        case PredictorOrder::kQuadratic:
            return from.velocity + from.acceleration * elapsed_s;
        case PredictorOrder::kTurning:
            return turning_velocity(from, elapsed_s);
    }
    return Vec3::Zero();
}

Quat predict_orientation(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    if (order == PredictorOrder::kStatic) {
        return from.orientation;
    }
    return turned_by(from.angular_velocity, in_motion(from, order, elapsed_s), from.orientation);
}

float angle_between(const Quat& a, const Quat& b) {
    // The angle of two unit vectors is 2 atan2(|u - v|, |u + v|) (Kahan, "How futile are mindless
    // assessments of roundoff", 2006, section 12), exact for small angles where arccos loses half
    // of the digits; a rotation turns by twice the angle of its quaternions. Of q and -q, which
    // are the same rotation, the nearer counts.
    const Eigen::Vector4f difference = a.coeffs() - b.coeffs();
    const Eigen::Vector4f sum = a.coeffs() + b.coeffs();
    const float d = difference.norm();
    const float s = sum.norm();
    const float angle = 4.0F * elementary::atan2(std::min(d, s), std::max(d, s));
    return std::min(angle, std::numbers::pi_v<float>);
}

}  // namespace zoned::motion
