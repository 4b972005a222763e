// Boxes on the crests of surfaces: they come to rest, and touch the triangles under them.
#include "server/physics/narrowphase/contact_set.h"
#include "server/physics/shapes/convex/hull.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace zoned::physics {
namespace {

/// A hill with its top at (0, 0), flat triangles of 2 m.
float hill(float x, float z) {
    return 6.0F - 0.02F * (x * x + 0.6F * z * z);
}

std::shared_ptr<const Heightfield> hill_field() {
    constexpr std::uint32_t kSamples = 17;
    std::vector<float> heights;
    for (std::uint32_t i = 0; i < kSamples * kSamples; ++i) {
        heights.push_back(hill(2.0F * static_cast<float>(i % kSamples) - 16.0F,
                               2.0F * static_cast<float>(i / kSamples) - 16.0F));
    }
    FieldOptions options;
    options.columns = options.rows = kSamples;
    options.spacing_x = options.spacing_z = 2.0F;
    return *build_heightfield(heights, options);
}

Shape hill_mesh() {
    const MeshInput in = grid_mesh(16, 2.0F, hill);
    return Shape::mesh(build_mesh(in.vertices, in.indices)->mesh);
}

/// Dropped anywhere about the top, with any side ahead, a box sleeps within ten seconds: it was
/// dropped from 0.2 m, and each impact is inelastic.
TEST(Crest, LetsBoxesComeToRest) {
    const Shape surfaces[] = {Shape::heightfield(hill_field()), hill_mesh()};
    for (const Shape& surface : surfaces) {
        for (int i = 0; i < 60; ++i) {
            Scene scene{PhysicsSettings()};
            BodyDef ground;
            ground.kind = BodyKind::kStatic;
            ground.shape = surface;
            ground.material.friction = 0.8F;
            ASSERT_TRUE(scene.add(ground).ok());
            BodyDef box;
            box.shape = Shape::box(Vec3::Constant(0.4F));
            box.mass = 15.0F;
            box.material.friction = 0.8F;
            box.position = Vec3(-1.5F + 0.15F * static_cast<float>(i % 20),
                                6.6F,
                                -1.5F + 0.15F * static_cast<float>(i * 7 % 20));
            box.orientation = Quat(Eigen::AngleAxisf(0.1F * static_cast<float>(i), Vec3::UnitY()));
            const BodyId id = *scene.add(box);
            for (int t = 0; t < 300 && !scene.state(id).asleep; ++t) {
                scene.step(kTick);
            }
            EXPECT_TRUE(scene.state(id).asleep) << i;
        }
    }
}

/// No point is deeper than the box can be. It stands on the top, tipped by 3 degrees. Its lowest
/// corner is on the smooth hill, and so on or above the triangles, which are chords of it. Under a
/// face, 1.13 m from corner to corner, the hill rises over the chord by 0.02 (1.13 / 2)^2 = 6.4 mm
/// at most. Edges of triangles that the box does not touch give no contact.
TEST(Crest, IsTouchedOnlyWhereItIs) {
    const Shape surface = Shape::heightfield(hill_field());
    const Shape box = Shape::box(Vec3::Constant(0.4F));
    const Mat3 still = Mat3::Identity();
    ContactSet contacts;
    for (int i = 0; i < 400; ++i) {
        const float yaw = 0.0157F * static_cast<float>(i);
        const Vec3 axis(std::cos(2.0F * yaw), 0.0F, std::sin(2.0F * yaw));
        const Mat3 turned = (Eigen::AngleAxisf(0.05F, axis) * Eigen::AngleAxisf(yaw, Vec3::UnitY()))
                                .toRotationMatrix();
        Vec3 centre(-0.4F, 0.0F, 0.15F);
        float lift = -INFINITY;
        for (int c = 0; c < 8; ++c) {
            const Vec3 corner = turned * Vec3((c & 1) != 0 ? 0.4F : -0.4F,
                                              (c & 2) != 0 ? 0.4F : -0.4F,
                                              (c & 4) != 0 ? 0.4F : -0.4F);
            lift =
                std::max(lift, hill(centre.x() + corner.x(), centre.z() + corner.z()) - corner.y());
        }
        centre.y() = lift;
        contacts.collide(
            {surface, Vec3::Zero(), still}, {box, centre, turned}, {0.02F, Vec3::Zero(), 0.0F});
        for (const PartManifold& part : contacts.manifolds()) {
            for (int k = 0; k < part.manifold.count; ++k) {
                const ManifoldPoint& p = part.manifold.points[static_cast<std::size_t>(k)];
                EXPECT_GT(p.separation, -0.0065F) << i;
            }
        }
    }
}

/// A plate that lies across a crest touches it along a line. Held at one end of it alone, it would
/// turn about that end and go through the crest: one of thirty did. A plate is through when its
/// centre lies deeper than it could on any side, which is half its thickness and, on the crest's
/// falling side, what its reach gains of the slope.
TEST(Crest, HoldsPlatesThatTumbleOntoIt) {
    constexpr float kSlope = 0.25F;
    constexpr float kReach = 0.15F;
    const auto roof = [](float x, float z) {
        return -kSlope * std::max(x - z, 0.0F);
    };
    std::vector<Vec3> corners;
    for (const float x : {-4.0F, 4.0F}) {
        for (const float z : {-4.0F, 4.0F}) {
            corners.emplace_back(x, roof(x, z), z);
        }
    }
    const std::vector<std::uint32_t> indices{0, 3, 2, 0, 1, 3};
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::mesh(build_mesh(corners, indices)->mesh);
    std::mt19937 rng(7);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    const auto vector = [&] {
        return Vec3{unit(rng), unit(rng), unit(rng)};
    };
    for (int i = 0; i < 300; ++i) {
        Scene scene{PhysicsSettings()};
        ASSERT_TRUE(scene.add(ground).ok());
        BodyDef plate;
        plate.shape = Shape::box(Vec3(0.1F, 0.009F, 0.1F));
        plate.position = Vec3(0.0F, 0.5F, 0.0F) + 0.1F * vector();
        plate.orientation = Quat(Eigen::AngleAxisf(3.0F * unit(rng), vector().normalized()));
        plate.velocity = Vec3(0.0F, -3.0F, 0.0F) + 0.5F * vector();
        plate.angular_velocity = 12.0F * vector();
        const BodyId id = *scene.add(plate);
        for (int t = 0; t < 180; ++t) {
            scene.step(1.0F / 240.0F);
            const Vec3 at = scene.state(id).position;
            ASSERT_GT(at.y(), roof(at.x(), at.z()) - kSlope * kReach - 0.009F)
                << "plate " << i << " step " << t;
        }
    }
}

/// The same on the upper edge of a beam that lies on one. Up to one plate of thirty had its centre
/// within the beam.
TEST(Crest, OfABeamHoldsPlatesThatTumbleOntoIt) {
    constexpr float kHalf = 0.5F;
    const Vec3 half(2.0F, kHalf, kHalf);
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) {
        corners.push_back(half.cwiseProduct(Vec3((i & 1) != 0 ? 1.0F : -1.0F,
                                                 (i & 2) != 0 ? 1.0F : -1.0F,
                                                 (i & 4) != 0 ? 1.0F : -1.0F)));
    }
    for (const Shape& beam : {Shape::box(half), Shape::hull(build_hull(corners)->hull)}) {
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = beam;
        ground.orientation = Quat(Eigen::AngleAxisf(0.785398F, Vec3::UnitX()));
        ground.position = Vec3(0.0F, -std::sqrt(2.0F) * kHalf, 0.0F);
        std::mt19937 rng(7);
        std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
        const auto vector = [&] {
            return Vec3{unit(rng), unit(rng), unit(rng)};
        };
        for (int i = 0; i < 200; ++i) {
            Scene scene{PhysicsSettings()};
            ASSERT_TRUE(scene.add(ground).ok());
            BodyDef plate;
            plate.shape = Shape::box(Vec3(0.1F, 0.009F, 0.1F));
            plate.position = Vec3(0.0F, 0.5F, 0.0F) + 0.1F * vector();
            plate.orientation = Quat(Eigen::AngleAxisf(3.0F * unit(rng), vector().normalized()));
            plate.velocity = Vec3(0.0F, -3.0F, 0.0F) + 0.5F * vector();
            plate.angular_velocity = 12.0F * vector();
            const BodyId id = *scene.add(plate);
            for (int t = 0; t < 120; ++t) {
                scene.step(1.0F / 240.0F);
                const Vec3 at =
                    ground.orientation.conjugate() * (scene.state(id).position - ground.position);
                ASSERT_LE((half - at.cwiseAbs()).minCoeff(), 0.0F)
                    << "plate " << i << " step " << t;
            }
        }
    }
}

}  // namespace
}  // namespace zoned::physics
