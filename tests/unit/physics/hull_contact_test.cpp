// build: computes
// Hulls against all convex shapes: manifolds against brute force.
#include "server/physics/narrowphase/gjk.h"
#include "server/physics/narrowphase/hull_axis.h"
#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/shapes/mass_properties.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/thing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

Thing random_hull(core::Rng& rng, int points = 16) {
    Thing t{hull_shape(random_points(rng, points, 0.6F))};
    const float x = rng.range(-0.9F, 0.9F);
    const float y = rng.range(-0.9F, 0.9F);
    t.position = Vec3(x, y, rng.range(-0.9F, 0.9F));
    t.rotation = random_rotation(rng).toRotationMatrix();
    return t;
}

Thing random_box(core::Rng& rng) {
    Thing t = random_hull(rng);
    const float x = rng.range(0.2F, 0.8F);
    const float y = rng.range(0.2F, 0.8F);
    t.shape = Shape::box(Vec3(x, y, rng.range(0.2F, 0.8F)));
    return t;
}

/// A polyhedron in world coordinates and doubles.
struct Solid {
    std::vector<Vec3d> corners;
    std::vector<Vec3d> normals;
    std::vector<Vec3d> edges;

    explicit Solid(const Thing& t) {
        const BoxHull box(t.shape.half_extents);
        const bool is_box = t.shape.kind == ShapeKind::kBox;
        const HullView view = is_box ? box.view() : hull_of(t.shape).view();
        const Mat3d r = t.rotation.cast<double>();
        for (int i = 0; i < view.points.count; ++i) {
            corners.emplace_back(r * view.points[i].cast<double>() + t.position.cast<double>());
        }
        for (int f = 0; f < view.face_count; ++f) {
            normals.emplace_back(r * view.faces[f].normal.cast<double>());
        }
        for (int e = 0; e < view.edge_count; ++e) {
            const HullEdge& edge = view.edges[e];
            edges.emplace_back(r * (view.points[edge.to] - view.points[edge.from]).cast<double>());
        }
    }

    [[nodiscard]] double farthest(const Vec3d& n) const {
        double most = -1e9;
        for (const Vec3d& c : corners) {
            most = std::max(most, n.dot(c));
        }
        return most;
    }

    [[nodiscard]] double height(const Vec3d& p) const {
        double most = -1e9;
        for (const Vec3d& n : normals) {
            most = std::max(most, n.dot(p) - farthest(n));
        }
        return most;
    }
};

double gap_along(const Solid& a, const Solid& b, const Vec3d& n) {
    return -b.farthest(-n) - a.farthest(n);
}

/// The largest gap over the normals of both and all cross products of edges, in either direction.
double best_gap(const Solid& a, const Solid& b, bool edges) {
    double best = -1e9;
    for (const Vec3d& n : a.normals) {
        best = std::max(best, gap_along(a, b, n));
    }
    for (const Vec3d& n : b.normals) {
        best = std::max(best, gap_along(a, b, -n));
    }
    for (std::size_t i = 0; edges && i < a.edges.size(); ++i) {
        for (const Vec3d& e : b.edges) {
            const Vec3d axis = a.edges[i].cross(e);
            if (axis.norm() > kParallel * a.edges[i].norm() * e.norm()) {
                best = std::max(best, gap_along(a, b, axis.normalized()));
                best = std::max(best, gap_along(a, b, -axis.normalized()));
            }
        }
    }
    return best;
}

void check_polyhedra(const Thing& a, const Thing& b, int round) {
    constexpr float kMargin = 0.02F;
    const Manifold m = collide_things(a, b, kMargin);
    const Solid sa(a);
    const Solid sb(b);
    // The gap along the reported normal agrees with the corners; floats are good to 1e-6 m here.
    const Vec3d n = m.normal.cast<double>();
    ASSERT_NEAR(n.norm(), 1.0, 1e-5);
    ASSERT_NEAR(m.separation, gap_along(sa, sb, n), 5e-6) << round;
    // No axis does better by more than the bias that keeps the kind of contact. For overlapping
    // hulls the faces and the crossing arcs are the only axes to check. For separate hulls, one of
    // these axes parts them.
    const double best = best_gap(sa, sb, true);
    ASSERT_LE(m.separation, best + 5e-6) << round;
    ASSERT_GE(m.separation, std::min(best, 0.0) - kEdgeBias - kFaceBias - 5e-6) << round;
    ASSERT_LE(m.count, 4);
    float least = INFINITY;
    for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
        const ManifoldPoint& p = m.points[i];
        least = std::min(least, p.separation);
        // Half a gap away from both surfaces, at most: never farther out than that. The nearest
        // points of edges may lie askew by their distance.
        const double reach = 0.5 * std::abs(p.separation) + 5e-6;
        ASSERT_LE(sa.height(p.point.cast<double>()), reach) << round;
        ASSERT_LE(sb.height(p.point.cast<double>()), reach) << round;
    }
    if (best < 0.0) {
        // Overlapping: there are points, and the deepest gives the depth.
        ASSERT_GE(m.count, 1) << round;
        ASSERT_NEAR(least, m.separation, 1e-5F + kEdgeBias) << round;
    }
}

