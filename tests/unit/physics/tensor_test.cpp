// Inertia tensors given by the caller: refused ones, and how unaligned bodies turn.
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/mass_properties.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace zoned::physics {
namespace {

BodyDef with(const Mat3& tensor) {
    BodyDef def;
    def.shape = Shape::sphere(0.5F);
    def.inertia = tensor;
    return def;
}

Mat3 turned_tensor(const Quat& tilt, const Vec3& moments) {
    const Mat3d r = tilt.cast<double>().normalized().toRotationMatrix();
    return (r * moments.cast<double>().asDiagonal() * r.transpose()).cast<float>();
}

TEST(InertiaTensor, IsRefusedWithItsValuesWhenNoBodyCanHaveIt) {
    Mat3 skew = Vec3(1, 2, 2.5F).asDiagonal();
    skew(0, 1) = 0.25F;
    EXPECT_NE(why_unfit(with(skew)).find("not symmetric: xy, xz, yz are 0.25"), std::string::npos);
    const Mat3 long_one = Vec3(1, 2, 3.5F).asDiagonal();
    EXPECT_NE(why_unfit(with(long_one)).find("sum of the other two: 1, 2, 3.5"), std::string::npos);
    const Mat3 negative = Vec3(2, -1, 2).asDiagonal();
    EXPECT_NE(why_unfit(with(negative)).find("not positive: the principal moments are 2, -1, 2"),
              std::string::npos);
    Mat3 nan = Mat3::Identity();
    nan(2, 1) = NAN;
    EXPECT_NE(why_unfit(with(nan)).find("not finite"), std::string::npos);
    EXPECT_NE(why_unfit(with(Mat3(1e-30F * Mat3::Identity()))).find("out of range"),
              std::string::npos);
    BodyDef both = with(Mat3::Identity());
    both.moments = Vec3(1, 1, 1);
    EXPECT_NE(why_unfit(both).find("both"), std::string::npos);
    // A flat plate is on the border: rounding must not refuse it.
    const Quat tilt = Quat(0.7F, 0.2F, -0.5F, 0.4F).normalized();
    EXPECT_EQ(why_unfit(with(turned_tensor(tilt, Vec3(1, 2, 3)))), "");
}

/// Three-point Gauss quadrature per axis over a box is exact for polynomials of degree five. The
/// integrands of second moments have degree two, so only the rounding of floats remains.
TEST(InertiaTensor, OfABoxIsWhatGaussQuadratureGives) {
    constexpr std::array kNodes{-0.7745966692414834, 0.0, 0.7745966692414834};
    constexpr std::array kWeights{5.0 / 18, 8.0 / 18, 5.0 / 18};
    const Vec3d half(0.3, 0.7, 1.1);
    Vec3d moments = Vec3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3d s =
                    half.cwiseProduct(Vec3d(kNodes[i], kNodes[j], kNodes[k])).cwiseAbs2();
                moments += 5.0 * kWeights[i] * kWeights[j] * kWeights[k] *
                           Vec3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
            }
        }
    }
    const Vec3 got = principal_inertia(Shape::box(half.cast<float>()), 5.0F);
    EXPECT_TRUE(got.cast<double>().isApprox(moments, 1e-6));
}

TEST(InertiaTensor, ThatIsDiagonalGivesTheVeryBitsOfPrincipalMoments) {
    BodyDef a = with(Mat3(Vec3(1, 2, 2.5F).asDiagonal()));
    BodyDef b = with(Mat3::Zero());
    b.moments = Vec3(1, 2, 2.5F);
    core::StateHash hash[2];
    int i = 0;
    for (BodyDef* def : {&a, &b}) {
        def->angular_velocity = Vec3(3, -2, 1);
        Scene scene(weightless());
        ASSERT_TRUE(scene.add(*def).ok());
        for (int n = 0; n < 100; ++n) {
            scene.step(1.0F / 60.0F);
        }
        scene.hash(hash[i++]);
    }
    EXPECT_EQ(hash[0].value(), hash[1].value());
}

struct Twins {
    Scene scene{weightless()};
    Quat tilt = Quat(0.8F, 0.3F, -0.4F, 0.2F).normalized();
    Vec3 moments{1.0F, 2.0F, 2.6F};
    BodyId tilted, principal;

    /// The same mass twice: once in body axes that are tilted, once in its principal axes.
    Twins() {
        BodyDef def = with(turned_tensor(tilt, moments));
        def.angular_velocity = Vec3(0.5F, 4.0F, 0.7F);
        def.position = Vec3(-50, 0, 0);
        tilted = *scene.add(def);
        def.inertia.setZero();
        def.moments = moments;
        def.orientation = tilt;
        def.position = Vec3(50, 0, 0);
        principal = *scene.add(def);
    }

