// build: computes
#include "server/physics/narrowphase/narrowphase.h"

#include "tests/unit/physics/thing.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

Mat3 turned_by(float angle, const Vec3& axis) {
    return Mat3(Eigen::AngleAxisf(angle, axis.normalized()));
}

/// Furthest point of the shape along a direction: defines any convex shape.
Vec3 support(const Thing& t, const Vec3& direction) {
    const Vec3 d = t.rotation.transpose() * direction;
    Vec3 p = Vec3::Zero();
    if (t.shape.kind == ShapeKind::kBox) {
        p = t.shape.half_extents.cwiseProduct(d.cwiseSign());
    } else if (t.shape.kind == ShapeKind::kCapsule) {
        p.y() = std::copysign(t.shape.half_segment, d.y());
    }
    Vec3 out = t.rotation * p + t.position;
    if (t.shape.kind != ShapeKind::kBox) {
        out += t.shape.radius * direction.normalized();
    }
    return out;
}

float gap_along(const Thing& a, const Thing& b, const Vec3& n) {
    return n.dot(support(b, -n)) - n.dot(support(a, n));
}

Thing any_thing(core::Rng& rng) {
    Thing t;
    switch (rng.below(3)) {
        case 0:
            t.shape = Shape::sphere(rng.range(0.2F, 0.8F));
            break;
        case 1:
            t.shape =
                Shape::box({rng.range(0.2F, 0.8F), rng.range(0.2F, 0.8F), rng.range(0.2F, 0.8F)});
            break;
        default:
            t.shape = Shape::capsule(rng.range(0.2F, 0.5F), rng.range(0.2F, 0.8F));
            break;
    }
    t.position = Vec3(rng.range(-0.9F, 0.9F), rng.range(-0.9F, 0.9F), rng.range(-0.9F, 0.9F));
    t.rotation = Quat(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1))
                     .normalized()
                     .toRotationMatrix();
    return t;
}

bool is_capsule_on_box(const Thing& a, const Thing& b) {
    return (a.shape.kind == ShapeKind::kBox && b.shape.kind == ShapeKind::kCapsule) ||
           (b.shape.kind == ShapeKind::kBox && a.shape.kind == ShapeKind::kCapsule);
}

/// Distance of a capsule's core to a box by sampling: at most half a sample (0.8 mm) along off,
/// which is far less in distance.
float core_distance(const Thing& box, const Thing& capsule) {
    float least = 1e9F;
    const Vec3 half = box.shape.half_extents;
    for (int i = 0; i <= 1000; ++i) {
        const float t = (static_cast<float>(i) / 500.0F - 1.0F) * capsule.shape.half_segment;
        const Vec3 p = box.placed().to_local(capsule.position + t * capsule.rotation.col(1));
        least = std::min(least, (p - p.cwiseMax(-half).cwiseMin(half)).norm());
    }
    return least;
}

