// Moving shapes, overlaps and nearest points against closed forms and against other tests.
#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/query/query.h"
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"
#include "tests/unit/physics/physics_test.h"
#include "tests/unit/physics/surfaces.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace zoned::physics {
namespace {

/// Distances are exact to 1e-6 (1 + size of the shapes); some digits are lost in the computation.
constexpr float kExact = 1.0e-5F;

BodyId add_shape(Scene& scene,
                 const Shape& shape,
                 const Vec3& x = Vec3::Zero(),
                 const Quat& q = Quat::Identity()) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = shape;
    def.position = x;
    def.orientation = q;
    const auto id = scene.add(def);
    EXPECT_TRUE(id.ok());
    return *id;
}

struct Alone {
    Scene scene{PhysicsSettings()};

    explicit Alone(const Shape& shape,
                   const Vec3& x = Vec3::Zero(),
                   const Quat& q = Quat::Identity()) {
        add_shape(scene, shape, x, q);
    }

    /// Distance of a cast; negative for a miss.
    float cast(const Shape& shape,
               const Vec3& from,
               const Vec3& direction,
               const Quat& q = Quat::Identity(),
               float limit = 1000.0F) {
        hit = QueryHit();
        return scene.query().cast({{shape, from, q}, direction, limit}, kAll, hit) ? hit.distance
                                                                                   : -1.0F;
    }

    QueryHit hit;
};

Quat turned(float angle, const Vec3& axis) {
    return Quat(Eigen::AngleAxisf(angle, axis.normalized()));
}

Quat random_turn(core::Rng& rng) {
    Quat q(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
    return q.normalized();
}

Vec3 random_vector(core::Rng& rng, float size) {
    return {rng.range(-size, size), rng.range(-size, size), rng.range(-size, size)};
}

void expect_near(const Vec3& a, const Vec3& b, float tolerance) {
    EXPECT_NEAR((a - b).norm(), 0.0F, tolerance) << a.transpose() << " and " << b.transpose();
}

TEST(Cast, OfABallMeetsAHalfSpaceWhereItsLowestPointDoes) {
    // A plane that leans by 30 degrees; the ball comes straight down on it.
    Alone plane(Shape::plane(), Vec3(0, 1, 0), turned(0.5235988F, Vec3::UnitZ()));
    const Vec3 up(-0.5F, std::sqrt(0.75F), 0);
    const float gap = up.dot(Vec3(2, 9, 3) - Vec3(0, 1, 0)) - 0.75F;
    EXPECT_NEAR(
        plane.cast(Shape::sphere(0.75F), Vec3(2, 9, 3), Vec3(0, -2, 0)), gap / up.y(), kExact);
    expect_near(plane.hit.normal, up, 1e-6F);
    const Vec3 centre = Vec3(2, 9 - plane.hit.distance, 3);
    expect_near(plane.hit.point, centre - 0.75F * up, kExact);
    EXPECT_EQ(plane.cast(Shape::sphere(0.75F), Vec3(2, 9, 3), Vec3(0, 1, 0)), -1.0F);
}

TEST(Cast, OfABallMeetsFaceEdgeAndCornerOfABox) {
    Alone box(Shape::box(Vec3(1, 2, 3)));
    const Shape ball = Shape::sphere(0.5F);
    EXPECT_NEAR(box.cast(ball, Vec3(-9, 1, 1), Vec3::UnitX()), 7.5F, kExact);
    expect_near(box.hit.normal, -Vec3::UnitX(), 1e-5F);
    expect_near(box.hit.point, Vec3(-1, 1, 1), kExact);
    // Beyond the upper edge by 0.3 of the radius 0.5: met where the rounded edge is.
    EXPECT_NEAR(box.cast(ball, Vec3(-9, 2.3F, 1), Vec3::UnitX()), 8.0F - 0.4F, kExact);
    expect_near(box.hit.normal, Vec3(-0.8F, 0.6F, 0), 1e-5F);
    expect_near(box.hit.point, Vec3(-1, 2, 1), kExact);
    // Beyond two edges, by 0.2 and 0.4: the corner; sqrt(0.25 - 0.04 - 0.16) in front of it.
    EXPECT_NEAR(
        box.cast(ball, Vec3(-9, 2.2F, 3.4F), Vec3::UnitX()), 8.0F - std::sqrt(0.05F), kExact);
    expect_near(box.hit.point, Vec3(-1, 2, 3), kExact);
    EXPECT_EQ(box.cast(ball, Vec3(-9, 2.4F, 3.4F), Vec3::UnitX()), -1.0F);  // 0.566 away
}

TEST(Cast, OfABallMeetsBallsAndCapsulesAsARayMeetsThickerOnes) {
    core::Rng rng(1);
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
        const Quat q = random_turn(rng);
        const Vec3 x = random_vector(rng, 3);
        const float r = rng.range(0.1F, 1);
        const float h = i % 2 == 0 ? 0.0F : rng.range(0.1F, 2);
        const float mover = rng.range(0.1F, 1);
        const auto shape = [&](float radius) {
            return h == 0.0F ? Shape::sphere(radius) : Shape::capsule(radius, h);
        };
        Alone thin(shape(r), x, q);
        Alone thick(shape(r + mover), x, q);
        const Vec3 from = random_vector(rng, 1) + Vec3(0, 0, 12);
        const Vec3 direction = x + random_vector(rng, 2) - from;
        QueryHit ray;
        const bool met = thick.scene.query().ray({from, direction, 100}, kAll, ray);
        const float distance = thin.cast(Shape::sphere(mover), from, direction);
        EXPECT_EQ(met, distance >= 0.0F);
        if (met) {
            ++hits;
            // Where the cast only grazes, a hair of distance to the side is much along the cast.
            const float graze = std::abs(ray.normal.dot(direction.normalized()));
            // The ray is cast in floats, from 12 m away.
            EXPECT_NEAR(distance, ray.distance, 4 * kExact / std::max(graze, 0.01F));
        }
    }
    EXPECT_GT(hits, 100);
}

