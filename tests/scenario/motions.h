// Motions with known answers: springs, an orbit, a pendulum, a thrown ball, a spinning box.
#pragma once

#include "shared/math/types.h"

#include <cmath>

namespace zoned::scenario {

/// Position (or angle) and velocity.
template <class V>
struct MotionState {
    V x = V::Zero();
    V v = V::Zero();
};

using Line = Eigen::Matrix<double, 1, 1>;
using Plane = Eigen::Vector2d;

/// A mass on a damped spring whose other end sways by `sway_m` sin(sway_rps t):
/// x'' = -omega^2 (x - y) - 2 damping_ratio omega (x' - y'). Damping below critical.
struct SwayingSpring {
    using V = Line;
    double omega = 1.0;  ///< rad/s
    double damping_ratio = 0.0;
    double sway_m = 0.0;
    double sway_rps = 0.0;

    V operator()(const V& x, const V& v, double t) const {
        const double y = sway_m * std::sin(sway_rps * t);
        const double slope = sway_m * sway_rps * std::cos(sway_rps * t);
        return V(-omega * omega * (x[0] - y) - 2.0 * damping_ratio * omega * (v[0] - slope));
    }

    void jacobian(const V&, const V&, double, Line& dx, Line& dv) const {
        dx[0] = -omega * omega;
        dv[0] = -2.0 * damping_ratio * omega;
    }

    /// The closed form: a steady swing and a decaying one.
    [[nodiscard]] MotionState<V> exact(const MotionState<V>& start, double t) const;

    [[nodiscard]] double energy(const MotionState<V>& s) const {
        return 0.5 * (s.v.squaredNorm() + omega * omega * s.x.squaredNorm());
    }
};

/// x'' = -x / |x|^3: semi-axis 1, period 2 pi.
struct Orbit {
    using V = Plane;

    V operator()(const V& x, const V&, double) const {
        const double r2 = x.squaredNorm();
        return x / (-r2 * std::sqrt(r2));
    }

    void jacobian(const V& x, const V&, double, Eigen::Matrix2d& dx, Eigen::Matrix2d& dv) const {
        const double r2 = x.squaredNorm();
        dx = (3.0 / r2 * x * x.transpose() - Eigen::Matrix2d::Identity()) / (r2 * std::sqrt(r2));
        dv.setZero();
    }

    /// t seconds after the point nearest to the centre, by Kepler's equation; eccentricity in
    /// [0, 1).
    static MotionState<V> exact(double eccentricity, double t);

    static double energy(const MotionState<V>& s) {
        return 0.5 * s.v.squaredNorm() - 1.0 / s.x.norm();
    }
};

/// A mass on a rod of `length_m`; x is the angle, rad.
struct Pendulum {
    using V = Line;
    double length_m = 1.0;
    double gravity_mps2 = 9.81;

    V operator()(const V& x, const V&, double) const {
        return V(-gravity_mps2 / length_m * std::sin(x[0]));
    }

    void jacobian(const V& x, const V&, double, Line& dx, Line& dv) const {
        dx[0] = -gravity_mps2 / length_m * std::cos(x[0]);
        dv[0] = 0.0;
    }

    /// t seconds after it was let go at the angle `from` in (0, pi), by Jacobi's elliptic
    /// functions.
    [[nodiscard]] MotionState<V> exact(double from, double t) const;

    /// Above the lowest point, per mass and length squared.
    [[nodiscard]] double energy(const MotionState<V>& s) const {
        return 0.5 * s.v.squaredNorm() + gravity_mps2 / length_m * (1.0 - std::cos(s.x[0]));
    }
};

/// A ball in air: x'' = g - drag |x'| x', y up.
struct ThrownBall {
    using V = Vec3d;
    double gravity_mps2 = 9.81;
    double drag_per_m = 0.0055;

    V operator()(const V&, const V& v, double) const {
        V a = -drag_per_m * v.norm() * v;
        a.y() -= gravity_mps2;
        return a;
    }

    void jacobian(const V&, const V& v, double, Eigen::Matrix3d& dx, Eigen::Matrix3d& dv) const {
        dx.setZero();
        const double speed = v.norm();
        dv = -drag_per_m * speed * Eigen::Matrix3d::Identity();
        if (speed > 0.0) {
            dv -= drag_per_m / speed * v * v.transpose();
        }
    }

    [[nodiscard]] double terminal_speed() const { return std::sqrt(gravity_mps2 / drag_per_m); }

    /// Dropped from rest: the closed form by hyperbolic functions.
    [[nodiscard]] MotionState<V> dropped(double t) const;
};

/// Free rotation as one motion of the second order: x is the quaternion (x, y, z, w) that turns
/// body axes into world axes, v its rate. Lengths other than one are allowed for; methods leave the
/// unit sphere by as much as their error.
struct FreeRotation {
    using V = Eigen::Vector4d;
    Vec3d moments = Vec3d::Ones();  ///< kg m2

    V operator()(const V& x, const V& v, double) const;

    /// Unturned, with the spin in rad/s.
    static MotionState<V> start(const Vec3d& spin);

    /// Rad/s, body axes.
    static Vec3d body_spin(const MotionState<V>& s);

    [[nodiscard]] double energy(const MotionState<V>& s) const {
        const Vec3d w = body_spin(s);
        return 0.5 * w.dot(moments.cwiseProduct(w));
    }

    /// Of the rotation, world axes, N m s.
    [[nodiscard]] Vec3d momentum(const MotionState<V>& s) const {
        const Eigen::Quaterniond q(Eigen::Vector4d(s.x.normalized()));
        return q * moments.cwiseProduct(body_spin(s));
    }
};

}  // namespace zoned::scenario