TEST(Collide, ReportsTheGapThatTheSupportsHaveAlongItsNormal) {
    // For any pair and any unit normal the gap along it follows from the two support functions. A
    // round pair may report its exact distance, a box pair the best of 15 axes.
    core::Rng rng(21);
    int overlapping = 0;
    for (int i = 0; i < 20000; ++i) {
        const Thing a = any_thing(rng);
        const Thing b = any_thing(rng);
        const Manifold m = collide_things(a, b, 10.0F);
        ASSERT_NEAR(m.normal.norm(), 1.0F, 1e-5F);
        const bool capsule_on_box = is_capsule_on_box(a, b);
        if (capsule_on_box) {
            // Along a face the normal is the face's, but the gap stays the distance.
            const Thing& box = a.shape.kind == ShapeKind::kBox ? a : b;
            const Thing& capsule = a.shape.kind == ShapeKind::kBox ? b : a;
            const float distance = core_distance(box, capsule);
            if (distance > 1e-3F) {
                ASSERT_NEAR(m.separation, distance - capsule.shape.radius, 1e-3F) << i;
            }
        } else {
            // Nearly parallel capsules (1.8 degrees) report the nearer of their two ends.
            const bool capsules =
                a.shape.kind == ShapeKind::kCapsule && b.shape.kind == ShapeKind::kCapsule;
            ASSERT_NEAR(m.separation, gap_along(a, b, m.normal), capsules ? 1e-3F : 2e-5F)
                << i << " " << static_cast<int>(a.shape.kind) << static_cast<int>(b.shape.kind);
        }
        overlapping += m.separation < 0 ? 1 : 0;
        ASSERT_LE(m.count, 4);
        float lowest = 1e9F;
        for (int k = 0; k < m.count; ++k) {
            lowest = std::min(lowest, m.points[static_cast<std::size_t>(k)].separation);
        }
        if (m.count > 0 && m.separation < 0 && !capsule_on_box) {
            ASSERT_NEAR(lowest, m.separation, 3e-3F) << i;  // within the bias towards faces
        }
    }
    EXPECT_GT(overlapping, 3000);
}