TEST(CollideHulls, FindTheAxisThatBruteForceFinds) {
    core::Rng rng(31);
    for (int round = 0; round < 1500; ++round) {
        const Thing a = random_hull(rng);
        const Thing b = random_hull(rng);
        check_polyhedra(a, b, round);
    }
}

/// 24 points on a sphere: the balls within such hulls are large, so that most axes are left out.
Thing round_hull(core::Rng& rng) {
    std::vector<Vec3> points;
    while (points.size() < 24) {
        const Vec3 p = random_points(rng, 1, 1.0F).front();
        if (p.norm() > 0.1F && p.norm() < 1.0F) {
            points.push_back(0.4F * p.normalized());
        }
    }
    Thing t{hull_shape(points)};
    t.position = 0.5F * rng.range(0.9F, 1.6F) * (random_rotation(rng) * Vec3::UnitX());
    t.rotation = random_rotation(rng).toRotationMatrix();
    return t;
}

// Without biases (scale 0) the axis is the best of all where hulls overlap: there one of the
// normals of the Minkowski difference is. Hulls that are apart need only be parted. Floats are good
// to 1e-6 m here.
TEST(FindAxes, LeavesOutNoneThatCouldWin) {
    constexpr float kMargin = 0.02F;
    core::Rng rng(33);
    int near = 0;
    int by_edges = 0;
    for (int round = 0; round < 1500; ++round) {
        Thing a = round_hull(rng);
        const Thing b = round % 3 == 0 ? random_hull(rng) : round_hull(rng);
        if (round % 2 == 0) {
            a.position.setZero();
        }
        const MovedHull moved_a(hull_of(a.shape).view(), a.rotation, a.position);
        const MovedHull moved_b(hull_of(b.shape).view(), b.rotation, b.position);
        const HullAxes axes = find_axes(moved_a.view(), moved_b.view(), kMargin, 0.0F);
        const HullAxis& axis = axes.best(0.0F);
        const Solid sa(a);
        const Solid sb(b);
        const double best = best_gap(sa, sb, true);
        ASSERT_LE(axis.separation, best + 5e-6) << round;
        if (best <= 0.0) {
            ASSERT_NEAR(axis.separation, best, 5e-6) << round;
            ++near;
            by_edges += axis.kind == AxisKind::kEdges ? 1 : 0;
        } else {
            ASSERT_GT(axis.separation, -5e-6F) << round;
        }
    }
    EXPECT_GT(near, 300);
    EXPECT_GT(by_edges, 50);
}

TEST(CollideBoxHull, FindTheAxisThatBruteForceFinds) {
    core::Rng rng(32);
    for (int round = 0; round < 1500; ++round) {
        const Thing a = random_box(rng);
        const Thing b = random_hull(rng);
        check_polyhedra(a, b, round);
        check_polyhedra(b, a, round);
    }
}

TEST(CollideHulls, OfBoxesAgreeWithTheTestOfBoxes) {
    core::Rng rng(33);
    for (int round = 0; round < 3000; ++round) {
        const Thing a = random_box(rng);
        const Thing b = random_box(rng);
        Thing ha = a;
        Thing hb = b;
        ha.shape = hull_shape(box_corners(a.shape.half_extents));
        hb.shape = hull_shape(box_corners(b.shape.half_extents));
        // A hull of a box may name the axes as it is turned least: here it does not turn.
        const Manifold boxes = collide_things(a, b);
        const Manifold hulls = collide_things(ha, hb);
        ASSERT_EQ(boxes.separation > 0.02F, hulls.separation > 0.02F) << round;
        if (boxes.separation <= 0.02F) {
            ASSERT_NEAR(boxes.separation, hulls.separation, kEdgeBias + 1e-5F) << round;
            if (boxes.normal.dot(hulls.normal) > 0.9999F) {
                ASSERT_EQ(boxes.count > 0, hulls.count > 0) << round;
            }
        }
    }
}

