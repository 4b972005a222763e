#include "server/physics/shapes/mass_properties.h"

#include "tests/unit/physics/hulls.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::physics {
namespace {

MassProperties box_of(const Vec3d& half, const Vec3d& centre, double density) {
    MassProperties box;
    box.mass = 8.0 * half.prod() * density;
    box.centre = centre;
    const Vec3d s = half.cwiseAbs2();
    box.inertia = Vec3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal();
    box.inertia *= box.mass / 3.0;
    return box;
}

TEST(SumOf, TwoHalvesOfABoxIsTheBox) {
    const MassProperties halves[] = {box_of({0.5, 1, 1.5}, {-0.5, 2, 3}, 2.0),
                                     box_of({0.5, 1, 1.5}, {0.5, 2, 3}, 2.0)};
    const MassProperties whole = box_of({1, 1, 1.5}, {0, 2, 3}, 2.0);
    const MassProperties sum = sum_of(halves);
    EXPECT_DOUBLE_EQ(sum.mass, whole.mass);
    EXPECT_LT((sum.centre - whole.centre).norm(), 1e-14);
    EXPECT_TRUE(sum.inertia.isApprox(whole.inertia, 1e-14));
}

TEST(SumOf, NothingHasNoMass) {
    EXPECT_EQ(sum_of(std::span<const MassProperties>()).mass, 0.0);
}

TEST(Moved, TurnsTheTensorAndCarriesTheCentre) {
    const Mat3d quarter(Eigen::AngleAxisd(1.5707963267948966, Vec3d::UnitZ()));
    const MassProperties turned = moved(box_of({1, 2, 3}, {1, 0, 0}, 1.0), quarter, {0, 0, 5});
    EXPECT_LT((turned.centre - Vec3d(0, 1, 5)).norm(), 1e-12);
    EXPECT_TRUE(turned.inertia.isApprox(box_of({2, 1, 3}, {0, 1, 5}, 1.0).inertia, 1e-12));
}

TEST(PrincipalAxes, RecoverTheMomentsOfATurnedTensor) {
    core::Rng rng(41);
    for (int round = 0; round < 500; ++round) {
        const double x = rng.range(0.1F, 2.0F);
        const double y = rng.range(0.1F, 2.0F);
        const Mat3d diagonal = box_of({x, y, rng.range(0.1F, 2.0F)}, Vec3d::Zero(), 1.0).inertia;
        const Mat3d r = random_rotation(rng).toRotationMatrix().cast<double>();
        const Mat3d orthogonal = Eigen::Quaterniond(r).normalized().toRotationMatrix();
        const Mat3d tensor = orthogonal * diagonal * orthogonal.transpose();
        const PrincipalAxes axes = *principal_axes(tensor);
        const Mat3d back = axes.rotation * axes.moments.asDiagonal() * axes.rotation.transpose();
        // Off-diagonal entries of up to 1e-7 of the trace count as rounding.
        ASSERT_LT((back - tensor).cwiseAbs().maxCoeff(), 3e-6 * tensor.trace());
        ASSERT_NEAR(axes.rotation.determinant(), 1.0, 1e-12);
        // Of the 24 turns of a cube one is within 62.8 degrees of any rotation: trace 1.914.
        ASSERT_GT(axes.rotation.trace(), 1.91);
    }
}

TEST(PrincipalAxes, AreTheGivenOnesOfADiagonalTensor) {
    const PrincipalAxes axes = *principal_axes(Vec3d(3, 2, 4).asDiagonal());
    EXPECT_EQ(axes.rotation, Mat3d::Identity());
    EXPECT_EQ(axes.moments, Vec3d(3, 2, 4));
}

TEST(PrincipalAxes, RefuseWhatNoBodyHas) {
    const auto reason = [](const Mat3d& tensor) {
        const auto axes = principal_axes(tensor);
        return axes ? std::string() : axes.error();
    };
    Mat3d m = Mat3d::Identity();
    m(0, 1) = 0.1;
    EXPECT_EQ(reason(m),
              "inertia: not symmetric: xy, xz, yz are 0.1, 0, 0 and yx, zx, zy are 0, 0, 0 kg m2");
    m(1, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(reason(m), "inertia: not finite");
    EXPECT_EQ(reason(Vec3d(1, 1, 2.1).asDiagonal()),
              "inertia: a moment exceeds the sum of the other two: 1, 1, 2.1 kg m2");
    EXPECT_EQ(reason(Vec3d(1, 1, 2).asDiagonal()), "");  // a flat plate
    EXPECT_EQ(reason(Vec3d(-1, 1, 1).asDiagonal()),
              "inertia: not positive: the principal moments are -1, 1, 1 kg m2");
    EXPECT_EQ(reason(Mat3d::Zero()), "inertia: not positive");
}

}  // namespace
}  // namespace zoned::physics
