// Semi-implicit Euler for soft bodies: closed forms, its stability limit, and refused inputs.
#include "server/physics/soft/spring_limit.h"
#include "server/physics/soft/volume.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/soft/soft_test.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace zoned::physics::soft {
namespace {

constexpr float kOmega = 10.0F;  // rad/s
constexpr float kSwing = 0.1F;   // m

/// A mass of 1 kg on a spring along x from a pinned node.
SoftDef swing(float stiffness = kOmega * kOmega, float damping = 0.0F) {
    SoftDef def;
    def.nodes.resize(2);
    def.nodes[0].pinned = true;
    def.nodes[1].position = Vec3(1.0F + kSwing, 0, 0);
    def.springs.push_back({0, 1, 1.0F, stiffness, damping, SpringKind::kStructural});
    def.solver.method = SoftMethod::kSemiImplicitEuler;
    return def;
}

SoftSettings stepped(SoftSettings settings, float step_s = kFrame) {
    settings.step_s = step_s;
    return settings;
}

void substep(SoftBody& body, float h) {
    push_springs(body, h);
    predict(body, Vec3::Zero(), h);
    finish(body, h);
}

double stretch_of(const SoftBody& body) {
    return static_cast<double>(body.position(1).x()) - 1.0;
}

/// x[n+1] - 2 x[n] + x[n-1] = -(w h)^2 x[n] from x[1] = (1 - (w h)^2) x[0] is solved by
/// x[n] = x[0] cos((n + 1/2) a) / cos(a / 2) with cos a = 1 - (w h)^2 / 2.
TEST(SemiImplicitSprings, SwingAsTheDifferenceEquationSays) {
    const float h = kFrame / 4;
    SoftBody body = make_body(swing());
    const double wh = static_cast<double>(kOmega * h);
    const double a = std::acos(1.0 - 0.5 * wh * wh);
    for (int n = 1; n <= 240; ++n) {
        substep(body, h);
        const double exact =
            static_cast<double>(kSwing) * std::cos((n + 0.5) * a) / std::cos(a / 2);
        // Each position is rounded by up to 6e-8 m, each velocity of 1 m/s by as much, which is
        // 6e-9 m at 10 rad/s; the first rounds 1.1 by 5e-8.
        ASSERT_NEAR(stretch_of(body), exact, 1.0e-7 + n * 6.6e-8) << n;
    }
}

double swing_error(int substeps) {
    SoftDef def = swing();
    def.solver.substeps = substeps;
    SoftBodies bodies(stepped(weightless_soft()));
    const SoftId id = put(bodies, def);
    double worst = 0.0;
    for (int i = 1; i <= 60; ++i) {
        bodies.step(kFrame, nullptr);
        const double exact = 0.1 * std::cos(10.0 * i / 60.0);
        worst = std::max(worst,
                         std::abs(static_cast<double>(bodies.position(id, 1).x()) - 1.0 - exact));
    }
    return worst;
}

TEST(SemiImplicitSprings, ConvergeWithFirstOrder) {
    const double coarse = swing_error(2);
    const double fine = swing_error(8);
    // The velocities lag by half a substep: w h / 2 of the swing, 1.04 % at h = 1/480.
    EXPECT_NEAR(fine, 0.1 * 10.0 / 960.0, 1.0e-4);
    EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 1.0, 0.1);
}

/// v^2 + w^2 x^2 - h w^2 x v stays as it is, so the energy swings by w h / (2 - w h) of itself at
/// most (|x v| <= (v^2 + w^2 x^2) / (2 w)).
TEST(SemiImplicitSprings, KeepTheEnergyWithinItsSwing) {
    SoftDef def = swing();
    def.solver.substeps = 1;
    SoftBodies bodies(stepped(weightless_soft()));
    const SoftId id = put(bodies, def);
    const double first = bodies.energy(id);
    const double wh = static_cast<double>(kOmega * kFrame);
    for (int i = 0; i < 20'000; ++i) {
        bodies.step(kFrame, nullptr);
        // 20,000 roundings of 6e-8 m in 0.1 m add up like a random walk: 1e-4, doubled in energy.
        ASSERT_NEAR(bodies.energy(id) / first, 1.0, wh / (2.0 - wh) + 5.0e-4) << i;
    }
}

TEST(SemiImplicitSprings, DieAwayWithTheirDamper) {
    SoftDef def = swing(kOmega * kOmega, 2.0F);
    def.solver.substeps = 16;
    SoftBodies bodies(stepped(weightless_soft()));
    const SoftId id = put(bodies, def);
    run(bodies, 60);
    // x = A e^-t (cos w' t + sin w' t / w') with w'^2 = 99; half a substep late, h = 1/960 s: the
    // speed is at most 1 m/s.
    const double w = std::sqrt(99.0);
    const double exact = 0.1 * std::exp(-1.0) * (std::cos(w) + std::sin(w) / w);
    EXPECT_NEAR(static_cast<double>(bodies.position(id, 1).x()) - 1.0, exact, 1.0 / 960.0);
}

