#include "tests/scenario/motions.h"

#include <array>
#include <complex>
#include <numbers>

namespace zoned::scenario {

MotionState<Line> SwayingSpring::exact(const MotionState<Line>& start, double t) const {
    using Complex = std::complex<double>;
    const Complex i(0.0, 1.0);
    // The steady swing is the imaginary part of `reply` exp(i sway_rps t).
    const Complex push = omega * omega + 2.0 * damping_ratio * omega * i * sway_rps;
    const Complex reply = sway_m * push / (push - sway_rps * sway_rps);
    const Complex swing = reply * std::exp(i * sway_rps * t);
    // The rest of the start decays as exp(decay t).
    const Complex decay =
        omega * Complex(-damping_ratio, std::sqrt(1.0 - damping_ratio * damping_ratio));
    const double x0 = start.x[0] - reply.imag();
    const double v0 = start.v[0] - (i * sway_rps * reply).imag();
    const Complex size(x0, (decay.real() * x0 - v0) / decay.imag());
    const Complex rest = size * std::exp(decay * t);
    return {Line(swing.imag() + rest.real()),
            Line((i * sway_rps * swing).imag() + (decay * rest).real())};
}

MotionState<Plane> Orbit::exact(double eccentricity, double t) {
    const double mean = std::remainder(t, 2.0 * std::numbers::pi);
    // E - e sin E = mean grows with E: Newton from beyond the answer comes down to it.
    double anomaly = mean < 0.0 ? -std::numbers::pi : std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
        const double residual = anomaly - eccentricity * std::sin(anomaly) - mean;
        anomaly -= residual / (1.0 - eccentricity * std::cos(anomaly));
    }
    const double side = std::sqrt(1.0 - eccentricity * eccentricity);
    const double rate = 1.0 / (1.0 - eccentricity * std::cos(anomaly));
    return {Plane(std::cos(anomaly) - eccentricity, side * std::sin(anomaly)),
            Plane(-rate * std::sin(anomaly), rate * side * std::cos(anomaly))};
}

namespace {

struct Elliptic {
    double sine;
    double cosine;
};

/// Jacobi's sn and cn of `share` quarter periods by the arithmetic-geometric mean (Abramowitz,
/// Stegun, "Handbook of Mathematical Functions", 16.4), modulus k in [0, 1).
Elliptic jacobi(double share, double k, double& quarter) {
    std::array<double, 12> a{1.0};
    std::array<double, 12> c{k};
    double b = std::sqrt(1.0 - k * k);
    std::size_t n = 0;
    while (n + 1 < a.size() && c[n] > 1.0e-17) {
        a[n + 1] = 0.5 * (a[n] + b);
        c[n + 1] = 0.5 * (a[n] - b);
        b = std::sqrt(a[n] * b);
        ++n;
    }
    quarter = std::numbers::pi / (2.0 * a[n]);
    double phase = std::ldexp(0.5 * std::numbers::pi * share, static_cast<int>(n));
    for (; n > 0; --n) {
        phase = 0.5 * (phase + std::asin(c[n] / a[n] * std::sin(phase)));
    }
    return {std::sin(phase), std::cos(phase)};
}

}  // namespace

MotionState<Line> Pendulum::exact(double from, double t) const {
    const double rate = std::sqrt(gravity_mps2 / length_m);
    const double k = std::sin(0.5 * from);
    double quarter = 0.0;
    jacobi(0.0, k, quarter);
    // sin(x / 2) = k sn(K - rate t); four quarters make a period.
    const double share = std::remainder(1.0 - rate * t / quarter, 4.0);
    const Elliptic at = jacobi(share, k, quarter);
    return {Line(2.0 * std::asin(k * at.sine)), Line(-2.0 * k * rate * at.cosine)};
}

MotionState<Vec3d> ThrownBall::dropped(double t) const {
    const double speed = terminal_speed();
    const double share = gravity_mps2 * t / speed;
    return {Vec3d(0.0, -speed * speed / gravity_mps2 * std::log(std::cosh(share)), 0.0),
            Vec3d(0.0, -speed * std::tanh(share), 0.0)};
}

Eigen::Vector4d FreeRotation::operator()(const V& x, const V& v, double) const {
    const Vec3d w = body_spin({x, v});
    const Vec3d change = moments.cwiseProduct(w).cross(w).cwiseQuotient(moments);
    const Eigen::Quaterniond q(x);
    const Eigen::Quaterniond rate(v);
    const Eigen::Quaterniond spin(0.0, w.x(), w.y(), w.z());
    const Eigen::Quaterniond growth(0.0, change.x(), change.y(), change.z());
    return 0.5 * ((rate * spin).coeffs() + (q * growth).coeffs());
}

MotionState<Eigen::Vector4d> FreeRotation::start(const Vec3d& spin) {
    return {Eigen::Vector4d(0.0, 0.0, 0.0, 1.0),
            Eigen::Vector4d(0.5 * spin.x(), 0.5 * spin.y(), 0.5 * spin.z(), 0.0)};
}

Vec3d FreeRotation::body_spin(const MotionState<V>& s) {
    const Eigen::Quaterniond q(s.x);
    const Eigen::Quaterniond rate(s.v);
    return 2.0 / s.x.squaredNorm() * (q.conjugate() * rate).vec();
}

}  // namespace zoned::scenario