TEST(Cast, OfACapsuleMeetsWhatItsSideOrItsEndMeets) {
    const Shape capsule = Shape::capsule(0.25F, 1.0F);
    Alone box(Shape::box(Vec3::Ones()));
    // Upright against the side; from above with its end.
    EXPECT_NEAR(box.cast(capsule, Vec3(5, 0.5F, 0), -Vec3::UnitX()), 3.75F, kExact);
    EXPECT_NEAR(box.cast(capsule, Vec3(0.2F, 5, 0), -Vec3::UnitY()), 2.75F, kExact);
    expect_near(box.hit.point, Vec3(0.2F, 1, 0), kExact);
    // Lying along z, down onto the upper edge: the side touches the edge line.
    const Quat lying = turned(1.5707963F, Vec3::UnitX());
    EXPECT_NEAR(box.cast(capsule, Vec3(1.15F, 5, 0), -Vec3::UnitY(), lying), 4.0F - 0.2F, kExact);
    Alone ball(Shape::sphere(0.5F));
    EXPECT_NEAR(ball.cast(capsule, Vec3(0.45F, 5, 0), -Vec3::UnitY()), 4.0F - 0.6F, kExact);
    Alone plane(Shape::plane());
    EXPECT_NEAR(plane.cast(capsule, Vec3(0, 5, 0), -Vec3::UnitY(), turned(0.5F, Vec3::UnitX())),
                5.0F - std::cos(0.5F) - 0.25F,
                kExact);
}

TEST(Cast, OfABoxMeetsWithFaceEdgeOrCorner) {
    const Shape cube = Shape::box(Vec3::Constant(0.5F));
    Alone box(Shape::box(Vec3::Ones()));
    EXPECT_NEAR(box.cast(cube, Vec3(0.3F, 7, 0.2F), -Vec3::UnitY()), 5.5F, kExact);
    expect_near(box.hit.normal, Vec3::UnitY(), 1e-5F);
    // Turned by 45 degrees it comes down on its edge, twice turned on its corner.
    const Quat on_edge = turned(0.78539816F, Vec3::UnitZ());
    EXPECT_NEAR(
        box.cast(cube, Vec3(0, 7, 0), -Vec3::UnitY(), on_edge), 6.0F - std::sqrt(0.5F), kExact);
    const Quat on_corner = Quat::FromTwoVectors(Vec3::Ones(), Vec3::UnitY());
    EXPECT_NEAR(
        box.cast(cube, Vec3(0, 7, 0), -Vec3::UnitY(), on_corner), 6.0F - std::sqrt(0.75F), kExact);
    expect_near(box.hit.point, Vec3(0, 1, 0), kExact);
    // Edge on edge, crossed: both turned by 45 degrees about crossing axes.
    Alone roof(Shape::box(Vec3::Constant(0.5F)), Vec3::Zero(), turned(0.78539816F, Vec3::UnitX()));
    EXPECT_NEAR(roof.cast(cube, Vec3(0, 7, 0), -Vec3::UnitY(), on_edge),
                7.0F - 2.0F * std::sqrt(0.5F),
                kExact);
    Alone plane(Shape::plane());
    EXPECT_NEAR(plane.cast(cube, Vec3(0, 7, 0), -Vec3::UnitY(), on_corner),
                7.0F - std::sqrt(0.75F),
                kExact);
}