TEST(SemiImplicitSprings, StayBoundedUpToTheLimitAndNoFarther) {
    for (const float damping : {0.0F, 4.0F, 40.0F}) {
        SoftBody body = make_body(swing(kOmega * kOmega, damping));
        const double limit = spring_limit(body).step_s();
        // w h = 2 (sqrt(1 + z^2) - z), z = c / (2 w): one spring's bound is exact.
        const double z = static_cast<double>(damping) / 20.0;
        EXPECT_NEAR(limit, 0.2 * (std::sqrt(1.0 + z * z) - z), 1.0e-6) << damping;
        for (const double share : {0.98, 1.02}) {
            SoftBody one = make_body(swing(kOmega * kOmega, damping));
            double most = 0.0;
            for (int i = 0; i < 400 && most < 0.9; ++i) {
                substep(one, static_cast<float>(share * limit));
                most = std::max(most, std::abs(stretch_of(one)));
            }
            // Just below, a vector that is no eigenvector grows by the condition of these: at 0.98
            // of the limit 1 / cos(a / 2) = 5; above, beyond any bound.
            EXPECT_EQ(most < 0.6, share < 1.0) << damping << " " << share << " " << most;
        }
    }
}

/// Nodes drift after the push and are braked on the move. With the push after the drift, the step's
/// matrix had the determinant 1 - c h (1 - (w h)^2 / 2): more than one from w h = sqrt 2 on, by any
/// drag.
TEST(SemiImplicitSprings, LoseNoStabilityByADrag) {
    for (const float drag : {0.1F, 5.0F, 100.0F}) {
        SoftDef def = swing();
        def.material.drag = drag;
        SoftBody body = make_body(def);
        double most = 0.0;
        for (int i = 0; i < 2000 && most < 0.9; ++i) {
            substep(body, 1.9F / kOmega);
            most = std::max(most, std::abs(stretch_of(body)));
        }
        EXPECT_LT(most, 0.1 / std::sqrt(1.0 - 0.95 * 0.95)) << drag;  // 1 / cos(a / 2)
        EXPECT_LT(std::abs(stretch_of(body)), 1.0e-3) << drag;
    }
}

/// K of springs (and volumes) at rest, over masses on both sides; D likewise.
Eigen::MatrixXd matrix_of(const SoftBody& body, bool dampers) {
    const auto n = static_cast<Eigen::Index>(body.x.size());
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    const auto add = [&](double stiffness, std::vector<std::pair<std::uint32_t, Vec3d>> g) {
        for (const auto& [i, gi] : g) {
            for (const auto& [j, gj] : g) {
                k.block<3, 3>(3 * i, 3 * j) += stiffness * gi * gj.transpose();
            }
        }
    };
    for (const Spring& s : body.springs) {
        const Vec3d u = (body.position(s.b) - body.position(s.a)).cast<double>().normalized();
        add(static_cast<double>(dampers ? s.damping : s.stiffness), {{s.a, -u}, {s.b, u}});
    }
    for (std::size_t i = 0; !dampers && i < body.tetrahedra.size(); ++i) {
        const SoftTetrahedron& t = body.tetrahedra[i];
        const auto at = [&](std::size_t c) -> Vec3d {
            return body.position(t[c]).cast<double>();
        };
        const auto g = tetrahedron_gradient(at(0), at(1), at(2), at(3));
        add(static_cast<double>(body.material.bulk_modulus / body.rest_volume[i]),
            {{t[0], g[0]}, {t[1], g[1]}, {t[2], g[2]}, {t[3], g[3]}});
    }
    for (Eigen::Index i = 0; i < n; ++i) {
        const double m = std::sqrt(static_cast<double>(body.x[static_cast<std::size_t>(i)].w()));
        k.middleRows(3 * i, 3) *= m;
        k.middleCols(3 * i, 3) *= m;
    }
    return k;
}

double largest_eigenvalue(const Eigen::MatrixXd& symmetric) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .maxCoeff();
}

