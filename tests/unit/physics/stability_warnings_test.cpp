// StabilityWarnings: bodies that do not fit the time step are found when they are added, and
// counted when the fault occurs.
#include "server/physics/scene/stability_warnings.h"

#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

namespace zoned::physics {
namespace {

bool says(const std::vector<std::string>& all, const char* text) {
    return all.size() == 1 && all[0].find(text) != std::string::npos;
}

TEST(StabilityWarnings, SaysNothingAboutOrdinaryThings) {
    EXPECT_TRUE(stability_warnings_of(BodyDef(), PhysicsSettings(), kFrame).empty());
    EXPECT_TRUE(stability_warnings_of(JointDef(), 1.0F, 10.0F, PhysicsSettings(), kFrame).empty());
    EXPECT_TRUE(stability_warnings_of(PhysicsSettings(), kFrame).empty());
    EXPECT_TRUE(stability_warnings_of_load(1.0F, 100.0F, PhysicsSettings(), kFrame).empty());
}

TEST(StabilityWarnings, NamesBodiesTooFarOutTooThinTooFastAndTooSmallForTheStep) {
    BodyDef def;
    def.position.z() = -5000.0F;
    EXPECT_TRUE(says(stability_warnings_of(def, PhysicsSettings(), kFrame), "5000 m out"));
    def = BodyDef();
    def.shape = Shape::box({0.5F, 0.5F, 0.009F});
    EXPECT_TRUE(says(stability_warnings_of(def, PhysicsSettings(), kFrame), "0.018 m thick"));
    def = BodyDef();
    def.shape = Shape::box({0.5F, 0.5F, 0.1F});
    def.angular_velocity.x() = 200.0F;
    EXPECT_TRUE(says(stability_warnings_of(def, PhysicsSettings(), kFrame), "3.33333 rad"));
    def = BodyDef();
    EXPECT_TRUE(says(stability_warnings_of(def, PhysicsSettings(), 0.25F), "0.613125 m farther"));
}

TEST(StabilityWarnings, NamesSpringsTooStiffAndMassesTooDifferent) {
    JointDef def;
    def.kind = JointKind::kSpring;
    def.spring_hz = 400.0F;
    // 64 substeps of 1/60 s: half a radian each is 305.6 Hz.
    EXPECT_TRUE(
        says(stability_warnings_of(def, 1.0F, 1.0F, PhysicsSettings(), kFrame), "305.577 Hz"));
    PhysicsSettings few;
    few.substeps = 4;
    def.spring_hz = 20.0F;
    EXPECT_FALSE(stability_warnings_of(def, 1.0F, 1.0F, few, kFrame).empty());
    def.spring_hz = 1.0F;
    EXPECT_FALSE(stability_warnings_of(def, 1.0F, 1.0e6F, PhysicsSettings(), kFrame).empty());
    EXPECT_TRUE(says(stability_warnings_of_load(1.0F, 1.0e6F, PhysicsSettings(), kFrame),
                     "the lighter for 1000 kg"));
    EXPECT_TRUE(says(stability_warnings_of_load(1.0F, 1.0e6F, few, kFrame), "gives way by"));
    EXPECT_FALSE(stability_warnings_of(few, 0.5F).empty());
}

BodyDef box(float mass, float y) {
    BodyDef def;
    def.shape = Shape::box(Vec3::Constant(0.5F));
    def.mass = mass;
    def.position.y() = y;
    return def;
}

/// A plate of that mass on n x n boxes of 1 kg, a tenth of a metre apart.
std::uint32_t most_substep_limited(int n, float heavy) {
    Scene scene{PhysicsSettings()};
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::plane();
    EXPECT_TRUE(scene.add(floor).ok());
    const float side = 1.1F * static_cast<float>(n);
    BodyDef plate = box(heavy, 1.1F);
    plate.shape = Shape::box(Vec3(0.5F * side, 0.1F, 0.5F * side));
    EXPECT_TRUE(scene.add(plate).ok());
    for (int i = 0; i < n * n; ++i) {
        BodyDef foot = box(1.0F, 0.5F);
        foot.position.x() = 1.1F * static_cast<float>(i % n) + 0.55F - 0.5F * side;
        foot.position.z() = 1.1F * static_cast<float>(i / n) + 0.55F - 0.5F * side;
        EXPECT_TRUE(scene.add(foot).ok());
    }
    std::uint32_t most = 0;
    for (int i = 0; i < 30; ++i) {
        most = std::max(most, scene.step(kFrame).substep_limited);
    }
    return most;
}

TEST(StabilityWarnings, IsCountedWhereALoadAsksForMoreThanTheMostSubsteps) {
    EXPECT_EQ(most_substep_limited(6, 10.0F), 0U);
    EXPECT_EQ(most_substep_limited(6, 1.0e6F), 1U);
    // Few enough contacts to be solved exactly.
    EXPECT_EQ(most_substep_limited(2, 1.0e6F), 0U);
}

TEST(StabilityWarnings, IsCountedOfBodiesThatMoveTooFarOut) {
    Scene scene{PhysicsSettings()};
    ASSERT_TRUE(scene.add(box(1.0F, 10.0F)).ok());
    EXPECT_EQ(scene.step(kFrame).far_bodies, 0U);
    BodyDef out = box(1.0F, 10.0F);
    out.position.x() = 1.1F * farthest_for(PhysicsSettings().error_budget_m);
    ASSERT_TRUE(scene.add(out).ok());
    EXPECT_EQ(scene.step(kFrame).far_bodies, 1U);
}

}  // namespace
}  // namespace zoned::physics
