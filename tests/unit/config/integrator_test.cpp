// The section physics: the methods that move free bodies and particles, as the config says.
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

using physics::IntegratorKind;

TEST(PhysicsIntegrator, IsTheEnginesOwnDefaultWithoutASection) {
    const Outcome out = parse(kValid);
    ASSERT_TRUE(out.ok);
    EXPECT_EQ(out.settings.physics.body_integrator, physics::PhysicsSettings().body_integrator);
    EXPECT_EQ(out.settings.physics.particle_integrator, IntegratorKind::kDefault);
}

TEST(PhysicsIntegrator, ReachesTheEngineForBodiesAndParticlesApart) {
    const Outcome out = parse(
        kValid + "physics { body_integrator: RK4 particle_integrator: SEMI_IMPLICIT_EULER }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.physics.body_integrator, IntegratorKind::kRk4);
    EXPECT_EQ(out.settings.physics.particle_integrator, IntegratorKind::kSemiImplicitEuler);
}

TEST(PhysicsIntegrator, IsSetOnTheCommandLine) {
    const Outcome out = parse(kValid, {"physics.body_integrator=IMPLICIT_EULER"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.physics.body_integrator, IntegratorKind::kImplicitEuler);
}

TEST(PhysicsIntegrator, RefusesVerletAndNamesWhatToTake) {
    expect_single(kValid + "physics { body_integrator: VERLET }\n",
                  "body_integrator: VERLET",
                  "velocity_verlet");
    expect_single(kValid + "physics { particle_integrator: VERLET }\n",
                  "particle_integrator: VERLET",
                  "impulses and contacts");
}

}  // namespace
}  // namespace zoned::config::test