TEST(SpringLimit, BoundsTheLargestEigenvalue) {
    SoftDef uneven = cloth(6);
    core::Rng rng(7);
    for (SoftNode& node : uneven.nodes) {
        node.mass *= rng.range(0.2F, 3.0F);
    }
    SoftDef pressed = jelly();
    SoftDef slack = jelly();
    slack.material.bulk_modulus = 0.0F;
    for (const SoftDef& def : {cloth(6), uneven, pressed, slack}) {
        SoftBody body = make_body(def);
        const SpringLimit limit = spring_limit(body);
        const double exact = largest_eigenvalue(matrix_of(body, false));
        EXPECT_GE(limit.omega2, exact * (1.0 - 1.0e-6));
        // The bound is not useless either. The largest eigenvalue of a node's own block is at least
        // a third of its trace (flat cloth: half); the bound has twice the trace. A tetrahedron's
        // four corners instead of two double that, and lengths grow by a quarter.
        const double spread = def.tetrahedra.empty() ? 4.0 : 6.0;
        const bool volumes = def.material.bulk_modulus > 0.0F && !def.tetrahedra.empty();
        EXPECT_LE(limit.omega2, exact * spread * (volumes ? 2.0 * std::pow(1.25, 4) : 1.0));
        const double brake = largest_eigenvalue(matrix_of(body, true));
        EXPECT_GE(limit.damping, brake * (1.0 - 1.0e-6));
        EXPECT_LE(limit.damping, spread * brake);
    }
}

TEST(SpringLimit, FollowsPinsAndBodiesThatNothingHolds) {
    SoftDef def = swing();
    SoftBody body = make_body(def);
    EXPECT_NEAR(spring_limit(body).omega(), 10.0, 1.0e-6);
    def.nodes[0].pinned = false;
    EXPECT_NEAR(spring_limit(def).omega(), 10.0 * std::sqrt(2.0), 1.0e-5);
    def.springs.clear();
    EXPECT_EQ(spring_limit(def).step_s(), std::numeric_limits<double>::infinity());
    // Freed, the light end swings faster than the substeps that were enough before.
    SoftDef light = swing(1.0e4F);
    light.nodes[0].mass = 0.01F;
    SoftBodies bodies(stepped(weightless_soft()));
    const SoftId id = put(bodies, light);
    bodies.pin(id, 0, false);
    const double first = bodies.energy(id);
    run(bodies, 300);
    // 9 substeps: w h = 1.86. The quadratic form that stays as it is lies above 1 - w h / 2 of the
    // energy, and began with the energy itself.
    const double wh = std::sqrt(1.0e4 * 101.0) / 60.0 / 9.0;
    EXPECT_LT(bodies.energy(id), 1.01 * first / (1.0 - wh / 2.0));
    EXPECT_EQ(bodies.stats().quarantined, 0U);
}

/// A stiff damped spring with k dt^2 / m = 10^4.
TEST(SemiImplicitSprings, AreRefusedForAStiffSpringThatImplicitEulerBears) {
    const float stiffness = 1.0e4F / (kFrame * kFrame);
    SoftDef def = swing(stiffness, 0.1F * 2.0F * std::sqrt(stiffness));
    def.solver.substeps = 1;
    SoftBodies bodies(stepped(weightless_soft()));
    const auto refused = bodies.add(def);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().find("omega h = 100"), std::string::npos) << refused.error();
    // 2 (sqrt(1.01) - 0.1)
    EXPECT_NE(refused.error().find("at most 1.81"), std::string::npos) << refused.error();
    EXPECT_EQ(refused.error(), why_unstable(def, kFrame));

    def.solver.method = SoftMethod::kImplicitEuler;
    EXPECT_EQ(why_unstable(def, kFrame), "");
    const SoftId id = put(bodies, def);
    const double first = bodies.energy(id);
    double before = first;
    for (int i = 0; i < 600; ++i) {
        bodies.step(kFrame, nullptr);
        ASSERT_LE(bodies.energy(id), before + 1.0e-6 * first);
        before = bodies.energy(id);
    }
    EXPECT_LT(before, 1.0e-3 * first);
    // In as many pieces as its springs need, explicit springs bear it as well.
    def.solver.method = SoftMethod::kSemiImplicitEuler;
    def.solver.substeps = 0;
    EXPECT_EQ(why_unstable(def, kFrame), "");
    def.springs[0].stiffness *= 30.0F;  // w h = 548 with less damping: more than 256 pieces
    def.springs[0].damping = 0.0F;
    EXPECT_NE(why_unstable(def, kFrame).find("256 substeps are too few"), std::string::npos);
}

TEST(SemiImplicitSprings, AreRefusedWhereNobodySaysHowLongStepsAre) {
    SoftBodies bodies(weightless_soft());
    const auto id = bodies.add(swing());
    ASSERT_FALSE(id.ok());
    EXPECT_NE(id.error().find("how long steps are"), std::string::npos) << id.error();
    SoftBodies hostile(stepped(weightless_soft(), kNan));
    EXPECT_FALSE(hostile.add(swing()).ok());
    SoftDef unfit = swing();
    unfit.springs[0].stiffness = -1.0F;
    SoftBodies fit(stepped(weightless_soft()));
    EXPECT_EQ(fit.add(unfit).error(), "spring 0: stiffness not positive or out of range");
    unfit = swing();
    unfit.nodes[1].mass = 0.0F;
    EXPECT_EQ(fit.add(unfit).error(), "node 1: mass not positive or out of range");
    unfit = swing();
    unfit.solver.method = static_cast<SoftMethod>(3);
    EXPECT_EQ(fit.add(unfit).error(), "unknown method");
}

