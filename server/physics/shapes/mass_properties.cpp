#include "server/physics/shapes/mass_properties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zoned::physics {

namespace {

/// Entries off the diagonal count as zero below this share of the trace: they are then less than
/// the rounding of a float, and turning the axes for them would be arbitrary.
constexpr double kDiagonal = 1.0e-7;
/// Moments that differ by less than this share are equal: cubes stay round.
constexpr double kSameMoment = 1.0e-6;
/// The share that rounding may take from the triangle inequality of a flat body, and from symmetry.
constexpr double kTensorSlack = 1.0e-5;

/// Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5): the columns of
/// `axes` become the eigenvectors. Square roots only, so every compiler gives the same bits.
void diagonalise(Mat3d& m, Mat3d& axes) {
    const auto largest = [&m] {
        return std::max({std::abs(m(0, 1)), std::abs(m(0, 2)), std::abs(m(1, 2))});
    };
    if (largest() <= kDiagonal * m.trace()) {
        return;
    }
    for (int sweep = 0; sweep < 32 && largest() > 1.0e-15 * m.trace(); ++sweep) {
        for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
            if (m(p, q) == 0.0) {
                continue;
            }
            const double theta = (m(q, q) - m(p, p)) / (2.0 * m(p, q));
            const double t =
                (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
            const double c = 1.0 / std::sqrt(t * t + 1.0);
            Mat3d turn = Mat3d::Identity();
            turn(p, p) = c;
            turn(q, q) = c;
            turn(p, q) = t * c;
            turn(q, p) = -t * c;
            m = Mat3d(turn.transpose() * m * turn);
            axes = Mat3d(axes * turn);
        }
    }
}

/// Names the axes so that the rotation turns least: its trace is the largest.
void order_axes(Vec3d& moments, Mat3d& axes) {
    constexpr std::array<std::array<int, 3>, 6> kOrders = {
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    Mat3d best = axes;
    Vec3d best_moments = moments;
    double largest = -4.0;
    for (const auto& order : kOrders) {
        for (int signs = 0; signs < 8; ++signs) {
            Mat3d m;
            for (int i = 0; i < 3; ++i) {
                m.col(i) = axes.col(order[static_cast<std::size_t>(i)]) *
                           ((signs >> i & 1) != 0 ? -1.0 : 1.0);
            }
            if (m.determinant() > 0.0 && m.trace() > largest + 1.0e-9) {
                largest = m.trace();
                best = m;
                for (int i = 0; i < 3; ++i) {
                    best_moments[i] = moments[order[static_cast<std::size_t>(i)]];
                }
            }
        }
    }
    axes = best;
    moments = best_moments;
}

void make_equal(Vec3d& moments) {
    const double close = kSameMoment * moments.sum();
    for (const auto& [i, k] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
        if (std::abs(moments[i] - moments[k]) <= close) {
            moments[k] = moments[i];
        }
    }
}

}  // namespace

void SurfaceIntegral::add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d p = a - apex_;
    const Vec3d q = b - apex_;
    const Vec3d r = c - apex_;
    const double six_volumes = p.dot(q.cross(r));
    const Vec3d sum = p + q + r;
    volume_ += six_volumes / 6.0;
    first_ += six_volumes / 24.0 * sum;
    second_ += six_volumes / 120.0 *
               (sum * sum.transpose() + p * p.transpose() + q * q.transpose() + r * r.transpose());
}

MassProperties SurfaceIntegral::result() const {
    MassProperties out;
    out.mass = volume_;
    if (volume_ == 0.0) {
        out.centre = apex_;
        return out;
    }
    const Vec3d from_apex = first_ / volume_;
    out.centre = apex_ + from_apex;
    const Mat3d about_centre = second_ - volume_ * from_apex * from_apex.transpose();
    out.inertia = about_centre.trace() * Mat3d::Identity() - about_centre;
    return out;
}

MassProperties sum_of(std::span<const MassProperties> parts) {
    MassProperties out;
    for (const MassProperties& part : parts) {
        out.mass += part.mass;
        out.centre += part.mass * part.centre;
    }
    if (out.mass <= 0.0) {
        return {};
    }
    out.centre /= out.mass;
    for (const MassProperties& part : parts) {
        const Vec3d d = part.centre - out.centre;
        out.inertia +=
            part.inertia + part.mass * (d.squaredNorm() * Mat3d::Identity() - d * d.transpose());
    }
    return out;
}

MassProperties moved(const MassProperties& solid, const Mat3d& rotation, const Vec3d& position) {
    return {solid.mass,
            rotation * solid.centre + position,
            rotation * solid.inertia * rotation.transpose()};
}

std::string listed(const Vec3d& v) {
    char text[100];
    std::snprintf(text, sizeof(text), "%.9g, %.9g, %.9g", v.x(), v.y(), v.z());
    return text;
}

core::Result<PrincipalAxes> principal_axes(const Mat3d& tensor) {
    using Axes = core::Result<PrincipalAxes>;
    if (!tensor.allFinite()) {
        return Axes::failure("inertia: not finite");
    }
    const double trace = tensor.trace();
    if (!(trace > 0.0)) {
        return Axes::failure("inertia: not positive");
    }
    if ((tensor - tensor.transpose()).cwiseAbs().maxCoeff() > kTensorSlack * trace) {
        const Vec3d upper(tensor(0, 1), tensor(0, 2), tensor(1, 2));
        const Vec3d lower(tensor(1, 0), tensor(2, 0), tensor(2, 1));
        return Axes::failure("inertia: not symmetric: xy, xz, yz are " + listed(upper) +
                             " and yx, zx, zy are " + listed(lower) + " kg m2");
    }
    Mat3d m = 0.5 * (tensor + tensor.transpose());
    PrincipalAxes out;
    diagonalise(m, out.rotation);
    out.moments = m.diagonal();
    if (!(out.moments.minCoeff() > 0.0)) {
        return Axes::failure("inertia: not positive: the principal moments are " +
                             listed(out.moments) + " kg m2");
    }
    if (out.moments.maxCoeff() > (0.5 + kTensorSlack) * out.moments.sum()) {
        return Axes::failure("inertia: a moment exceeds the sum of the other two: " +
                             listed(out.moments) + " kg m2");
    }
    order_axes(out.moments, out.rotation);
    make_equal(out.moments);
    return out;
}

}  // namespace zoned::physics