/// All pairs of convex kinds on random casts, judged by the tests of the narrowphase. These find
/// their answers by separating axes (true to 2 mm: they prefer faces to edges by so much).
TEST(Cast, StopsWhereTheNarrowphaseSaysThatShapesTouch) {
    constexpr float kBias = 2.5e-3F;
    core::Rng rng(3);
    int hits = 0;
    int misses = 0;
    const auto random_shape = [&](std::uint32_t kind) {
        switch (kind) {
            case 0:
                return Shape::sphere(rng.range(0.2F, 1));
            case 1:
                return Shape::box(Vec3(rng.range(0.2F, 1), rng.range(0.2F, 1), rng.range(0.2F, 1)));
            default:
                return Shape::capsule(rng.range(0.2F, 0.6F), rng.range(0.2F, 1));
        }
    };
    for (int i = 0; i < 600; ++i) {
        const Shape mover = random_shape(rng.below(3));
        const Shape target = random_shape(rng.below(3));
        const Quat q = random_turn(rng);
        const Quat target_q = random_turn(rng);
        const Vec3 target_x = random_vector(rng, 2);
        const Vec3 from = random_vector(rng, 2) + Vec3(8, 0, 0);
        const Vec3 direction = (target_x + random_vector(rng, 1.5F) - from).normalized();
        Alone alone(target, target_x, target_q);
        const float distance = alone.cast(mover, from, direction, q, 30.0F);
        const Mat3 r = q.toRotationMatrix();
        const Mat3 target_r = target_q.toRotationMatrix();
        const auto separation = [&](float way) {
            Manifold m;
            collide({mover, from + way * direction, r}, {target, target_x, target_r}, 1.0F, m);
            return m.separation;
        };
        const float end = distance >= 0.0F ? distance : 30.0F;
        for (float way = 0.0F; way < end - 0.01F; way += 0.05F) {
            ASSERT_GT(separation(way), -kBias) << i;
        }
        if (distance >= 0.0F) {
            ++hits;
            EXPECT_NEAR(separation(distance), 0.0F, kBias) << i;
        } else {
            ++misses;
        }
    }
    EXPECT_GT(hits, 200);
    EXPECT_GT(misses, 50);
}

TEST(Cast, IsAsExactAtTheEndOfTheWorld) {
    // Positions that a float can hold there; between them nothing is rounded.
    const Vec3 far(917504.0F, -65536.0F, 524288.0F);
    Alone box(Shape::box(Vec3::Ones()), far);
    EXPECT_NEAR(box.cast(Shape::sphere(0.5F), far + Vec3(0, 8, 0), -Vec3::UnitY()), 6.5F, kExact);
    EXPECT_NEAR(box.cast(Shape::sphere(0.5F), far + Vec3(1.25F, 8, 0), -Vec3::UnitY()),
                7.0F - std::sqrt(0.1875F),
                kExact);
    EXPECT_EQ(box.cast(Shape::sphere(0.5F), far + Vec3(1.5625F, 8, 0), -Vec3::UnitY()), -1.0F);
}

TEST(Cast, TellsAHairsBreadthOfGrazing) {
    Alone ball(Shape::sphere(1.0F));
    const Shape other = Shape::sphere(0.5F);
    EXPECT_GT(ball.cast(other, Vec3(-20, 1.4999F, 0), Vec3::UnitX()), 19.9F);
    EXPECT_EQ(ball.cast(other, Vec3(-20, 1.5001F, 0), Vec3::UnitX()), -1.0F);
}