TEST(CollideHulls, SeeThatCrossedEdgesAreApartWhereFacesAloneSayOverlap) {
    // Two tetrahedra that stand edge across edge: every face axis overlaps, only the cross product
    // of the two edges shows the gap.
    const std::vector<Vec3> ridge{{-1, 0, 0}, {1, 0, 0}, {0, -1, -0.4F}, {0, -1, 0.4F}};
    const std::vector<Vec3> keel{{0, 0, -1}, {0, 0, 1}, {-0.4F, 1, 0}, {0.4F, 1, 0}};
    const BuiltHull lower = *build_hull(ridge);
    const BuiltHull upper = *build_hull(keel);
    Thing a{Shape::hull(lower.hull), lower.frame.position, Mat3(lower.frame.rotation)};
    Thing b{Shape::hull(upper.hull), upper.frame.position, Mat3(upper.frame.rotation)};
    b.position.y() += 0.01F;
    EXPECT_LT(best_gap(Solid(a), Solid(b), false), -0.1);
    const Manifold m = collide_things(a, b);
    EXPECT_NEAR(m.separation, 0.01F, 1e-5F);
    EXPECT_NEAR(m.normal.y(), 1.0F, 1e-5F);
    ASSERT_EQ(m.count, 1);
    EXPECT_LT((m.points[0].point - Vec3(0, 0.005F, 0)).norm(), 1e-5F);
    // A little deeper it is a contact that pushes along that same axis.
    b.position.y() -= 0.03F;
    const Manifold deep = collide_things(a, b);
    EXPECT_NEAR(deep.separation, -0.02F, 1e-5F);
    EXPECT_NEAR(deep.normal.y(), 1.0F, 1e-5F);
}

TEST(CollideHulls, KeepTheNamesOfTheirPointsFromStepToStep) {
    core::Rng rng(34);
    int compared = 0;
    for (int round = 0; round < 500; ++round) {
        const Thing a = random_hull(rng);
        Thing b = random_hull(rng);
        const Manifold first = collide_things(a, b, 0.02F);
        b.position += Vec3(1e-5F, 0, 1e-5F);
        const Manifold second = collide_things(a, b, 0.02F);
        if (first.count != second.count) {
            continue;
        }
        for (std::size_t i = 0; i < static_cast<std::size_t>(first.count); ++i) {
            ++compared;
            EXPECT_EQ(first.points[i].feature, second.points[i].feature) << round;
        }
    }
    EXPECT_GT(compared, 300);
}

/// Distance of a point to a hull, by brute force: over faces, edges and corners.
double distance_to(const Solid& s, const Thing& t, const Vec3d& p) {
    if (s.height(p) <= 0.0) {
        return s.height(p);
    }
    const HullView view = hull_of(t.shape).view();
    double best = 1e9;
    for (int e = 0; e < view.edge_count; ++e) {
        const Vec3d a = s.corners[view.edges[e].from];
        const Vec3d d = s.corners[view.edges[e].to] - a;
        const double at = std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0);
        best = std::min(best, (p - a - at * d).norm());
    }
    for (int f = 0; f < view.face_count; ++f) {
        const Vec3d n = s.normals[static_cast<std::size_t>(f)];
        const double h = n.dot(p) - s.farthest(n);
        const Vec3d foot = p - h * n;
        if (h > 0.0 && s.height(foot) < 2e-6) {
            best = std::min(best, h);
        }
    }
    return best;
}

TEST(CollideSphereHull, FindsTheDistanceThatBruteForceFinds) {
    core::Rng rng(35);
    int inside = 0;
    for (int round = 0; round < 4000; ++round) {
        const Thing hull = random_hull(rng);
        Thing ball = random_hull(rng, 8);
        ball.shape = Shape::sphere(0.2F);
        const Solid solid(hull);
        const double distance = distance_to(solid, hull, ball.position.cast<double>());
        const Manifold m = collide_things(ball, hull, 0.1F);
        if (distance > 0.3) {
            ASSERT_GT(m.separation, 0.1F);
            ASSERT_EQ(m.count, 0);
            continue;
        }
        inside += distance < 0 ? 1 : 0;
        ASSERT_NEAR(m.separation, distance - 0.2, 3e-6) << round;
        ASSERT_EQ(m.count, 1);
        // The point lies halfway between the surfaces, along the normal from the ball's centre.
        const Vec3 expected = ball.position + (0.2F + 0.5F * m.separation) * m.normal;
        ASSERT_LT((m.points[0].point - expected).norm(), 3e-6F);
        if (distance > 0) {
            const Vec3d foot =
                (ball.position + static_cast<float>(distance) * m.normal).cast<double>();
            ASSERT_LT(std::abs(solid.height(foot)), 1e-5) << round;
        }
    }
    EXPECT_GT(inside, 100);
}

