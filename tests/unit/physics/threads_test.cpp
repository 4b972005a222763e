// build: computes
#include "server/compute/worker_pool.h"
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/compound.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::physics {
namespace {

Shape shape_of(int i, core::Rng& rng) {
    switch (i % 5) {
        case 0:
            return Shape::sphere(rng.range(0.2F, 0.5F));
        case 1:
            return Shape::capsule(0.25F, 0.3F);
        case 2:
            return Shape::hull(build_hull(random_points(rng, 20, 0.5F))->hull);
        case 3: {
            std::vector<CompoundPart> parts(2);
            parts[0].shape = Shape::box({0.5F, 0.1F, 0.1F});
            parts[1].shape = Shape::sphere(0.25F);
            parts[1].frame.position = Vec3(0.5F, 0, 0);
            return Shape::compound(build_compound(parts)->compound);
        }
        default:
            return Shape::box(Vec3(0.3F, 0.4F, 0.5F));
    }
}

/// Everything that a step knows: a crowd of all shapes falls into a trough of triangles, past a
/// sensor and a plate that moves, some of them hinged together, some bouncing.
class Crowd {
  public:
    Crowd() : scene_(PhysicsSettings()) {
        core::Rng rng(7);
        add_static(scene_, mesh_shape(grid_mesh(16, 1.5F, [](float x, float z) {
                       return 0.04F * (x * x + z * z);
                   })));
        BodyDef plate;
        plate.kind = BodyKind::kKinematic;
        plate.shape = Shape::box({2, 0.2F, 2});
        plate.position = Vec3(0, 1.5F, 0);
        plate.velocity = Vec3(0.5F, 0, 0);
        plate.angular_velocity = Vec3(0, 1, 0);
        add(plate);
        BodyDef gate;
        gate.kind = BodyKind::kStatic;
        gate.sensor = true;
        gate.shape = Shape::box({3, 0.5F, 3});
        gate.position = Vec3(0, 3, 0);
        gate.user = 9999;
        add(gate);
        for (int i = 0; i < 700; ++i) {
            BodyDef def;
            def.shape = shape_of(i, rng);
            def.position =
                Vec3(rng.range(-4, 4), 1.0F + 0.02F * static_cast<float>(i), rng.range(-4, 4));
            def.material.restitution = i % 7 == 0 ? 0.6F : 0.0F;
            def.user = static_cast<std::uint32_t>(i + 1);
            ids_.push_back(add(def));
        }
        for (std::size_t i = 0; i + 1 < ids_.size(); i += 20) {
            JointDef joint;
            joint.kind = JointKind::kHinge;
            joint.a = ids_[i];
            joint.b = ids_[i + 1];
            joint.anchor = scene_.state(ids_[i]).position;
            EXPECT_TRUE(scene_.add_joint(joint).ok());
        }
    }

    Scene& scene() { return scene_; }

    /// The state, and the events of the step.
    std::uint64_t step() {
        scene_.step(kFrame);
        core::StateHash hash;
        scene_.hash(hash);
        for (const ContactEvent& event : scene_.contact_events()) {
            hash.add(event.user_a);
            hash.add(event.user_b);
            hash.add(event.impulse);
        }
        for (const SensorEvent& event : scene_.sensor_events()) {
            hash.add(event.user_a ^ event.user_b);
        }
        return hash.value();
    }

  private:
    BodyId add(const BodyDef& def) {
        auto id = scene_.add(def);
        EXPECT_TRUE(id.ok()) << id.error();
        return *id;
    }

    Scene scene_;
    std::vector<BodyId> ids_;
};

constexpr int kSteps = 60;

std::vector<std::uint64_t> history(unsigned threads) {
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    Crowd crowd;
    crowd.scene().work_with(&team);
    std::vector<std::uint64_t> hashes;
    for (int t = 0; t < kSteps; ++t) {
        hashes.push_back(crowd.step());
    }
    return hashes;
}

TEST(Threads, MakeNoDifferenceToAnyStepOfAScene) {
    Crowd alone;
    std::vector<std::uint64_t> expected;
    for (int t = 0; t < kSteps; ++t) {
        expected.push_back(alone.step());
    }
    for (const unsigned threads : {1U, 2U, 4U}) {
        const std::vector<std::uint64_t> got = history(threads);
        for (std::size_t t = 0; t < expected.size(); ++t) {
            ASSERT_EQ(got[t], expected[t]) << threads << " threads, step " << t;
        }
    }
}

TEST(Threads, TakeNoMemoryWhileAHeapLies) {
    compute::WorkerPool pool(3);
    compute::Team team;
    team.join_pool(pool);
    PhysicsSettings settings;
    settings.sleep_after_s = 0.0F;
    Scene scene(settings);
    scene.work_with(&team);
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::box({20, 1, 20});
    floor.position = Vec3(0, -1, 0);
    ASSERT_TRUE(scene.add(floor).ok());
    for (int i = 0; i < 800; ++i) {
        BodyDef def;
        def.shape = Shape::box(Vec3::Constant(0.3F));
        def.position = Vec3(0.8F * static_cast<float>(i % 10),
                            0.35F + 0.7F * static_cast<float>(i / 100),
                            0.8F * static_cast<float>(i / 10 % 10));
        ASSERT_TRUE(scene.add(def).ok());
    }
    for (int t = 0; t < 120; ++t) {
        const std::uint64_t before = allocation_count();
        scene.step(kFrame);
        if (t >= 60) {
            EXPECT_EQ(allocation_count(), before) << "step " << t;
        }
    }
}

}  // namespace
}  // namespace zoned::physics
