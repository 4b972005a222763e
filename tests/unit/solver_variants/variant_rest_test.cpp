// All methods through Scene::step: stacks at rest stay, and unsolvable systems are stopped.
#include "tests/unit/solver_variants/variant_scene.h"

#include <cmath>

namespace zoned::physics {
namespace {

VariantScene stack(const PhysicsSettings& settings, int boxes, float top_mass) {
    VariantScene s(settings);
    s.ground();
    for (int i = 0; i < boxes; ++i) {
        s.box(Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F), i + 1 == boxes ? top_mass : 1.0F);
    }
    return s;
}

/// How far the top box is from where it began, m.
float drift(const VariantScene& s) {
    const Vec3 at = s.scene.state(s.bodies.back()).position;
    return (at - Vec3(0.0F, static_cast<float>(s.bodies.size()) - 0.5F, 0.0F)).norm();
}

class EachMethod : public testing::TestWithParam<SolverVariant> {};

INSTANTIATE_TEST_SUITE_P(SolverVariants,
                         EachMethod,
                         testing::ValuesIn(all_methods()),
                         [](const auto& method) {
                             std::string name = name_of(method.param);
                             std::erase_if(name, [](char c) { return c == ' ' || c == '-'; });
                             return name;
                         });

// A method that lets the stack fall is off by half a box at least; one that holds it may rock by
// its residual. A tenth of a box parts the two.
TEST_P(EachMethod, HoldsAStackOfFiveBoxesForFiveSeconds) {
    VariantScene s = stack(settings_of(GetParam(), 30), 5, 1.0F);
    s.run(5.0F);
    EXPECT_LT(drift(s), 0.1F);
}

// Of the load that rests on the ground after a second, m g h in each step, no method may miss more
// than rocking moves about: a tenth.
TEST_P(EachMethod, CarriesTheWeightOfABox) {
    PhysicsSettings settings = settings_of(GetParam(), 50);
    settings.event_impulse_ns = 0.0F;
    VariantScene s(settings);
    s.ground();
    s.box(Vec3(0.0F, 0.5F, 0.0F), 3.0F);
    s.run(1.0F);
    float sum = 0.0F;
    for (int i = 0; i < 60; ++i) {
        s.scene.step(kFrame);
        for (const ContactEvent& event : s.scene.contact_events()) {
            sum += event.impulse;
        }
    }
    const float weight = 3.0F * kGravity;
    EXPECT_NEAR(sum, weight, 0.1F * weight);
}

TEST_P(EachMethod, StopsABodyThatIsNoLongerFiniteAndGoesOn) {
    VariantScene s = stack(settings_of(GetParam()), 2, 1.0F);
    s.run(0.1F);
    s.scene.apply_force(s.bodies[1], Vec3::Constant(1.0e15F));
    StepStats stats = s.scene.step(kFrame);
    std::uint32_t stopped = stats.quarantined;
    for (int i = 0; i < 30; ++i) {
        stopped += s.scene.step(kFrame).quarantined;
    }
    EXPECT_GE(stopped, 1U);
    for (const BodyId body : s.bodies) {
        EXPECT_TRUE(s.scene.state(body).position.allFinite());
        EXPECT_TRUE(s.scene.state(body).velocity.allFinite());
    }
}

/// Boxes on each other with joints between them: a chain of three that hangs from the world.
TEST_P(EachMethod, HoldsAChainOnBallJoints) {
    VariantScene s(settings_of(GetParam(), 50));
    BodyDef def;
    def.shape = Shape::box(Vec3(0.1F, 0.5F, 0.1F));
    BodyId above;
    for (int i = 0; i < 3; ++i) {
        def.position = Vec3(0.0F, -0.5F - static_cast<float>(i), 0.0F);
        const BodyId link = s.add(def);
        JointDef joint;
        joint.a = above;
        joint.b = link;
        joint.anchor = Vec3(0.0F, -static_cast<float>(i), 0.0F);
        ASSERT_TRUE(s.scene.add_joint(joint).ok());
        above = link;
    }
    s.scene.set_velocity(above, Vec3(1.0F, 0.0F, 0.0F), Vec3::Zero());
    s.run(3.0F);
    // The links are a metre long each: the end stays within three metres of the anchor, plus the
    // rows' residual for the load of three.
    const Vec3 end = s.scene.state(s.bodies[2]).position;
    EXPECT_LT(end.norm(), 2.5F * 1.05F);
    EXPECT_GT(end.norm(), 2.0F);
}

// A step goes straight on and lengthens a pendulum by (v h)^2 / 2 r, at most g h^2 where v^2 = 2 g
// r. Baumgarte's method and the split one undo a fifth of the error in each step, so that 5 g h^2 =
// 14 mm are left. The soft spring of 15 Hz needs 2 zeta / w = 6.4 steps, and gives by 3 g / w^2 = 3
// mm under the load: 20 mm. Left alone, the error grows to decimetres within 20 s.
TEST(ImpulseMethod, KeepsTheLengthOfAPendulumWithEachStabilisation) {
    for (const Stabilisation stabilisation :
         {Stabilisation::kBaumgarte, Stabilisation::kSoft, Stabilisation::kSplit}) {
        PhysicsSettings settings = settings_of(SolverVariant::kImpulse);
        settings.methods.stabilisation = stabilisation;
        VariantScene s(settings);
        const BodyId bob = s.sphere(Vec3(1.0F, 0.0F, 0.0F), Vec3::Zero(), 0.0F);
        JointDef joint;
        joint.b = bob;
        ASSERT_TRUE(s.scene.add_joint(joint).ok());
        for (int i = 0; i < 1200; ++i) {
            s.scene.step(kFrame);
            const float length = s.scene.state(bob).position.norm();
            ASSERT_NEAR(length, 1.0F, 0.03F) << static_cast<int>(stabilisation) << " in step " << i;
        }
    }
}

// A solver that carries the load of a column from row to row is limited by the ratio of the masses
// times their number. The exact solver is limited only by rounding. At 1e5 its residual of 1e-10 d
// |lambda| is some 1e-5 m/s, which an overlap of that size per step balances.
TEST(DirectMethod, HoldsAColumnWhoseTopIsAHundredThousandTimesHeavier) {
    VariantScene s = stack(settings_of(SolverVariant::kDirect), 5, 1.0e5F);
    std::uint32_t unsolved = 0;
    for (int i = 0; i < 600; ++i) {
        const VariantStats stats = s.scene.step(kFrame).method;
        unsolved += stats.unsolved + stats.too_large;
        EXPECT_EQ(stats.direct, 1U);
    }
    EXPECT_EQ(unsolved, 0U);
    EXPECT_LT(drift(s), 0.001F);
}

// With one normal row per contact five boxes are 20 rows instead of 60. A box stays upright because
// its centre of pressure moves to the side to which it leans.
TEST(DirectMethod, HoldsThatColumnWithDividedManifoldsToo) {
    PhysicsSettings settings = settings_of(SolverVariant::kDirect);
    settings.methods.manifold = ManifoldMode::kDivided;
    VariantScene s = stack(settings, 5, 1.0e5F);
    for (int i = 0; i < 600; ++i) {
        const VariantStats stats = s.scene.step(kFrame).method;
        EXPECT_EQ(stats.direct, 1U);
        EXPECT_EQ(stats.rows, 20U);
    }
    EXPECT_LT(drift(s), 0.001F);
}

// Boxes that lie a hundredth of their edge to one side and to the other rock, and fall where the
// divided load rights them harder than a step can follow. They lean a little, as the middle of the
// load has to lie under the boxes above: a tenth of a box parts the two, as above.
TEST(Manifold, DividedRightsTheBoxesOfAStackNoHarderThanAStepCanFollow) {
    constexpr int kBoxes = 5;
    for (const SolverVariant method : row_methods()) {
        PhysicsSettings settings = settings_of(method, 60);
        settings.methods.manifold = ManifoldMode::kDivided;
        VariantScene s(settings);
        s.ground();
        for (int i = 0; i < kBoxes; ++i) {
            const float x = i % 2 == 0 ? 0.01F : -0.01F;
            s.box(Vec3(x, 0.5F + static_cast<float>(i), x), 1.0F);
        }
        s.run(5.0F);
        const Vec3 at = s.scene.state(s.bodies.back()).position;
        EXPECT_LT((at - Vec3(0.01F, kBoxes - 0.5F, 0.01F)).norm(), 0.1F) << name_of(method);
    }
}

TEST(DirectMethod, CountsIslandsThatAreTooLargeAndLeavesThemToGaussSeidel) {
    PhysicsSettings settings = settings_of(SolverVariant::kDirect, 30);
    settings.methods.direct_rows = 20;
    VariantScene s(settings);
    s.ground();
    for (int i = 0; i < 3; ++i) {
        s.box(Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));  // 36 rows
    }
    s.box(Vec3(5.0F, 0.5F, 0.0F));  // 12 rows
    const VariantStats stats = s.scene.step(kFrame).method;
    EXPECT_EQ(stats.direct, 1U);
    EXPECT_EQ(stats.too_large, 1U);
    EXPECT_EQ(stats.unsolved, 0U);
    EXPECT_EQ(stats.rows, 48U);
}

TEST(SoftStep, ReportsNothingOfTheOtherMethods) {
    VariantScene s = stack(settings_of(SolverVariant::kSoftStep), 3, 1.0F);
    const StepStats stats = s.scene.step(kFrame);
    EXPECT_EQ(stats.method.rows, 0U);
    EXPECT_EQ(stats.method.iterations, 0U);
    EXPECT_EQ(s.scene.problem(), nullptr);
}

}  // namespace
}  // namespace zoned::physics