TEST(CollideCapsuleHull, FindsTheDistanceThatSamplingFinds) {
    core::Rng rng(36);
    for (int round = 0; round < 1500; ++round) {
        const Thing hull = random_hull(rng);
        Thing capsule = random_hull(rng, 8);
        capsule.shape = Shape::capsule(0.2F, 0.4F);
        const Solid solid(hull);
        double least = 1e9;
        for (int i = 0; i <= 200; ++i) {
            const float t = 0.4F * (static_cast<float>(i) / 100.0F - 1.0F);
            const Vec3 p = capsule.position + t * capsule.rotation.col(1);
            least = std::min(least, distance_to(solid, hull, p.cast<double>()));
        }
        const Manifold m = collide_things(capsule, hull, 0.1F);
        if (least > 1e-3) {
            // Samples are 4 mm apart: the nearest misses the distance d by (2 mm)^2 / 2 d at most
            // where the surface is smooth, by 2 mm where it is not.
            ASSERT_LE(m.separation, least - 0.2 + 5e-6) << round;
            ASSERT_GE(m.separation, least - 0.2 - 2e-3) << round;
        } else if (least < -0.01) {
            // The core cuts the hull: an overlap along a true axis is reported.
            const double reach = 0.4 * std::abs(capsule.rotation.col(1).dot(m.normal));
            const double gap = m.normal.cast<double>().dot(-capsule.position.cast<double>()) -
                               reach - 0.2 - solid.farthest(-m.normal.cast<double>());
            if (m.count == 1) {
                ASSERT_NEAR(m.separation, gap, 5e-6) << round;
            }
            ASSERT_LT(m.separation, -0.2F);
        }
        for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
            ASSERT_LE(solid.height(m.points[i].point.cast<double>()),
                      0.5 * std::abs(m.points[i].separation) + 1e-5)
                << round;
        }
    }
}

TEST(CollideCapsuleHull, LyingOnAFaceTouchesAtBothEnds) {
    Thing box{hull_shape(box_corners(Vec3(2, 0.5F, 2)))};
    Thing capsule{Shape::capsule(0.3F, 0.6F), Vec3(0, 0.79F, 0)};
    capsule.rotation = Mat3(Eigen::AngleAxisf(3.14159265F / 2, Vec3::UnitZ()));
    const Manifold m = collide_things(box, capsule);
    ASSERT_EQ(m.count, 2);
    EXPECT_NEAR(m.normal.y(), 1.0F, 1e-6F);
    EXPECT_NEAR(m.points[0].separation, -0.01F, 1e-5F);
    EXPECT_NEAR(std::abs(m.points[0].point.x() - m.points[1].point.x()), 1.2F, 1e-5F);
}

TEST(CollidePlaneHull, KeepsTheLowestCorners) {
    core::Rng rng(37);
    Thing plane{Shape::plane()};
    for (int round = 0; round < 500; ++round) {
        Thing hull = random_hull(rng);
        hull.position.y() = rng.range(0.0F, 0.8F);
        const Solid solid(hull);
        const Manifold m = collide_things(plane, hull);
        ASSERT_NEAR(m.separation, -solid.farthest(-Vec3d::UnitY()), 1e-6);
        ASSERT_EQ(m.count > 0, m.separation <= 0.02F);
        float least = INFINITY;
        for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
            least = std::min(least, m.points[i].separation);
        }
        if (m.count > 0) {
            ASSERT_NEAR(least, m.separation, 1e-6F);
        }
    }
}

TEST(ClosestPoints, OfHullsAgreeWithTheBestAxis) {
    // Of disjoint hulls no axis shows a larger gap than the distance, and the one along the line of
    // the closest points shows it exactly.
    core::Rng rng(38);
    int apart = 0;
    for (int round = 0; round < 2000; ++round) {
        const Thing a = random_hull(rng);
        const Thing b = random_hull(rng);
        const MovedHull moved(hull_of(b.shape).view(),
                              a.rotation.transpose() * b.rotation,
                              a.placed().to_local(b.position));
        const Closest c =
            closest_points(hull_of(a.shape).view().points, moved.view().points, Vec3::UnitX());
        const Solid sa(a);
        const Solid sb(b);
        const double best = best_gap(sa, sb, true);
        if (c.overlap) {
            ASSERT_LT(best, 1e-6) << round;
            continue;
        }
        ++apart;
        ASSERT_LE(best, c.distance + 1e-6) << round;
        const Vec3d n = a.rotation.cast<double>() * c.normal;
        ASSERT_NEAR(gap_along(sa, sb, n), c.distance, 2e-6) << round;
        ASSERT_NEAR((c.on_b - c.on_a).norm(), c.distance, 1e-9);
    }
    EXPECT_GT(apart, 300);
}

}  // namespace
}  // namespace zoned::physics
