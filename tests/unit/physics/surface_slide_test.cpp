// Bodies on surfaces of many triangles: inner edges must not be felt.
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

float flat(float, float) {
    return 0.0F;
}

PhysicsSettings awake() {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    return s;
}

struct Slider {
    const char* name;
    Shape shape;
    float height;  // of the centre when it rests
    Quat orientation = Quat::Identity();
};

std::vector<Slider> sliders() {
    const Quat lying(Eigen::AngleAxisf(1.57079633F, Vec3::UnitZ()));
    const Quat askew(Eigen::AngleAxisf(0.5F, Vec3::UnitY()));
    return {{"sphere", Shape::sphere(0.5F), 0.5F},
            {"box", Shape::box(Vec3(0.5F, 0.25F, 0.4F)), 0.25F},
            {"turned box", Shape::box(Vec3(0.5F, 0.25F, 0.4F)), 0.25F, askew},
            {"hull", hull_shape(box_corners(Vec3(0.5F, 0.25F, 0.4F))), 0.25F, askew},
            {"lying capsule", Shape::capsule(0.3F, 0.5F), 0.3F, askew * lying},
            {"standing capsule", Shape::capsule(0.3F, 0.5F), 0.8F},
            {"small box", Shape::box(Vec3::Constant(0.1F)), 0.1F, askew}};
}

/// Without friction a body keeps its velocity over a flat floor, whatever the triangles.
void slides_on(const Shape& floor, float tolerance) {
    for (const Slider& slider : sliders()) {
        for (const float speed : {1.0F, 7.0F, 40.0F}) {
            Scene scene(awake());
            add_static(scene, floor, {0.0F, 0.0F});
            BodyDef def;
            def.shape = slider.shape;
            def.material = {0.0F, 0.0F};
            def.position = Vec3(-8.0F, slider.height, -5.03F);
            def.orientation = slider.orientation;
            const Vec3 velocity(speed * 0.8F, 0, speed * 0.6F);
            def.velocity = velocity;
            const BodyId id = *scene.add(def);
            // A capsule on its end stands in an unstable balance: it has 1.5 s.
            const bool balance = slider.height > 0.7F;
            const int steps = static_cast<int>(16.0F / (0.8F * speed) / kFrame);
            for (int i = 0; i < std::min(steps, balance ? 90 : 240); ++i) {
                scene.step(kFrame);
                const BodyState state = scene.state(id);
                ASSERT_LT((state.velocity - velocity).norm(), tolerance * (1.0F + speed))
                    << slider.name << " at " << speed << " m/s, step " << i << ", x "
                    << state.position.x();
                ASSERT_NEAR(state.position.y(), slider.height, 0.01F) << slider.name;
                ASSERT_LT(state.angular_velocity.norm(), 0.05F) << slider.name << " step " << i;
            }
        }
    }
}

TEST(Slide, OverAFloorOfTrianglesIsNotDisturbed) {
    // The remaining change is the settling onto the contact's spring and rounding: a thousandth of
    // the speed. A bump at an inner edge stops a box or throws it up.
    slides_on(mesh_shape(grid_mesh(40, 0.5F, flat)), 2e-3F);
}

TEST(Slide, OverAFlatHeightfieldIsNotDisturbed) {
    slides_on(field_shape(41, 0.5F, flat), 2e-3F);
}

TEST(Roll, OverAMeshGoesAsOnAPlane) {
    // Rolling from rest down a slope of triangles: a = g sin(alpha) 5/7.
    const float alpha = 0.2F;
    const Quat tilt(Eigen::AngleAxisf(alpha, Vec3::UnitZ()));
    for (const bool field : {false, true}) {
        Scene scene(awake());
        BodyDef floor;
        floor.kind = BodyKind::kStatic;
        floor.shape = field ? field_shape(61, 0.3F, flat) : mesh_shape(grid_mesh(60, 0.3F, flat));
        floor.orientation = tilt;
        floor.material.friction = 0.9F;
        ASSERT_TRUE(scene.add(floor).ok());
        BodyDef ball;
        ball.shape = Shape::sphere(0.5F);
        ball.material.friction = 0.9F;
        ball.position = tilt * Vec3(6.0F, 0.5F, 0.07F);
        const BodyId id = *scene.add(ball);
        for (int i = 0; i < 120; ++i) {
            scene.step(kFrame);
        }
        const float a = 9.81F * std::sin(alpha) / 1.4F;
        const Vec3 moved = tilt.conjugate() * (scene.state(id).position - ball.position);
        EXPECT_NEAR(-moved.x(), a * 4.0F / 2.0F, 0.005F * a * 2.0F);
        EXPECT_NEAR(moved.z(), 0.0F, 2e-3F);
        EXPECT_NEAR(moved.y(), 0.0F, 5e-3F);
    }
}

