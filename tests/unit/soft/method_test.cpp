// The methods: accuracy, stability, conserved sums.
#include "server/compute/worker_pool.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/soft/soft_test.h"

#include <cmath>

namespace zoned::physics::soft {
namespace {

class EachMethod : public testing::TestWithParam<SoftMethod> {
  protected:
    [[nodiscard]] SoftDef with(SoftDef def) const {
        def.solver.method = GetParam();
        return def;
    }
};

INSTANTIATE_TEST_SUITE_P(Methods,
                         EachMethod,
                         testing::Values(SoftMethod::kXpbd, SoftMethod::kImplicitEuler),
                         [](const auto& method) {
                             return method.param == SoftMethod::kXpbd ? "Xpbd" : "ImplicitEuler";
                         });

/// A mass on a spring along x, stretched by a tenth of a metre.
SoftDef oscillator(float damping) {
    SoftDef def;
    def.nodes.resize(2);
    def.nodes[0].pinned = true;
    def.nodes[1].position = Vec3(1.1F, 0, 0);
    def.springs.push_back({0, 1, 1.0F, 100.0F, damping, SpringKind::kStructural});
    return def;
}

/// x = 0.1 e^-dt (cos wt + d/w sin wt) with d = c / 2m, w^2 = k/m - d^2.
double oscillation(double t, double damping) {
    const double d = damping / 2.0;
    const double w = std::sqrt(100.0 - d * d);
    return 0.1 * std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
}

double oscillator_error(SoftMethod method, float damping, int substeps) {
    SoftDef def = oscillator(damping);
    def.solver.method = method;
    def.solver.substeps = substeps;
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, def);
    double worst = 0.0;
    for (int i = 1; i <= 60; ++i) {
        bodies.step(kFrame, nullptr);
        const double exact =
            oscillation(static_cast<double>(i) / 60.0, static_cast<double>(damping));
        worst = std::max(worst,
                         std::abs(static_cast<double>(bodies.position(id, 1).x()) - 1.0 - exact));
    }
    return worst;
}

TEST_P(EachMethod, ConvergesToTheOscillatorWithFirstOrder) {
    const double coarse = oscillator_error(GetParam(), 0.0F, 4);
    const double fine = oscillator_error(GetParam(), 0.0F, 16);
    // A step of h multiplies the amplitude by 1 - (w h)^2 / 2: after 1 s at w = 10 and h = 1/960
    // by exp(-100 / 1920): 5.1 mm of 0.1 m. The phase's error is of second order.
    EXPECT_LT(fine, 0.0055);
    EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 1.0, 0.15);
    // With a damper of 2 N s/m the swing dies off by e^-1, and the error comes to less.
    EXPECT_LT(oscillator_error(GetParam(), 2.0F, 16), 0.0055);
}

SoftDef shaken_cloth() {
    SoftDef def = cloth(12);
    core::Rng rng(3);
    for (SoftNode& n : def.nodes) {
        n.velocity = Vec3(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
        n.pinned = false;
    }
    return def;
}

TEST_P(EachMethod, EnergyNeverExceedsWhatWasPutIn) {
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, with(shaken_cloth()));
    const double first = bodies.energy(id);
    double before = first;
    for (int i = 0; i < 200; ++i) {
        bodies.step(kFrame, nullptr);
        const double now = bodies.energy(id);
        // Floats: the sum of kinetic energy is good to 1e-5. One pass of Gauss-Seidel leaves an
        // error. XPBD makes potential energy of it for a while, never more than there was before.
        // Only the minimum that implicit Euler finds has less energy than the state before.
        ASSERT_LE(now, first * (1.0 + 1.0e-5));
        if (GetParam() == SoftMethod::kImplicitEuler) {
            ASSERT_LE(now, before + 1.0e-5 * first) << "step " << i;
        }
        before = now;
    }
    EXPECT_LT(before, 0.5 * first);
}

TEST_P(EachMethod, MomentumStaysInFreeFlight) {
    SoftDef def = with(jelly());
    core::Rng rng(5);
    for (SoftNode& n : def.nodes) {
        n.velocity = Vec3(rng.range(-1, 2), rng.range(-1, 1), rng.range(-1, 1));
    }
    def.solver.gradient_accuracy = 1.0e-8F;
    def.solver.gradient_iterations = 400;
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, def);
    const Momenta before = momenta(bodies, id);
    run(bodies, 60);
    const Momenta after = momenta(bodies, id);
    // Each written position of 2 m is rounded by up to 1.2e-7 m along each axis, which is a
    // velocity of that over h. There are 64 nodes in 60 x 8 substeps, each moved by some 30 springs
    // and tetrahedra. The errors add like a random walk; three times its mean is allowed.
    const double each = 1.2e-7 * 480.0 / 64.0;
    const double rounding = 3.0 * each * std::sqrt(3.0 * 64.0 * 480.0 * 30.0);
    EXPECT_LT((after.linear - before.linear).norm(), rounding);
    // Implicit Euler keeps angular momentum only to first order; XPBD's pushes act along the line
    // between the ends.
    if (GetParam() == SoftMethod::kXpbd) {
        EXPECT_LT((after.angular - before.angular).norm(), 3.0 * rounding);
    }
}