TEST(Cast, EndsAtItsLimit) {
    Alone box(Shape::box(Vec3::Ones()));
    const Shape ball = Shape::sphere(0.5F);
    EXPECT_NEAR(
        box.cast(ball, Vec3(0, 9, 0), -Vec3::UnitY(), Quat::Identity(), 7.5001F), 7.5F, kExact);
    EXPECT_EQ(box.cast(ball, Vec3(0, 9, 0), -Vec3::UnitY(), Quat::Identity(), 7.4999F), -1.0F);
}

TEST(Cast, IsHeldByWhatItTouchesOnlyWhereItMovesTowardsIt) {
    const Quat q = turned(0.3F, Vec3::UnitY());
    for (const Shape& floor : {Shape::plane(), Shape::box(Vec3(50, 2, 50))}) {
        const float top = floor.kind == ShapeKind::kPlane ? 0.0F : 2.0F;
        Alone ground(floor);
        for (const Shape& shape : {Shape::box(Vec3::Constant(0.5F)), Shape::sphere(0.5F)}) {
            // At rest bodies overlap a little.
            for (const float sunk : {0.0F, 1.0e-6F, 2.0e-3F}) {
                const Vec3 at(3, top + 0.5F - sunk, 4);
                EXPECT_EQ(ground.cast(shape, at, Vec3::UnitX(), q), -1.0F) << sunk;
                EXPECT_EQ(ground.cast(shape, at, Vec3(1, 2, 0), q), -1.0F);
                EXPECT_NEAR(ground.cast(shape, at, Vec3(1, -0.1F, 0), q), 0.0F, kExact);
                expect_near(ground.hit.normal, Vec3::UnitY(), 1e-3F);
            }
            // Deep inside, no exit is counted.
            EXPECT_EQ(ground.cast(shape, Vec3(3, top + 0.3F, 4), Vec3::UnitX(), q), 0.0F);
            expect_near(ground.hit.normal, -Vec3::UnitX(), 1e-6F);
        }
    }
}