/// Edges that are parallel but for 5e-3 to 2e-2 rad, the least that counts as an axis of its own.
/// The length of a normal has rounding errors of a few steps, from itself and from the rotation.
TEST(Collide, HasUnitNormalsWhereEdgesAreNearlyParallel) {
    core::Rng rng(23);
    int edges = 0;
    for (int i = 0; i < 20000; ++i) {
        Thing a = any_thing(rng);
        Thing b = any_thing(rng);
        a.shape = Shape::box({0.3F, 0.4F, 0.5F});
        b.shape = Shape::box({0.5F, 0.4F, 0.3F});
        const Vec3 tilt(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
        b.rotation = a.rotation * turned_by(rng.range(5.0e-3F, 2.0e-2F), tilt) *
                     turned_by(rng.range(-3, 3), Vec3::Unit(i % 3));
        const Manifold m = collide_things(a, b, 10.0F);
        ASSERT_NEAR(m.normal.norm(), 1.0F, 2e-6F) << i;
        edges += m.count == 1 ? 1 : 0;
    }
    EXPECT_GT(edges, 100);
}

TEST(Collide, IsTheSameSeenFromTheOtherSide) {
    core::Rng rng(22);
    for (int i = 0; i < 5000; ++i) {
        const Thing a = any_thing(rng);
        const Thing b = any_thing(rng);
        const Manifold ab = collide_things(a, b, 10.0F);
        const Manifold ba = collide_things(b, a, 10.0F);
        ASSERT_NEAR(ab.separation, ba.separation, 3e-3F);  // ties of axes: either result
        if (a.shape.kind != b.shape.kind) {
            ASSERT_EQ(ab.normal, -ba.normal);
            ASSERT_EQ(ab.count, ba.count);
        }
    }
}

TEST(CollideBoxBox, SeesThatCrossedEdgesDoNotTouchWhereFaceAxesOverlap) {
    // Two long bars, each turned by 45 degrees about its own axis and crossed, edge against edge
    // with a gap: every face axis of both sees an overlap.
    Thing a;
    a.shape = Shape::box(Vec3(2.0F, 0.5F, 0.5F));
    a.rotation = turned_by(3.14159265F / 4, Vec3::UnitX());
    Thing b;
    b.shape = Shape::box(Vec3(0.5F, 0.5F, 2.0F));
    b.rotation = turned_by(3.14159265F / 4, Vec3::UnitZ());
    const float edge = 0.5F * std::sqrt(2.0F);
    b.position = Vec3(0, 2 * edge + 0.01F, 0);
    for (int i = 0; i < 3; ++i) {
        for (const Mat3* r : {&a.rotation, &b.rotation}) {
            const Vec3 axis = r->col(i);
            const float gap = std::max(gap_along(a, b, axis), gap_along(a, b, -axis));
            EXPECT_LT(gap, -0.1F);  // the faces alone would report a touch
        }
    }
    EXPECT_EQ(collide_things(a, b, 0.0F).count, 0);
    const Manifold near = collide_things(a, b, 0.02F);
    ASSERT_EQ(near.count, 1);
    EXPECT_NEAR(near.separation, 0.01F, 1e-5F);
    EXPECT_NEAR(near.normal.y(), 1.0F, 1e-5F);
    EXPECT_LT((near.points[0].point - Vec3(0, edge + 0.005F, 0)).norm(), 1e-5F);
}

TEST(CollideBoxBox, StackedBoxesTouchAtTheFourCornersOfTheSmaller) {
    Thing a{Shape::box(Vec3(2, 0.5F, 2))};
    Thing b{Shape::box(Vec3(0.5F, 0.5F, 0.25F)),
            Vec3(0.3F, 0.99F, 0.1F),
            turned_by(0.4F, Vec3::UnitY())};
    const Manifold m = collide_things(a, b);
    ASSERT_EQ(m.count, 4);
    for (const ManifoldPoint& p : m.points) {
        EXPECT_NEAR(p.separation, -0.01F, 1e-6F);
        EXPECT_NEAR(p.point.y(), 0.495F, 1e-6F);
        const Vec3 local = b.rotation.transpose() * (p.point - b.position);
        EXPECT_NEAR(std::abs(local.x()), 0.5F, 1e-5F);
        EXPECT_NEAR(std::abs(local.z()), 0.25F, 1e-5F);
    }
}

TEST(CollideBoxBox, FeatureNamesLastWhileTheBoxesSlideALittle) {
    Thing a{Shape::box(Vec3(0.5F, 0.5F, 0.5F))};
    Thing b{Shape::box(Vec3(0.5F, 0.5F, 0.5F)), Vec3(0.2F, 0.995F, 0.1F)};
    const Manifold first = collide_things(a, b);
    b.position += Vec3(0.003F, -0.001F, 0.002F);
    b.rotation = turned_by(0.001F, Vec3(1, 2, 3));
    const Manifold second = collide_things(a, b);
    ASSERT_EQ(first.count, 4);
    ASSERT_EQ(second.count, 4);
    for (const ManifoldPoint& p : first.points) {
        int same = 0;
        for (const ManifoldPoint& q : second.points) {
            same += p.feature == q.feature && (p.point - q.point).norm() < 0.02F ? 1 : 0;
        }
        EXPECT_EQ(same, 1);
    }
}

TEST(KeepFour, KeepsTheDeepestAndTheWidestOfAnOctagon) {
    std::array<ManifoldPoint, 8> points;
    for (int i = 0; i < 8; ++i) {
        const float angle = 3.14159265F / 4 * static_cast<float>(i);
        points[static_cast<std::size_t>(i)] = {Vec3(std::cos(angle), 0, std::sin(angle)),
                                               i == 3 ? -0.02F : -0.01F,
                                               static_cast<std::uint32_t>(i)};
    }
    Manifold m;
    m.normal = Vec3::UnitY();
    keep_four(points, m);
    ASSERT_EQ(m.count, 4);
    EXPECT_EQ(m.points[0].feature, 3U);  // deepest
    EXPECT_EQ(m.points[1].feature, 7U);  // opposite
    // Then the two ends of the other diameter: together a square.
    EXPECT_EQ(m.points[2].feature + m.points[3].feature, 1U + 5U);
}

/// A box across a ridge: the ridge cuts into it at two points, its corners are in the air.
TEST(KeepFour, PrefersWhatOverlapsToWhatIsApart) {
    const std::array<ManifoldPoint, 6> points{{{Vec3(-0.3F, 0, 0), -0.004F, 0},
                                               {Vec3(0.3F, 0, 0), -0.003F, 1},
                                               {Vec3(-0.5F, 0, -0.5F), 0.008F, 2},
                                               {Vec3(0.5F, 0, -0.5F), 0.008F, 3},
                                               {Vec3(0.5F, 0, 0.5F), 0.008F, 4},
                                               {Vec3(-0.5F, 0, 0.5F), 0.0F, 5}}};
    Manifold m;
    m.normal = Vec3::UnitY();
    keep_four(points, m);
    ASSERT_EQ(m.count, 4);
    EXPECT_EQ(m.points[0].feature, 0U);
    EXPECT_EQ(m.points[1].feature, 1U);
    EXPECT_EQ(m.points[2].feature, 5U);
}

TEST(Clip, CutsAQuadrilateralByAPlane) {
    Polygon p;
    const float xs[] = {-1, 1, 1, -1};
    const float ys[] = {-1, -1, 1, 1};
    for (std::uint32_t i = 0; i < 4; ++i) {
        p.add({Vec3(xs[i], ys[i], 0), i, i});
    }
    Polygon kept;
    clip(p, Vec3::UnitX(), 0.25F, 4, 4, kept);
    ASSERT_EQ(kept.count, 4);
    for (int i = 0; i < kept.count; ++i) {
        EXPECT_LE(kept[i].position.x(), 0.25F);
    }
}

TEST(CollideCapsuleBox, LyingOnAFaceTouchesAtBothEnds) {
    Thing box{Shape::box(Vec3(2, 0.5F, 2))};
    Thing capsule{
        Shape::capsule(0.3F, 0.6F), Vec3(0, 0.79F, 0), turned_by(3.14159265F / 2, Vec3::UnitZ())};
    const Manifold m = collide_things(box, capsule);
    ASSERT_EQ(m.count, 2);
    EXPECT_NEAR(m.normal.y(), 1.0F, 1e-6F);
    EXPECT_NEAR(m.points[0].separation, -0.01F, 1e-5F);
    EXPECT_NEAR(std::abs(m.points[0].point.x() - m.points[1].point.x()), 1.2F, 1e-5F);
}

TEST(CollideSphereBox, FromInsideLeavesThroughTheNearestFace) {
    Thing sphere{Shape::sphere(0.1F), Vec3(0.1F, 0.7F, 0.2F)};
    Thing box{Shape::box(Vec3(1, 1, 1))};
    const Manifold m = collide_things(sphere, box);
    ASSERT_EQ(m.count, 1);
    EXPECT_NEAR(m.separation, -0.4F, 1e-6F);
    EXPECT_NEAR(m.normal.y(), -1.0F, 1e-6F);
}

TEST(CollidePlane, BoxRestsOnItsLowestFace) {
    Thing box{
        Shape::box(Vec3(0.5F, 0.3F, 0.4F)), Vec3(0, 0.295F, 0), turned_by(0.001F, Vec3::UnitX())};
    Thing plane{Shape::plane()};
    const Manifold m = collide_things(box, plane);
    ASSERT_EQ(m.count, 4);
    EXPECT_NEAR(m.normal.y(), -1.0F, 1e-6F);
}

TEST(CollideAhead, FindsTheImpactOfAFastBallAndNotTheEmptySpaceBesideIt) {
    Thing ball{Shape::sphere(0.1F), Vec3(-3, 0, 0)};
    Thing post{Shape::sphere(0.1F)};
    PairMotion motion;
    motion.velocity_a = Vec3(100, 0, 0);
    motion.dt = 1.0F / 30.0F;
    Manifold m;
    const float time = collide_ahead(ball.placed(), post.placed(), motion, m).time;
    ASSERT_EQ(m.count, 1);
    EXPECT_NEAR(time, 0.028F, 1.2e-4F);  // 2.8 m at 100 m/s, up to the gap that counts as impact
    ball.position.y() = 0.25F;           // passes 5 cm beside the post
    collide_ahead(ball.placed(), post.placed(), motion, m);
    EXPECT_EQ(m.count, 0);
}

}  // namespace
}  // namespace zoned::physics
