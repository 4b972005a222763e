// build: computes
#include "tests/scenario/overlaps.h"
#include "tests/scenario/physics_scenes.h"
#include "tests/scenario/spin_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::scenario {
namespace {

std::size_t moving(const Description& d) {
    std::size_t count = 0;
    for (const Body& body : d.bodies) {
        count += body.mass > 0.0 ? 1u : 0u;
    }
    return count;
}

/// Depths at the start, beyond rounding of positions written as decimals.
double deepest(const Description& d) {
    std::vector<Pose> poses;
    for (const Body& body : d.bodies) {
        poses.push_back(body.pose);
    }
    const Overlaps overlaps = find_overlaps(d.bodies, poses);
    double depth = 0.0;
    for (const auto* list : {&overlaps.pairs, &overlaps.floor, &overlaps.fixed}) {
        for (const double value : *list) {
            depth = std::max(depth, value);
        }
    }
    return depth;
}

TEST(PhysicsScenes, HoldAsManyBodiesAsDescribed) {
    EXPECT_EQ(moving(pyramid()), 210u);
    EXPECT_EQ(moving(column(20, 1.0)), 20u);
    EXPECT_EQ(moving(pile(16)), 4096u);
    EXPECT_EQ(moving(resting_field(100)), 10'000u);
    EXPECT_EQ(moving(chain()), 21u);
    EXPECT_EQ(chain().joints.size(), 21u);
    EXPECT_EQ(moving(bullets()), 20u);
    EXPECT_EQ(column(5, 100.0).bodies.back().mass, 100.0);
}

TEST(PhysicsScenes, StartWithoutOverlap) {
    for (const Description& d : {pyramid(), column(20, 1.0), pile(16), bounce(1.0, 1.0, 0.01)}) {
        EXPECT_LT(deepest(d), 1e-9);
    }
}

TEST(PhysicsScenes, HangTheChainOnItsJoints) {
    const Description d = chain();
    for (const LinkedPair& joint : d.joints) {
        const Body& b = d.bodies[static_cast<std::size_t>(joint.b)];
        EXPECT_NEAR((b.pose.position - joint.anchor).norm(), 0.5, 1e-12);
        if (joint.a != kWorld) {
            const Body& a = d.bodies[static_cast<std::size_t>(joint.a)];
            EXPECT_NEAR((a.pose.position - joint.anchor).norm(), 0.5, 1e-12);
        }
    }
}

/// Moments by sampling the volume on a fine grid; n cells along an edge leave a relative error of
/// the order of 1/n at curved surfaces.
TEST(Solid, HasTheMomentsOfItsVolume) {
    for (const Solid& solid :
         {Solid::sphere(0.5), Solid::box({1, 2, 3}), Solid::capsule(0.4, 0.2)}) {
        constexpr int kCells = 100;
        const double edge = 3.0 / kCells;
        double volume = 0.0;
        Vec3d moments = Vec3d::Zero();
        for (int i = 0; i < kCells * kCells * kCells; ++i) {
            const Vec3d p = (Vec3d(i % kCells, i / kCells % kCells, i / kCells / kCells) +
                             Vec3d::Constant(0.5)) *
                                edge -
                            Vec3d::Constant(1.5);
            bool inside = false;
            if (solid.form == Form::kBox) {
                inside = (p.cwiseAbs().array() < solid.half_extents.array()).all();
            } else {
                const double h = solid.form == Form::kCapsule ? solid.half_segment : 0.0;
                const Vec3d core(0.0, std::clamp(p.y(), -h, h), 0.0);
                inside = (p - core).norm() < solid.radius;
            }
            if (inside) {
                volume += edge * edge * edge;
                const Vec3d q = p.cwiseProduct(p);
                moments += Vec3d(q.y() + q.z(), q.x() + q.z(), q.x() + q.y()) * edge * edge * edge;
            }
        }
        EXPECT_NEAR(volume / solid.volume(), 1.0, 0.02);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(moments[axis] / volume / solid.inertia_per_mass()[axis], 1.0, 0.02);
        }
    }
}

/// Half the period of the middle component (Landau, Lifshitz, "Mechanics", section 37): 2 K(k) over
/// the rate of the elliptic sine.
double half_period(const Vec3d& inertia, const Vec3d& omega) {
    Vec3d i = inertia;
    const double energy2 = omega.dot(inertia.cwiseProduct(omega));
    const double momentum2 = inertia.cwiseProduct(omega).squaredNorm();
    std::sort(i.data(), i.data() + 3);
    if (momentum2 < energy2 * i[1]) {
        std::swap(i[0], i[2]);
    }
    const double a = (i[2] - i[1]) * (momentum2 - energy2 * i[0]);
    const double b = (i[1] - i[0]) * (energy2 * i[2] - momentum2);
    return 2.0 * std::comp_ellint_1(std::sqrt(b / a)) / std::sqrt(a / i.prod());
}

/// The exact count that the scene's description states.
TEST(FreeSpin, OfTheSpinSceneFlipsNineTimes) {
    const Body body = spin().bodies.front();
    const SpinReference reference =
        free_spin(body.mass * body.solid.inertia_per_mass(), body.spin, 60.0);
    EXPECT_EQ(reference.flips, 9);
    // The counter draws a straight line between samples, which moves a crossing by less than a
    // sample: 1e-4 s.
    const Vec3d inertia = body.mass * body.solid.inertia_per_mass();
    EXPECT_NEAR(reference.interval_s, half_period(inertia, body.spin), 1e-4);
    EXPECT_LT(std::abs(reference.energy_drift), 1e-9);
}

/// A symmetric top: the spin along its axis stays, the rest turns at (I3 - I1) / I1 w3.
TEST(FreeSpin, OfASymmetricTopTurnsAtTheKnownRate) {
    const Vec3d inertia(2.0, 2.0, 3.0);
    const Vec3d omega(0.3, 0.0, 4.0);
    const double seconds = 5.0;
    const SpinReference reference = free_spin(inertia, omega, seconds);
    const double angle = (3.0 - 2.0) / 2.0 * 4.0 * seconds;
    EXPECT_NEAR(reference.omega_end.x(), 0.3 * std::cos(angle), 1e-9);
    EXPECT_NEAR(reference.omega_end.y(), 0.3 * std::sin(angle), 1e-9);
    EXPECT_NEAR(reference.omega_end.z(), 4.0, 1e-9);
}

}  // namespace
}  // namespace zoned::scenario
