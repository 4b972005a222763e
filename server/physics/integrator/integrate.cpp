#include "server/physics/integrator/integrate.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>

namespace zoned::physics {

namespace {

using Quatd = Eigen::Quaternion<double, Eigen::DontAlign>;

constexpr double kLongestTurn = 0.02;
constexpr double kMostPieces = 1024.0;

/// A free body in its own axes.
struct Spinner {
    Quatd orientation;
    Vec3d momentum;  // body axes
    Vec3d inverse;   // of the principal moments

    /// The flow of one term of the energy, L_i^2 / (2 I_i), over t seconds. The body turns about
    /// its axis i at the rate L_i / I_i. The momentum is fixed in the world, so in the body's frame
    /// it turns in the opposite direction.
    void turn_about(int i, double t) {
        const double half = 0.5 * t * momentum[i] * inverse[i];
        double s = 0.0;
        double c = 0.0;
        if (std::abs(half) < 0.1) {
            const double x = half * half;  // next terms: x^5 / 3.6e6 of the result, below 3e-17
            s = half * (1 + x * (-1.0 / 6 + x * (1.0 / 120 + x * (-1.0 / 5040 + x / 362880))));
            c = 1 + x * (-0.5 + x * (1.0 / 24 + x * (-1.0 / 720 + x / 40320)));
        } else {
            const elementary::SineCosine both = elementary::sincos(half);
            s = both.sine;
            c = both.cosine;
        }
        const int j = (i + 1) % 3;
        const int k = (i + 2) % 3;
        const double sine = 2 * s * c;
        const double cosine = 1 - 2 * s * s;
        const double lj = momentum[j];
        momentum[j] = cosine * lj + sine * momentum[k];
        momentum[k] = cosine * momentum[k] - sine * lj;
        // q (c + s e_i), written out.
        const double w = orientation.w();
        Vec3d v = orientation.vec();
        const double vi = v[i];
        const double vj = v[j];
        const double vk = v[k];
        orientation.w() = c * w - s * vi;
        v[i] = c * vi + s * w;
        v[j] = c * vj + s * vk;
        v[k] = c * vk - s * vj;
        orientation.vec() = v;
    }

    void advance(double t) {
        turn_about(0, 0.5 * t);
        turn_about(1, 0.5 * t);
        turn_about(2, t);
        turn_about(1, 0.5 * t);
        turn_about(0, 0.5 * t);
    }

    /// The fastest that it can ever spin with its energy: a constant of the motion, so that equal
    /// steps are cut into equal pieces. Pieces that followed the momentary rate would spoil the
    /// symmetry that keeps the energy from drifting.
    [[nodiscard]] double fastest_rate() const {
        return std::sqrt(momentum.cwiseAbs2().dot(inverse) * inverse.maxCoeff());
    }
};

}  // namespace

Vec3 rotate_freely(const Vec3& moments, float h, Quat& orientation, Vec3& spin) {
    const Vec3d principal = moments.cast<double>();
    const Quatd start = orientation.cast<double>().normalized();
    Spinner body;
    body.orientation = start;
    body.momentum = principal.cwiseProduct(start.conjugate() * spin.cast<double>());
    body.inverse = principal.cwiseInverse();
    const double pieces =
        std::clamp(std::ceil(body.fastest_rate() * std::abs(h) / kLongestTurn), 1.0, kMostPieces);
    for (int i = 0; i < static_cast<int>(pieces); ++i) {
        body.advance(h / pieces);
    }
    body.orientation.normalize();
    orientation = body.orientation.cast<float>();
    spin = (body.orientation * body.momentum.cwiseProduct(body.inverse)).cast<float>();
    const Quatd turn = body.orientation * start.conjugate();
    return (turn.vec() * (turn.w() < 0.0 ? -2.0 : 2.0)).cast<float>();
}

}  // namespace zoned::physics