TEST_P(EachMethod, FreeFallIsExact) {
    SoftDef def = with(jelly());
    SoftBodies bodies(awake_soft());
    const SoftId id = put(bodies, def);
    const Vec3 before = bodies.rigid_hull(id).position;
    run(bodies, 60);
    const Vec3 fall = bodies.rigid_hull(id).position - before;
    // 480 roundings of positions of some metres (2.4e-7 m each at most).
    EXPECT_NEAR(fall.y(), -0.5F * kGravity, 480 * 2.4e-7F);
}

TEST_P(EachMethod, StiffClothStaysStable) {
    for (const float k : {1.0e3F, 1.0e6F, 1.0e9F}) {
        SoftDef def = with(cloth(16, k));
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, def);
        run(bodies, 300);
        EXPECT_EQ(bodies.stats().quarantined, 0U);
        // No node hangs lower than the diagonal of the square, half as long again where the method
        // has not converged, and all together are no faster than the fall that far.
        double kinetic = 0.0;
        for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
            kinetic += 0.5 * static_cast<double>(bodies.mass(id, i)) *
                       static_cast<double>(bodies.velocity(id, i).squaredNorm());
        }
        EXPECT_LT(kinetic, 0.8 * 9.81 * 2.83);
        for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
            ASSERT_LT(bodies.position(id, i).norm(), 4.5F) << k;
        }
    }
}

TEST_P(EachMethod, NoAllocationAfterWarmUp) {
    SoftBodies bodies(awake_soft());
    SoftDef folded = with(cloth(8));
    folded.material.self_collision = true;
    float aside = 0.0F;
    for (SoftDef def : {with(cloth(12)), with(jelly()), with(*build_balloon({})), folded}) {
        for (SoftNode& n : def.nodes) {
            n.position.z() += aside;
        }
        put(bodies, def);
        aside += 20.0F;  // each falls by itself
    }
    Scene scene{PhysicsSettings()};
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::plane();
    ground.position = Vec3(0, -1, 0);
    ASSERT_TRUE(scene.add(ground).ok());
    run(bodies, 180, &scene);
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 60; ++i) {
        bodies.step(kFrame, &scene);
    }
    EXPECT_EQ(allocation_count(), before);
}

TEST(SoftThreads, GiveTheSameBits) {
    std::vector<std::uint64_t> hashes;
    for (const unsigned threads : {1U, 2U, 4U}) {
        compute::WorkerPool pool(threads);
        compute::Team team;
        team.join_pool(pool);
        SoftBodies bodies;
        bodies.work_with(&team);
        put(bodies, cloth(40));  // large: all threads at one
        for (int i = 0; i < 5; ++i) {
            put(bodies, jelly());
        }
        SoftDef implicit = cloth(10);
        implicit.solver.method = SoftMethod::kImplicitEuler;
        put(bodies, implicit);
        put(bodies, *build_balloon({}));
        run(bodies, 12);
        hashes.push_back(hash_of(bodies));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(SoftHash, SeesASingleNode) {
    SoftBodies a;
    SoftBodies b;
    const SoftId id = put(a, cloth(5));
    put(b, cloth(5));
    EXPECT_EQ(hash_of(a), hash_of(b));
    a.apply_impulse(id, 7, Vec3(0, 1e-6F, 0));
    EXPECT_NE(hash_of(a), hash_of(b));
}

TEST(CoarseCloth, HasTheMassAndThePlaceOfTheFineOne) {
    ClothDef def;
    def.nx = def.nz = 64;
    def.size_x = def.size_z = 2.0F;
    def.pins = {{0, 0}, {63, 0}};
    def.coarsen = 0;
    SoftBodies bodies;
    const SoftId id = put(bodies, *build_cloth(def));
    EXPECT_EQ(bodies.node_count(id), 22U * 22U);
    ASSERT_EQ(bodies.vertex_count(id), 64U * 64U);
    EXPECT_NEAR(bodies.rigid_hull(id).mass, 0.2F * 4.0F, 1e-5F);
    std::vector<Vec3> drawn(64 * 64);
    bodies.vertices(id, drawn);
    for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
            const Vec3 fine(
                2.0F * static_cast<float>(i) / 63.0F, 0, 2.0F * static_cast<float>(j) / 63.0F);
            ASSERT_LT((drawn[static_cast<std::size_t>(j * 64 + i)] - fine).norm(), 1e-6F);
        }
    }
    def.coarsen = 5;
    EXPECT_FALSE(build_cloth(def).ok());
}

}  // namespace
}  // namespace zoned::physics::soft
