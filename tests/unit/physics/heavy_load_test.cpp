// Bodies a thousand times or more as heavy as the bodies that they lie on.
#include "server/physics/scene/scene.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace zoned::physics {
namespace {

BodyDef light_box_at(const Vec3& position) {
    BodyDef def;
    def.shape = Shape::box(Vec3::Constant(0.5F));
    def.mass = 1.0F;
    def.material.friction = 0.5F;
    def.position = position;
    return def;
}

/// Sixteen boxes of 1 kg side by side, and a ball above them.
struct Bed {
    Scene scene;
    std::vector<BodyId> boxes;
    BodyId ball;

    explicit Bed(float mass)
        : scene([] {
              PhysicsSettings settings;
              settings.sleep_after_s = 0.0F;
              return settings;
          }()) {
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::box(Vec3(20.0F, 1.0F, 20.0F));
        ground.position = Vec3(0.0F, -1.0F, 0.0F);
        ground.material.friction = 0.5F;
        EXPECT_TRUE(scene.add(ground).ok());
        for (int i = 0; i < 16; ++i) {
            boxes.push_back(*scene.add(light_box_at(
                Vec3(static_cast<float>(i % 4) - 1.5F, 0.5F, static_cast<float>(i / 4) - 1.5F))));
        }
        BodyDef def;
        def.shape = Shape::sphere(1.0F);
        def.mass = mass;
        def.material.friction = 0.5F;
        def.position = Vec3(0.5F, 2.0F, 0.5F);  // over the middle of a box
        ball = *scene.add(def);
    }

    [[nodiscard]] float fastest() const {
        float most = 0.0F;
        for (const BodyId box : boxes) {
            most = std::max(most, scene.state(box).velocity.norm());
        }
        return most;
    }
};

/// It stands as on boxes of a thousandth of its mass. The spring of the stiffest substep has w = 2
/// pi x 0.25 / h with h = 1/3840 s on the mass M / 1000. It gives by M g / (M / 1000 w^2) = 0.27
/// mm, and two contacts in line by twice that. The budget of 5 mm covers the residual of one pass a
/// substep.
TEST(HeavyLoad, IsCarriedByWhatWeighsAThousandthOfAThousandth) {
    for (const float mass : {1.0e4F, 1.0e5F, 1.0e6F}) {
        Bed bed(mass);
        run_steps(bed.scene, 120);
        EXPECT_NEAR(bed.scene.state(bed.ball).position.y(), 2.0F, 0.005F) << mass;
        EXPECT_LT(bed.scene.state(bed.ball).velocity.norm(), 0.05F) << mass;
    }
}

/// The impulses that boxes remember come from a heavier body: once the load is gone they must not
/// throw the boxes. The contacts' compression is undone at 3 m/s at most, within one step.
TEST(HeavyLoad, LeavesNothingBehindThatThrowsWhatCarriedIt) {
    Bed bed(1.0e5F);
    run_steps(bed.scene, 120);
    bed.scene.remove(bed.ball);
    float fastest = 0.0F;
    for (int i = 0; i < 120; ++i) {
        bed.scene.step(kFrame);
        fastest = std::max(fastest, bed.fastest());
    }
    EXPECT_LT(fastest, 3.0F);
    for (const BodyId box : bed.boxes) {
        EXPECT_NEAR(bed.scene.state(box).position.y(), 0.5F, 0.005F);
    }
    EXPECT_LT(bed.fastest(), 0.05F);
}

/// Where nothing is substep_limited masses are not changed: a light ball that bounces off a heavy
/// box gives it twice its momentum, less the box's own motion.
TEST(HeavyLoad, MovesByTheMomentumOfWhatIsLightWhereNothingIsStrained) {
    Scene scene(weightless());
    BodyDef heavy = light_box_at(Vec3::Zero());
    heavy.mass = 1.0e5F;
    heavy.material.restitution = 1.0F;
    BodyDef light;
    light.shape = Shape::sphere(0.1F);
    light.mass = 1.0F;
    light.material.restitution = 1.0F;
    light.position = Vec3(-1.0F, 0.0F, 0.0F);
    light.velocity = Vec3(10.0F, 0.0F, 0.0F);
    const BodyId hit = *scene.add(heavy);
    const BodyId ball = *scene.add(light);
    run_steps(scene, 30);
    const double after = static_cast<double>(scene.state(ball).velocity.x());
    const double gained = 1.0e5 * static_cast<double>(scene.state(hit).velocity.x());
    EXPECT_NEAR(after, -10.0 * (1.0e5 - 1.0) / (1.0e5 + 1.0), 1.0e-4);
    EXPECT_NEAR(gained, 10.0 - after, 64.0 * 0x1p-24 * 20.0);
}

}  // namespace
}  // namespace zoned::physics