/// A box given as a box, a hull, a compound and a mesh of triangles.
TEST(Cast, MeetsABoxAlikeHoweverItIsGiven) {
    const Vec3 half(1.0F, 0.6F, 0.4F);
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) {
        corners.push_back(half.cwiseProduct(
            Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
    }
    MeshInput faces;
    const auto face = [&](int a, int b, int c, int d) {
        const auto at = [&](int i) {
            return corners[static_cast<std::size_t>(i)];
        };
        faces.add(at(a), at(b), at(c), at(d));
    };
    face(0, 4, 6, 2);
    face(1, 3, 7, 5);
    face(0, 1, 5, 4);
    face(2, 6, 7, 3);
    face(0, 2, 3, 1);
    face(4, 5, 7, 6);
    const BuiltHull hull = *build_hull(corners);
    CompoundPart left;
    left.shape = Shape::box(Vec3(0.5F, 0.6F, 0.4F));
    left.frame.position = Vec3(-0.5F, 0, 0);
    CompoundPart right = left;
    right.frame.position = Vec3(0.5F, 0, 0);
    const BuiltCompound compound = *build_compound(std::array{left, right});
    core::Rng rng(6);
    const Frame place{Vec3(2, 3, 4), turned(0.7F, Vec3(1, 2, 3))};
    const Frame hull_place = place * hull.frame;
    const Frame compound_place = place * compound.frame;
    Alone box(Shape::box(half), place.position, place.rotation);
    Alone by_hull(Shape::hull(hull.hull), hull_place.position, hull_place.rotation);
    Alone by_compound(
        Shape::compound(compound.compound), compound_place.position, compound_place.rotation);
    Alone by_mesh(mesh_shape(faces), place.position, place.rotation);
    const Shape movers[] = {Shape::sphere(0.3F),
                            Shape::capsule(0.2F, 0.5F),
                            Shape::box(Vec3(0.3F, 0.2F, 0.4F)),
                            Shape::hull(hull.hull)};
    int hits = 0;
    for (int i = 0; i < 400; ++i) {
        const Shape& mover = movers[rng.below(4)];
        const Vec3 from = place.position + 5.0F * random_vector(rng, 1).normalized();
        const Vec3 direction = place.position + random_vector(rng, 1) - from;
        const Quat q = random_turn(rng);
        const float expected = box.cast(mover, from, direction, q);
        hits += expected > 0.0F ? 1 : 0;
        for (Alone* other : {&by_hull, &by_compound, &by_mesh}) {
            // Corners of the hull were turned to its principal axes and back; and grazing.
            const float found = other->cast(mover, from, direction, q);
            EXPECT_NEAR(found, expected, 2e-4F) << i;
            if (expected > 0.0F) {
                EXPECT_GT(other->hit.normal.dot(box.hit.normal), 0.99F) << i;
            }
        }
        QueryHit near_box;
        QueryHit near_other;
        ASSERT_TRUE(box.scene.query().closest({mover, from, q}, 100, kAll, near_box));
        for (const Alone* other : {&by_hull, &by_compound, &by_mesh}) {
            ASSERT_TRUE(other->scene.query().closest({mover, from, q}, 100, kAll, near_other));
            EXPECT_NEAR(near_other.distance, near_box.distance, 1e-5F) << i;
        }
    }
    EXPECT_GT(hits, 200);
}

TEST(Cast, MeetsAFieldOfHeightsAsTheMeshOfTheSameTriangles) {
    const auto hills = [](float x, float z) {
        return 0.7F * std::sin(0.9F * x) * std::cos(1.3F * z);
    };
    Alone field(field_shape(41, 0.5F, hills));
    MeshInput input;
    for (int i = 0; i < 40; ++i) {
        for (int k = 0; k < 40; ++k) {
            const auto at = [&](int a, int b) {
                const float x = 0.5F * static_cast<float>(a) - 10.0F;
                const float z = 0.5F * static_cast<float>(b) - 10.0F;
                return Vec3(x, hills(x, z), z);
            };
            input.add(at(i, k), at(i + 1, k + 1), at(i + 1, k));
            input.add(at(i, k), at(i, k + 1), at(i + 1, k + 1));
        }
    }
    Alone mesh(mesh_shape(input));
    core::Rng rng(9);
    int hits = 0;
    for (int i = 0; i < 150; ++i) {
        const Vec3 from(rng.range(-12, 12), rng.range(2, 6), rng.range(-12, 12));
        const Vec3 direction(rng.range(-1, 1), rng.range(-0.5F, 0), rng.range(-1, 1));
        const Shape mover = i % 2 == 0 ? Shape::sphere(0.4F) : Shape::box(Vec3(0.3F, 0.2F, 0.5F));
        const float expected = mesh.cast(mover, from, direction);
        EXPECT_NEAR(field.cast(mover, from, direction), expected, 1e-4F);
        hits += expected >= 0.0F ? 1 : 0;
        QueryHit a;
        QueryHit b;
        const float limit = rng.range(0, 5);
        const bool near = mesh.scene.query().closest_to_point(from, limit, kAll, a);
        EXPECT_EQ(field.scene.query().closest_to_point(from, limit, kAll, b), near);
        if (near) {
            EXPECT_NEAR(a.distance, b.distance, 1e-5F);
        }
    }
    EXPECT_GT(hits, 40);
    EXPECT_LT(hits, 110);
    // Solid from the surface down to its lowest point, and open above.
    EXPECT_TRUE(field.scene.query().overlap_any({Shape::sphere(0.1F), Vec3(0, -0.5F, 0)}, kAll));
    EXPECT_FALSE(field.scene.query().overlap_any({Shape::sphere(0.1F), Vec3(0, 2, 0)}, kAll));
    EXPECT_FALSE(field.scene.query().overlap_any({Shape::sphere(0.1F), Vec3(30, -5, 0)}, kAll));
}

TEST(Overlap, OfShapesIsWhatTheNarrowphaseSays) {
    constexpr float kBias = 2.5e-3F;
    core::Rng rng(12);
    int overlapping = 0;
    int apart = 0;
    for (int i = 0; i < 1500; ++i) {
        const auto shape = [&]() {
            const Vec3 size(rng.range(0.2F, 1), rng.range(0.2F, 1), rng.range(0.2F, 1));
            const std::uint32_t kind = rng.below(3);
            return kind == 0   ? Shape::sphere(size.x())
                   : kind == 1 ? Shape::box(size)
                               : Shape::capsule(size.x(), size.y());
        };
        const Shape a = shape();
        const Shape b = i % 10 == 0 ? Shape::plane() : shape();
        const Vec3 xa = random_vector(rng, 1.2F);
        const Quat qa = random_turn(rng);
        const Quat qb = random_turn(rng);
        Manifold m;
        collide({a, xa, qa.toRotationMatrix()}, {b, Vec3::Zero(), qb.toRotationMatrix()}, 1.0F, m);
        if (std::abs(m.separation) < kBias) {
            continue;
        }
        const Alone alone(b, Vec3::Zero(), qb);
        EXPECT_EQ(alone.scene.query().overlap_any({a, xa, qa}, kAll), m.separation < 0.0F) << i;
        (m.separation < 0.0F ? overlapping : apart) += 1;
    }
    EXPECT_GT(overlapping, 300);
    EXPECT_GT(apart, 300);
}

TEST(Closest, PointOfABodyIsThatOfItsClosedForm) {
    core::Rng rng(4);
    for (int i = 0; i < 500; ++i) {
        const Quat q = random_turn(rng);
        const Vec3 x = random_vector(rng, 5);
        const Vec3 p = x + random_vector(rng, 4);
        const Vec3 local = q.conjugate() * (p - x);
        const Vec3 half(rng.range(0.2F, 1), rng.range(0.2F, 1), rng.range(0.2F, 1));
        Vec3 nearest = Vec3::Zero();
        Shape shape;
        switch (i % 4) {
            case 0:
                shape = Shape::box(half);
                nearest = local.cwiseMax(-half).cwiseMin(half);
                break;
            case 1:
                shape = Shape::sphere(half.x());
                nearest = half.x() * local.normalized();
                break;
            case 2: {
                shape = Shape::capsule(half.x(), half.y());
                const Vec3 core(0, std::clamp(local.y(), -half.y(), half.y()), 0);
                nearest = core + half.x() * (local - core).normalized();
                break;
            }
            default:
                shape = Shape::plane();
                nearest = Vec3(local.x(), 0, local.z());
        }
        const bool inside = i % 4 == 0   ? nearest == local
                            : i % 4 == 3 ? local.y() <= 0.0F
                                         : local.norm() < nearest.norm();
        const Alone alone(shape, x, q);
        QueryHit hit;
        ASSERT_TRUE(alone.scene.query().closest_to_point(p, 100, kAll, hit));
        if (inside) {
            EXPECT_EQ(hit.distance, 0.0F);
            expect_near(hit.point, p, 1e-5F);
            continue;
        }
        const float distance = (local - nearest).norm();
        EXPECT_NEAR(hit.distance, distance, kExact);
        expect_near(hit.point, x + q * nearest, 3 * kExact);
        expect_near(distance * hit.normal, p - hit.point, 3 * kExact);
        EXPECT_FALSE(alone.scene.query().closest_to_point(p, distance - 1e-4F, kAll, hit));
    }
}

TEST(Closest, OfManyBodiesIsTheNearest) {
    core::Rng rng(8);
    Scene scene{PhysicsSettings()};
    std::vector<Vec3> centres;
    for (int i = 0; i < 500; ++i) {
        centres.push_back(random_vector(rng, 30));
        add_shape(scene, Shape::sphere(0.3F), centres.back());
    }
    for (int i = 0; i < 200; ++i) {
        const Vec3 p = random_vector(rng, 40);
        float expected = INFINITY;
        for (const Vec3& c : centres) {
            expected = std::min(expected, std::max(0.0F, (c - p).norm() - 0.3F));
        }
        QueryHit hit;
        ASSERT_TRUE(scene.query().closest_to_point(p, INFINITY, kAll, hit));
        EXPECT_NEAR(hit.distance, expected, 2 * kExact);
        const Shape box = Shape::capsule(0.2F, 0.7F);
        ASSERT_TRUE(scene.query().closest({box, p}, INFINITY, kAll, hit));
        expected = INFINITY;
        for (const Vec3& c : centres) {
            const Vec3 core = p + Vec3(0, std::clamp(c.y() - p.y(), -0.7F, 0.7F), 0);
            expected = std::min(expected, std::max(0.0F, (c - core).norm() - 0.5F));
        }
        EXPECT_NEAR(hit.distance, expected, 2 * kExact);
    }
}

}  // namespace
}  // namespace zoned::physics
