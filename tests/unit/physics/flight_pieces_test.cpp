// Free flight in several pieces a step, and methods refused for a drag.
#include "server/physics/integrator/free_flight.h"
#include "server/physics/integrator/stability.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kDrag = 2.0F;
constexpr float kTick = 1.0F / 30;

/// Where a body with a linear drag is after a second.
Vec3 flown(IntegratorKind kind, int pieces, bool particle) {
    PhysicsSettings settings;
    settings.body_integrator = settings.particle_integrator = kind;
    settings.body_flight_pieces = settings.particle_flight_pieces = pieces;
    Scene scene(settings);
    BodyDef def;
    def.kind = particle ? BodyKind::kParticle : BodyKind::kDynamic;
    def.velocity = Vec3(10, 10, 0);
    def.damping.linear = kDrag;
    const BodyId id = *scene.add(def);
    for (int i = 0; i < 30; ++i) {
        scene.step(kTick);
    }
    return scene.state(id).position;
}

double error_of(IntegratorKind kind, int pieces, bool particle) {
    // v = e + (v0 - e) e^-ct, e = g / c.
    const double c = static_cast<double>(kDrag);
    const Vec3d end(0.0, -static_cast<double>(kGravity) / c, 0.0);
    const Vec3d exact = end - std::expm1(-c) / c * (Vec3d(10, 10, 0) - end);
    return (flown(kind, pieces, particle).cast<double>() - exact).norm();
}

TEST(FlightPieces, CutTheErrorByTheOrderOfTheMethod) {
    for (const bool particle : {false, true}) {
        for (const auto& [kind, order] : {std::pair(IntegratorKind::kDefault, 1.0),
                                          std::pair(IntegratorKind::kExplicitEuler, 1.0),
                                          std::pair(IntegratorKind::kSemiImplicitEuler, 1.0),
                                          std::pair(IntegratorKind::kRk2, 2.0)}) {
            const double ratio = error_of(kind, 2, particle) / error_of(kind, 8, particle);
            // The next term of the error is smaller by c h = 0.07 and its quarter; floats add 30
            // roundings of 2.4e-7 m to an error of at least 3e-5 m.
            EXPECT_NEAR(std::log2(ratio) / 2.0, order, 0.2) << name_of(kind) << particle;
        }
    }
}

TEST(FlightPieces, OneIsTheFlightThatWas) {
    const FreeFall<float, 3> fall(Vec3(0.1F, -9.81F, 0.3F), 0.7F);
    for (const IntegratorKind kind : kIntegratorKinds) {
        Vec3 x(3, 4, 5);
        Vec3 v(-7, 11, 13);
        Vec3 y = x;
        Vec3 w = v;
        free_flight(kind, fall, kTick, x, v);
        free_flight_in(1, kind, fall, kTick, y, w);
        EXPECT_EQ(x, y) << name_of(kind);
        EXPECT_EQ(v, w) << name_of(kind);
    }
}

TEST(WhyUnstableDrag, NamesTheProductAndTheLimit) {
    const std::string reason = why_unstable_drag(IntegratorKind::kExplicitEuler, 100.0, 1.0 / 30);
    EXPECT_NE(reason.find("explicit_euler: a drag of 100 1/s"), std::string::npos) << reason;
    EXPECT_NE(reason.find("drag x h = 3.333, at most 2"), std::string::npos) << reason;
    EXPECT_EQ(why_unstable_drag(IntegratorKind::kExplicitEuler, 59.9, 1.0 / 30), "");
    EXPECT_EQ(why_unstable_drag(IntegratorKind::kDefault, 1.0e4, 1.0), "");
    EXPECT_EQ(why_unstable_drag(IntegratorKind::kExplicitEuler, 0.0, 1.0), "");
}

}  // namespace
}  // namespace zoned::physics