TEST(Slide, OverASmoothHillFollowsItWithoutLosingEnergy) {
    // A cosine hill of facets. Without friction and bounce, a body loses energy only at the facets'
    // bends: at each convex bend nothing, at each concave one of angle b the share b^2. With 0.5 m
    // cells and a curvature of at most 0.25 / m the bends are up to 0.125 rad.
    const auto hill = [](float x, float) {
        return 1.0F * std::cos(0.5F * x);
    };
    for (const bool field : {false, true}) {
        for (const Slider& slider : {sliders()[0], sliders()[1], sliders()[4]}) {
            Scene scene(awake());
            add_static(
                scene,
                field ? field_shape(81, 0.25F, hill) : mesh_shape(grid_mesh(80, 0.25F, hill)),
                {0.0F, 0.0F});
            BodyDef def;
            def.shape = slider.shape;
            def.material = {0.0F, 0.0F};
            def.position = Vec3(-6.2F, -1.0F + slider.height + 0.02F, 0.04F);
            def.orientation = slider.orientation;
            def.velocity = Vec3(9.0F, 0, 0);
            const BodyId id = *scene.add(def);
            const float start = 0.5F * 81.0F;
            float least = start;
            for (int i = 0; i < 90; ++i) {
                scene.step(kFrame);
                const BodyState s = scene.state(id);
                const float energy =
                    0.5F * s.velocity.squaredNorm() + 9.81F * (s.position.y() - def.position.y());
                least = std::min(least, energy);
                ASSERT_LT(energy, start * 1.03F) << slider.name << " step " << i;
                ASSERT_GT(s.position.y(), hill(s.position.x(), 0) + 0.2F) << slider.name;
            }
            EXPECT_GT(scene.state(id).position.x(), 2.0F) << slider.name;
            EXPECT_GT(least, 0.85F * start) << slider.name;
        }
    }
}

TEST(Stack, OfFiveStandsOnAMesh) {
    for (const bool field : {false, true}) {
        Scene scene(awake());
        add_static(scene,
                   field ? field_shape(41, 0.3F, flat) : mesh_shape(grid_mesh(40, 0.3F, flat)));
        std::vector<BodyId> boxes;
        for (int i = 0; i < 5; ++i) {
            BodyDef def;
            def.shape = Shape::box(Vec3::Constant(0.5F));
            def.position = Vec3(0.11F, 0.5F + static_cast<float>(i), 0.07F);
            boxes.push_back(*scene.add(def));
        }
        for (int i = 0; i < 600; ++i) {
            const StepStats stats = scene.step(kFrame);
            // Each box touches the ground with four points, however many triangles there are.
            ASSERT_LE(stats.contacts, 20U);
        }
        for (int i = 0; i < 5; ++i) {
            const Vec3 x = scene.state(boxes[static_cast<std::size_t>(i)]).position;
            EXPECT_LT((x - Vec3(0.11F, 0.5F + static_cast<float>(i), 0.07F)).norm(), 0.01F) << i;
        }
    }
}

TEST(Surface, HoldsABallWhereverItLands) {
    // Dropped all over a rough surface, with edges and corners of every kind: none falls through.
    core::Rng rng(61);
    std::vector<float> heights(31 * 31);
    for (float& h : heights) {
        h = rng.range(0.0F, 0.8F);
    }
    const auto rough = [&](float x, float z) {
        const auto i = static_cast<std::size_t>(std::lround(x + 15.0F));
        const auto k = static_cast<std::size_t>(std::lround(z + 15.0F));
        return heights[k * 31 + i];
    };
    for (const bool field : {false, true}) {
        Scene scene(awake());
        add_static(scene,
                   field ? field_shape(31, 1.0F, rough) : mesh_shape(grid_mesh(30, 1.0F, rough)));
        std::vector<BodyId> bodies;
        for (int i = 0; i < 200; ++i) {
            BodyDef def;
            const std::vector<Slider> shapes = sliders();
            def.shape = shapes[static_cast<std::size_t>(i) % shapes.size()].shape;
            const float x = static_cast<float>(i % 14) * 1.9F - 12.5F;
            const float z = static_cast<float>(i / 14) * 1.8F - 12.5F;
            def.position = Vec3(x, rng.range(2.0F, 6.0F), z);
            def.orientation = random_rotation(rng);
            bodies.push_back(*scene.add(def));
        }
        for (int i = 0; i < 240; ++i) {
            scene.step(kFrame);
        }
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            const BodyState s = scene.state(bodies[i]);
            if (std::max(std::abs(s.position.x()), std::abs(s.position.z())) < 14.5F) {
                EXPECT_GT(s.position.y(), 0.0F) << i << " field " << field;
            }
            EXPECT_TRUE(s.position.allFinite());
        }
    }
}

TEST(Surface, StopsWhatIsFast) {
    for (const bool field : {false, true}) {
        for (const float speed : {50.0F, 300.0F, 1000.0F}) {
            for (const Slider& slider : sliders()) {
                Scene scene(awake());
                add_static(
                    scene,
                    field ? field_shape(41, 0.5F, flat) : mesh_shape(grid_mesh(40, 0.5F, flat)));
                BodyDef def;
                def.shape = slider.shape;
                def.position = Vec3(0.3F, 6.0F, 0.1F);
                def.orientation = slider.orientation;
                def.velocity = Vec3(0.1F * speed, -speed, 0);
                const BodyId id = *scene.add(def);
                for (int i = 0; i < 30; ++i) {
                    scene.step(kFrame);
                    if (std::abs(scene.state(id).position.x()) < 9.0F) {
                        ASSERT_GT(scene.state(id).position.y(), 0.0F)
                            << slider.name << " " << speed;
                    }
                }
            }
        }
    }
}

TEST(Heightfield, LiftsWhatIsBuriedInIt) {
    for (const Slider& slider : sliders()) {
        Scene scene(awake());
        add_static(scene, field_shape(41, 0.5F, flat));
        BodyDef def;
        def.shape = slider.shape;
        def.position = Vec3(0.3F, -0.2F, 0.1F);
        const BodyId id = *scene.add(def);
        for (int i = 0; i < 300; ++i) {
            scene.step(kFrame);
        }
        EXPECT_GT(scene.state(id).position.y(), 0.05F) << slider.name;
    }
}

}  // namespace
}  // namespace zoned::physics
