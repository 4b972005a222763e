// Nets of joints too wide for a direct solve: conjugate gradients hold them.
#include "tests/unit/physics/joint_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::physics {
namespace {

constexpr std::size_t kNetSide = 20;
constexpr float kNetLink = 0.2F;  ///< m

/// A level net of balls on ball joints; `hung`: one edge is joined to the world.
void add_wide_net(JointScene& scene, bool hung) {
    for (std::size_t i = 0; i < kNetSide * kNetSide; ++i) {
        const std::size_t x = i % kNetSide;
        const std::size_t z = i / kNetSide;
        BodyDef def;
        def.shape = Shape::sphere(0.06F);
        def.filter.mask = 0;
        def.position = kNetLink * Vec3(static_cast<float>(x), 0.0F, static_cast<float>(z));
        scene.add(def);
        const auto tie = [&](std::size_t back, const Vec3& half) {
            const BodyId other = back > 0 ? scene.bodies[i - back].id : BodyId();
            scene.join(joint_of(JointKind::kBall, other, scene.bodies[i].id, def.position - half));
        };
        if (x > 0) {
            tie(1, Vec3(0.5F * kNetLink, 0.0F, 0.0F));
        }
        if (z > 0) {
            tie(kNetSide, Vec3(0.0F, 0.0F, 0.5F * kNetLink));
        } else if (hung) {
            tie(0, Vec3(0.0F, 0.0F, 0.5F * kNetLink));
        }
    }
}

/// The largest distance of two neighbours' common point as either of them has it, m.
float widest_net_gap(const JointScene& scene) {
    float most = 0.0F;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const BodyState b = scene.scene.state(scene.bodies[i].id);
        const auto look = [&](std::size_t back, const Vec3& half) {
            const BodyState a = scene.scene.state(scene.bodies[i - back].id);
            const Vec3 gap =
                (b.position - b.orientation * half) - a.position - a.orientation * half;
            most = std::max(most, gap.norm());
        };
        if (i % kNetSide > 0) {
            look(1, Vec3(0.5F * kNetLink, 0.0F, 0.0F));
        }
        if (i >= kNetSide) {
            look(kNetSide, Vec3(0.0F, 0.0F, 0.5F * kNetLink));
        }
    }
    return most;
}

/// Each substep may leave joints 0.3 mm wider, and they close within 50 ms: at 240 substeps a
/// second they are 0.3 mm x 240 / s x 50 ms open, where that happens in each of them.
TEST(WideNet, SwingsDownClosed) {
    JointScene scene(Vec3(0.0F, -kGravity, 0.0F));
    add_wide_net(scene, true);
    for (int i = 0; i < 120; ++i) {
        scene.scene.step(kFrame);
        ASSERT_LE(widest_net_gap(scene), 0.0036F) << "step " << i;
    }
}

/// All impulses of joints are between two bodies. Some 10^4 of them change each body, rounded to
/// 6e-8: 6e-6 of its motion in a random walk.
TEST(WideNet, KeepsItsMomentum) {
    JointScene scene;
    add_wide_net(scene, false);
    scene.scene.set_velocity(
        scene.bodies[3 * kNetSide + 5].id, Vec3(2.0F, 8.0F, 1.0F), Vec3(5.0F, 3.0F, 1.0F));
    const JointScene::Sums before = scene.sums();
    for (int i = 0; i < 60; ++i) {
        scene.scene.step(kFrame);
        const JointScene::Sums now = scene.sums();
        ASSERT_TRUE(now.finite);
        ASSERT_LE((now.linear - before.linear).norm(), 1.0e-4 * before.size) << "step " << i;
        ASSERT_LE((now.angular - before.angular).norm(), 1.0e-4 * before.size) << "step " << i;
        ASSERT_LE(now.energy, 1.01 * before.energy) << "step " << i;
    }
}

}  // namespace
}  // namespace zoned::physics
