// Accelerations: the interface through which integrators ask for a force, and that of a free body.
#pragma once

#include <Eigen/Core>

#include <concepts>

namespace zoned::physics {

/// State columns V are fixed-size Eigen vectors (coordinates of one thing), or fixed-size Eigen
/// arrays of L rows and D columns: L things side by side, one column per coordinate.
template <class V>
using RealOf = typename V::Scalar;

/// The acceleration a(x, v, t) in m/s2 of positions in m, velocities in m/s, at the time t in s.
template <class A, class V>
concept Acceleration = requires(const A& a, const V& x, RealOf<V> t) {
    { a(x, x, t) } -> std::convertible_to<V>;
};

/// How a state holds its things, and derivatives of an acceleration: a matrix N x N for a vector;
/// for L things of D coordinates an array L x D D, whose column i D + j holds the derivatives of
/// coordinate i by coordinate j.
template <class V>
struct Layout;

template <class Real, int kN>
struct Layout<Eigen::Matrix<Real, kN, 1>> {
    static constexpr int kThings = 1;
    static constexpr int kCoordinates = kN;
    using Jacobian = Eigen::Matrix<Real, kN, kN>;

    static Real& at(Eigen::Matrix<Real, kN, 1>& state, int, int i) { return state.coeffRef(i); }

    static Real at(const Eigen::Matrix<Real, kN, 1>& state, int, int i) { return state[i]; }

    static Real& at(Jacobian& all, int, int i, int j) { return all.coeffRef(i, j); }
};

template <class Real, int kL, int kD>
struct Layout<Eigen::Array<Real, kL, kD>> {
    static constexpr int kThings = kL;
    static constexpr int kCoordinates = kD;
    using Jacobian = Eigen::Array<Real, kL, kD * kD>;

    static Real& at(Eigen::Array<Real, kL, kD>& state, int thing, int i) {
        return state.coeffRef(thing, i);
    }

    static Real at(const Eigen::Array<Real, kL, kD>& state, int thing, int i) {
        return state(thing, i);
    }

    static Real& at(Jacobian& all, int thing, int i, int j) {
        return all.coeffRef(thing, i * kD + j);
    }
};

template <class V>
using JacobianOf = typename Layout<V>::Jacobian;

/// An acceleration that knows its derivatives: jacobian(x, v, t, da/dx, da/dv) fills both.
template <class A, class V>
concept WithJacobian =
    requires(const A& a, const V& x, RealOf<V> t, JacobianOf<V>& dx, JacobianOf<V>& dv) {
        a.jacobian(x, x, t, dx, dv);
    };

/// An acceleration that knows which part of it is a drag in proportion to the velocity:
/// a(x, v, t) = pull(x, t) - drag() v, with drag() >= 0 in 1/s.
template <class A, class V>
concept WithLinearDrag = requires(const A& a, const V& x, RealOf<V> t) {
    { a.pull(x, t) } -> std::convertible_to<V>;
    { a.drag() } -> std::convertible_to<RealOf<V>>;
};

/// The force on a free body through a step: a constant pull (weight and forces over mass, m/s2) and
/// a linear drag (1/s).
template <class Real, int kN>
class FreeFall {
  public:
    using Vector = Eigen::Matrix<Real, kN, 1>;
    using Square = Eigen::Matrix<Real, kN, kN>;

    FreeFall(const Vector& pull, Real drag) : pull_(pull), drag_(drag) {}

    Vector operator()(const Vector&, const Vector& v, Real) const { return pull_ - drag_ * v; }

    [[nodiscard]] Vector pull(const Vector&, Real) const { return pull_; }

    [[nodiscard]] Real drag() const { return drag_; }

    void jacobian(const Vector&, const Vector&, Real, Square& dx, Square& dv) const {
        dx.setZero();
        dv = -drag_ * Square::Identity();
    }

  private:
    Vector pull_;
    Real drag_;
};

/// For methods that look at nothing but the state.
struct NoMemory {
    template <class... Anything>
    void start(const Anything&...) {}
};

}  // namespace zoned::physics