    [[nodiscard]] Vec3d momentum(BodyId id, const Quat& to_principal) const {
        const BodyState s = scene.state(id);
        const Mat3d r =
            (s.orientation * to_principal).cast<double>().normalized().toRotationMatrix();
        const Vec3d w = s.angular_velocity.cast<double>();
        return r * moments.cast<double>().cwiseProduct(r.transpose() * w);
    }
};

TEST(InertiaTensor, ThatIsTiltedTurnsLikeTheSameBodyInPrincipalAxes) {
    Twins t;
    const Vec3d before = t.momentum(t.tilted, t.tilt);
    const double energy = before.dot(t.scene.state(t.tilted).angular_velocity.cast<double>());
    for (int i = 0; i < 600; ++i) {
        t.scene.step(1.0F / 60.0F);
    }
    const BodyState a = t.scene.state(t.tilted);
    const BodyState b = t.scene.state(t.principal);
    // Both round orientation and spin to floats in each of 600 steps, and the tilt twice more: at
    // random sign sqrt(600) eps. Phase errors grow with their time of action, to some 600 times
    // that of one spin: 600 x 1/60 s x 4 rad/s x eps sqrt(600) = 1e-4.
    EXPECT_GT(std::abs(a.orientation.dot(b.orientation * t.tilt.conjugate())), 1.0F - 1e-6F);
    EXPECT_LT((a.angular_velocity - b.angular_velocity).norm(), 2e-3F);
    const Vec3d after = t.momentum(t.tilted, t.tilt);
    EXPECT_LT((after - before).norm(), 1e-4 * before.norm());
    // The splitting's energy swings by second order in pieces of 0.02 rad.
    EXPECT_NEAR(after.dot(a.angular_velocity.cast<double>()) / energy, 1.0, 1e-3);
}

TEST(InertiaTensor, ThatIsTiltedTakesImpulsesAsTheTensorSays) {
    Twins t;
    t.scene.set_velocity(t.tilted, Vec3::Zero(), Vec3::Zero());
    const Vec3 arm(0.3F, -0.2F, 0.1F);
    const Vec3 impulse(0.6F, 1.5F, -1.2F);
    const Vec3 moment = 2.0F * arm.cross(impulse);
    const Vec3 centre = t.scene.state(t.tilted).position;
    t.scene.apply_impulse(t.tilted, impulse, centre + arm);
    t.scene.apply_impulse(t.tilted, -impulse, centre - arm);
    const Vec3 expected = turned_tensor(t.tilt, t.moments).inverse() * moment;
    EXPECT_LT((t.scene.state(t.tilted).angular_velocity - expected).norm(), 1e-5F);
    EXPECT_LT((t.momentum(t.tilted, t.tilt) - moment.cast<double>()).norm(), 1e-5);
}

TEST(InertiaTensor, ThatIsTiltedKeepsAngularMomentumInACollision) {
    PhysicsSettings s = weightless();
    Scene scene(s);
    const Quat tilt = Quat(0.8F, 0.3F, -0.4F, 0.2F).normalized();
    const Vec3 moments(0.1F, 0.2F, 0.26F);
    BodyDef def = with(turned_tensor(tilt, moments));
    def.shape = Shape::box({0.5F, 0.4F, 0.3F});
    def.material = {0.6F, 0.3F};
    def.user = 1;
    BodyId ids[2];
    for (int i = 0; i < 2; ++i) {
        def.position = Vec3(i == 0 ? -1.0F : 1.0F, i * 0.3F, 0.1F);
        def.velocity = Vec3(i == 0 ? 3.0F : -3.0F, 0, 0);
        def.angular_velocity = Vec3(0.5F, 0.2F, -0.3F);
        ids[i] = *scene.add(def);
    }
    const auto momentum = [&] {
        Vec3d sum = Vec3d::Zero();
        for (const BodyId id : ids) {
            const BodyState st = scene.state(id);
            const Mat3d r = (st.orientation * tilt).cast<double>().normalized().toRotationMatrix();
            sum += st.position.cast<double>().cross(st.velocity.cast<double>()) +
                   r * moments.cast<double>().cwiseProduct(r.transpose() *
                                                           st.angular_velocity.cast<double>());
        }
        return sum;
    };
    const Vec3d before = momentum();
    bool met = false;
    for (int i = 0; i < 60; ++i) {
        scene.step(1.0F / 60.0F);
        met |= !scene.contact_events().empty();
    }
    EXPECT_TRUE(met);
    // The bound of momentum_test.cpp: 200 eps of the absolute terms, about 7 kg m2/s here.
    EXPECT_LT((momentum() - before).norm(), 200 * 1.2e-7 * 7.0);
}

}  // namespace
}  // namespace zoned::physics
