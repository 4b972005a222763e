#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::motion {

KinematicState predict(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    KinematicState to;
    to.position = predict_position(from, order, elapsed_s);
    to.orientation = predict_orientation(from, order, elapsed_s);
    switch (order) {
        case PredictorOrder::kStatic:
            break;
        case PredictorOrder::kLinear:
            to.velocity = from.velocity;
            to.angular_velocity = from.angular_velocity;
            break;
        case PredictorOrder::kQuadratic:
            to.velocity = from.velocity + from.acceleration * elapsed_s;
            to.acceleration = from.acceleration;
            to.angular_velocity = from.angular_velocity;
            break;
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
            return from.position +
                   (from.velocity + from.acceleration * (0.5F * elapsed_s)) * elapsed_s;
    }
    return from.position;
}

Quat predict_orientation(const KinematicState& from, PredictorOrder order, float elapsed_s) {
    const float rate = from.angular_velocity.norm();
    if (order == PredictorOrder::kStatic || rate == 0.0F) {
        return from.orientation;
    }
    // q(t) = exp(w t / 2) q(0) for a constant w in world axes.
    const float half_angle = 0.5F * rate * elapsed_s;
    const float s = std::sin(half_angle) / rate;
    const Vec3& w = from.angular_velocity;
    return Quat(std::cos(half_angle), w.x() * s, w.y() * s, w.z() * s) * from.orientation;
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
    const float angle = 4.0F * std::atan2(std::min(d, s), std::max(d, s));
    return std::min(angle, std::numbers::pi_v<float>);
}

}  // namespace zoned::motion