TEST(SemiImplicitSprings, HoldClothJellyAndBalloonAndKeepTheirMomentum) {
    float aside = 0.0F;
    for (SoftDef def : {cloth(12, 300.0F), jelly(), *build_balloon({})}) {
        def.solver.method = SoftMethod::kSemiImplicitEuler;
        for (SoftNode& n : def.nodes) {
            n.position.z() += aside;
        }
        aside += 20.0F;  // each moves by itself
        core::Rng rng(5);
        for (SoftNode& n : def.nodes) {
            n.pinned = false;
            n.velocity = Vec3(rng.range(-1, 2), rng.range(-1, 1), rng.range(-1, 1));
        }
        SoftBodies bodies(stepped(weightless_soft()));
        const SoftId id = put(bodies, def);
        const double first = bodies.energy(id);
        const Momenta before = momenta(bodies, id);
        run(bodies, 120);
        EXPECT_EQ(bodies.stats().quarantined, 0U);
        // The energy swings; with damping it only falls in the mean.
        EXPECT_LT(bodies.energy(id), first);
        // A push is written to two velocities, each rounded by 6e-8 of its size, a few m/s. With 20
        // substeps a frame and some ten springs a node, the errors add like a random walk; three
        // times its mean is allowed.
        const Momenta after = momenta(bodies, id);
        const auto nodes = static_cast<double>(def.nodes.size());
        const double mass = static_cast<double>(bodies.rigid_hull(id).mass);
        const double rounding = 3.0 * 6.0e-8 * 3.0 * mass / nodes * std::sqrt(nodes * 120 * 256.0);
        EXPECT_LT((after.linear - before.linear).norm(), rounding + 1.0e-6 * before.size);
    }
}

/// Squeezed by a press that closes to a fifth of the balloon's width: gas gets stiffer the less
/// room it has, and substeps follow.
TEST(SemiImplicitSprings, BearABalloonInAPress) {
    soft::BalloonDef balloon;
    balloon.splits = 2;
    balloon.mass = 2.0F;
    balloon.gas_pressure = 1.025e5F;
    SoftDef def = *build_balloon(balloon);
    def.material.thickness = 0.03F;
    def.solver.method = SoftMethod::kSemiImplicitEuler;
    SoftBodies bodies(stepped(weightless_soft()));
    const SoftId id = put(bodies, def);
    Scene scene{PhysicsSettings()};
    std::array<BodyId, 2> jaws;
    for (const std::size_t side : {0U, 1U}) {
        BodyDef jaw;
        jaw.kind = BodyKind::kKinematic;
        jaw.shape = Shape::box(Vec3(0.2F, 2.0F, 2.0F));
        jaw.position = Vec3(side == 0 ? -0.8F : 0.8F, 0, 0);
        jaw.velocity = Vec3(side == 0 ? 0.5F : -0.5F, 0, 0);
        jaws[side] = *scene.add(jaw);
    }
    const double first = bodies.volume(id);
    double least = first;
    std::uint32_t substeps = 0;
    for (int i = 0; i < 60; ++i) {
        bodies.step(kFrame, &scene);
        scene.step(kFrame);
        least = std::min(least, bodies.volume(id));
        substeps = i == 0 ? bodies.stats().substeps : substeps;
        ASSERT_EQ(bodies.stats().quarantined, 0U) << i;
    }
    EXPECT_LT(least, 0.9 * first);
    EXPECT_GT(bodies.stats().substeps, substeps);
    EXPECT_GT(least, 0.0);
    for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
        // All of it went sideways: no farther than a disc of its surface.
        EXPECT_LT(bodies.position(id, i).norm(), 2.0F) << i;
    }
}

TEST(SemiImplicitSprings, AllocateNothingAfterWarmUp) {
    SoftBodies bodies(stepped(awake_soft()));
    float aside = 0.0F;
    for (SoftDef def : {cloth(12, 300.0F), jelly(), *build_balloon({})}) {
        def.solver.method = SoftMethod::kSemiImplicitEuler;
        for (SoftNode& n : def.nodes) {
            n.position.z() += aside;
        }
        aside += 20.0F;  // each moves by itself
        put(bodies, def);
    }
    run(bodies, 10);
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 60; ++i) {
        bodies.step(kFrame, nullptr);
    }
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace zoned::physics::soft
