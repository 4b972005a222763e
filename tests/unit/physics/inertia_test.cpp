// build: computes
#include "server/physics/shapes/compound/inertia.h"

#include <gtest/gtest.h>

namespace zoned::physics {
namespace {

bool inside(const Shape& s, const Vec3d& p) {
    switch (s.kind) {
        case ShapeKind::kSphere:
            return p.norm() <= s.radius;
        case ShapeKind::kBox:
            return (p.cwiseAbs().array() <= s.half_extents.cast<double>().array()).all();
        case ShapeKind::kCapsule: {
            const double y = std::clamp(p.y(), -double{s.half_segment}, double{s.half_segment});
            return (p - Vec3d(0, y, 0)).norm() <= s.radius;
        }
        default:
            break;
    }
    return false;
}

/// Midpoint rule on an n^3 lattice over the bounding cube. A smooth boundary cuts the cells at
/// random, so the relative error of the sums is of order 1/n^1.5 to 1/n^2; n = 160 gives well under
/// 0.2 %.
void check(const Shape& shape, const Vec3d& reach) {
    constexpr int kN = 160;
    const Vec3d cell = 2.0 * reach / kN;
    double total = 0;
    Vec3d moments = Vec3d::Zero();
    for (int i = 0; i < kN; ++i) {
        for (int j = 0; j < kN; ++j) {
            for (int k = 0; k < kN; ++k) {
                const Vec3d p = cell.cwiseProduct(Vec3d(i + 0.5, j + 0.5, k + 0.5)) - reach;
                if (inside(shape, p)) {
                    const Vec3d s = p.cwiseAbs2();
                    total += 1;
                    moments += Vec3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
                }
            }
        }
    }
    const double mass = 3.0;
    const Vec3d expected = moments * (mass / total);
    const Vec3 got = principal_inertia(shape, static_cast<float>(mass));
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(got[i] / expected[i], 1.0, 2e-3) << i;
    }
    EXPECT_NEAR(volume(shape) / (total * cell.prod()), 1.0, 2e-3);
}

TEST(Inertia, OfASphereMatchesTheIntegral) {
    check(Shape::sphere(0.7F), Vec3d::Constant(0.7));
}

TEST(Inertia, OfABoxMatchesTheIntegral) {
    check(Shape::box({0.5F, 1.0F, 1.5F}), Vec3d(0.5, 1.0, 1.5));
}

TEST(Inertia, OfACapsuleMatchesTheIntegral) {
    check(Shape::capsule(0.4F, 0.9F), Vec3d(0.4, 1.3, 0.4));
}

TEST(Inertia, OfACapsuleWithoutACylinderIsThatOfASphere) {
    const Vec3 capsule = principal_inertia(Shape::capsule(0.5F, 1e-6F), 2.0F);
    const Vec3 sphere = principal_inertia(Shape::sphere(0.5F), 2.0F);
    // The cylinder's share of the mass is 1.5e-6 x 2: a few times a float's epsilon.
    EXPECT_TRUE(capsule.isApprox(sphere, 1e-5F));
}

TEST(Inertia, TensorTurnsWithTheBody) {
    const Vec3 moments(1, 2, 3);
    const Mat3 quarter(Eigen::AngleAxisf(1.57079633F, Vec3::UnitZ()));
    const Mat3 turned = rotated_tensor(quarter, moments);
    // A quarter turn about z swaps the x and y moments.
    EXPECT_TRUE(turned.isApprox(Vec3(2, 1, 3).asDiagonal().toDenseMatrix(), 1e-6F));
}

}  // namespace
}  // namespace zoned::physics
