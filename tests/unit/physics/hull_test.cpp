// build: computes
#include "server/physics/shapes/convex/hull.h"

#include "server/physics/shapes/compound/inertia.h"
#include "tests/unit/physics/hulls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace zoned::physics {
namespace {

/// Closed, convex, every edge between two faces that run along it in opposite directions.
void expect_sound(const ConvexHull& hull) {
    const HullView view = hull.view();
    EXPECT_EQ(hull.vertex_count() - view.edge_count + view.face_count, 2);
    std::set<std::pair<int, int>> sides;
    int corners = 0;
    for (int f = 0; f < view.face_count; ++f) {
        const HullFace& face = view.faces[f];
        ASSERT_GE(face.corners, 3);
        ASSERT_NEAR(face.normal.norm(), 1.0F, 1e-6F);
        // The hull is about its centre of mass, which lies inside.
        EXPECT_GT(face.offset, 0.0F);
        EXPECT_LE(-lowest(view.points, -face.normal), face.offset + 1e-6F * hull.radius());
        for (int i = 0; i < face.corners; ++i) {
            const int from = view.loops[face.first + i];
            const int to = view.loops[face.first + (i + 1) % face.corners];
            EXPECT_TRUE(sides.emplace(from, to).second);
            ++corners;
            // 1e-5 of the extent (at most twice the radius): the tolerance that merges faces.
            EXPECT_GE(face.normal.dot(view.points[from]), face.offset - 5e-5F * hull.radius());
        }
    }
    EXPECT_EQ(corners, 2 * view.edge_count);
    for (int e = 0; e < view.edge_count; ++e) {
        const HullEdge& edge = view.edges[e];
        EXPECT_EQ(sides.count({edge.from, edge.to}), 1U);
        EXPECT_EQ(sides.count({edge.to, edge.from}), 1U);
        // The left face's loop runs along the edge.
        const HullFace& left = view.faces[edge.left];
        bool found = false;
        for (int i = 0; i < left.corners; ++i) {
            found |= view.loops[left.first + i] == edge.from &&
                     view.loops[left.first + (i + 1) % left.corners] == edge.to;
        }
        EXPECT_TRUE(found);
    }
}

TEST(Hull, OfABoxIsTheBox) {
    const Vec3 half(0.5F, 1.0F, 1.5F);
    std::vector<Vec3> points = box_corners(half);
    const BuiltHull built = *build_hull(points);
    expect_sound(*built.hull);
    EXPECT_EQ(built.hull->vertex_count(), 8);
    EXPECT_EQ(built.hull->view().face_count, 6);
    EXPECT_EQ(built.hull->view().edge_count, 12);
    EXPECT_FLOAT_EQ(built.hull->volume(), 6.0F);
    EXPECT_LT(built.frame.position.norm(), 1e-7F);
    EXPECT_NEAR(built.frame.rotation.w(), 1.0F, 1e-7F);
    const Vec3 box = principal_inertia(Shape::box(half), 1.0F);
    EXPECT_TRUE(built.hull->moments_per_kg().isApprox(box, 1e-6F));
    EXPECT_FLOAT_EQ(built.hull->radius(), half.norm());
}

TEST(Hull, OfATetrahedronHasItsKnownMassProperties) {
    // The corner tetrahedron with legs a, b, c: volume abc/6, centroid at a quarter of each leg.
    const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    const BuiltHull built = *build_hull(points);
    expect_sound(*built.hull);
    EXPECT_FLOAT_EQ(built.hull->volume(), 1.0F);
    EXPECT_LT((built.frame.position - Vec3(0.25F, 0.5F, 0.75F)).norm(), 1e-6F);
    // About the centroid: I_xx = m (b^2 + c^2) 3/80, products m a b / 80.
    Mat3 tensor;
    tensor << 3 * 13, 2, 3, 2, 3 * 10, 6, 3, 6, 3 * 5;
    tensor /= 80.0F;
    const Mat3 r(built.frame.rotation);
    const Mat3 got = rotated_tensor(r, built.hull->moments_per_kg());
    EXPECT_TRUE(got.isApprox(tensor, 1e-6F)) << got << "\n" << tensor;
}

TEST(Hull, ACubeKeepsItsAxesAndEqualMoments) {
    core::Rng rng(3);
    std::vector<Vec3> points = box_corners(Vec3::Constant(0.5F));
    for (Vec3& p : points) {
        p += Vec3(10, 20, 30);
    }
    const BuiltHull built = *build_hull(points);
    EXPECT_NEAR(built.frame.rotation.w(), 1.0F, 1e-7F);
    EXPECT_EQ(built.hull->moments_per_kg().x(), built.hull->moments_per_kg().y());
    EXPECT_EQ(built.hull->moments_per_kg().x(), built.hull->moments_per_kg().z());
}

TEST(Hull, MassPropertiesMatchSamplingOfTheInside) {
    core::Rng rng(17);
    const std::vector<Vec3> points = random_points(rng, 30, 1.0F);
    const BuiltHull built = *build_hull(points);
    const HullView view = built.hull->view();
    const Mat3 r(built.frame.rotation);
    double inside = 0;
    Vec3d mean = Vec3d::Zero();
    Vec3d second = Vec3d::Zero();
    Vec3d mixed = Vec3d::Zero();
    constexpr int kSamples = 400000;
    for (int i = 0; i < kSamples; ++i) {
        const float x = rng.range(-1, 1);
        const float y = rng.range(-1, 1);
        const Vec3 p = r.transpose() * (Vec3(x, y, rng.range(-1, 1)) - built.frame.position);
        bool in = true;
        for (int f = 0; f < view.face_count && in; ++f) {
            in = view.faces[f].normal.dot(p) <= view.faces[f].offset;
        }
        if (in) {
            const Vec3d q = p.cast<double>();
            inside += 1;
            mean += q;
            second += q.cwiseAbs2();
            mixed += Vec3d(q.x() * q.y(), q.y() * q.z(), q.z() * q.x());
        }
    }
    // The standard error of a mean of n = 1e5 samples is about 0.5 / sqrt(n) = 1.6e-3 m, four of
    // them are allowed.
    const double allowed = 4.0 * 0.5 / std::sqrt(inside);
    EXPECT_NEAR(built.hull->volume(), 8.0 * inside / kSamples, 8.0 * 2.0 / std::sqrt(kSamples));
    EXPECT_LT((mean / inside).norm(), 2.0 * allowed);
    const Vec3d s = second / inside;
    const Vec3d moments(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
    EXPECT_LT((moments - built.hull->moments_per_kg().cast<double>()).norm(), 2.0 * allowed);
    // Products of inertia vanish in the principal frame.
    EXPECT_LT((mixed / inside).norm(), 2.0 * allowed);
}

TEST(Hull, HoldsAllPointsWhateverComesIn) {
    core::Rng rng(5);
    for (int round = 0; round < 300; ++round) {
        std::vector<Vec3> points = random_points(rng, 4 + static_cast<int>(rng.below(60)), 1.0F);
        const int style = round % 5;
        for (Vec3& p : points) {
            if (style == 1) {  // on a coarse lattice: many coplanar, collinear and equal points
                p = (2.0F * p).array().round();
            } else if (style == 2) {  // on a sphere
                p.normalize();
            } else if (style == 3) {  // on the faces of a box
                int axis = 0;
                p.cwiseAbs().maxCoeff(&axis);
                p[axis] = std::copysign(1.0F, p[axis]);
            } else if (style == 4) {  // a small thing far away
                p = p + Vec3(1000, 0, 0);
            }
        }
        const Mat3 turn(random_rotation(rng));
        if (style == 3) {
            for (Vec3& p : points) {
                p = turn * p;
            }
        }
        const core::Result<BuiltHull> built = build_hull(points);
        if (!built) {
            continue;  // few lattice points may well lie in a plane
        }
        expect_sound(*built->hull);
        const HullView view = built->hull->view();
        const Mat3 r(built->frame.rotation);
        // Points that are left out stand out by `cut_off`; floats at 1000 m are off by 6e-5 m.
        const float slack = built->cut_off + 3e-5F + (style == 4 ? 2e-4F : 0.0F);
        for (const Vec3& p : points) {
            const Vec3 q = r.transpose() * (p - built->frame.position);
            for (int f = 0; f < view.face_count; ++f) {
                ASSERT_LE(view.faces[f].normal.dot(q), view.faces[f].offset + slack)
                    << round << " " << f;
            }
        }
    }
}

TEST(Hull, MergesCoplanarTrianglesOfATurnedBoxWithPointsAllOverIt) {
    core::Rng rng(11);
    for (int round = 0; round < 20; ++round) {
        std::vector<Vec3> points = box_corners(Vec3(0.5F, 0.7F, 0.3F));
        for (const Vec3& p : random_points(rng, 200, 1.0F)) {
            Vec3 q = p;
            int axis = 0;
            p.cwiseAbs().maxCoeff(&axis);
            q[axis] = std::copysign(1.0F, q[axis]);
            points.push_back(q.cwiseProduct(Vec3(0.5F, 0.7F, 0.3F)));
        }
        const Mat3 turn(random_rotation(rng));
        for (Vec3& p : points) {
            p = turn * p + Vec3(3, 4, 5);
        }
        const BuiltHull built = *build_hull(points);
        expect_sound(*built.hull);
        EXPECT_EQ(built.hull->view().face_count, 6) << round;
        EXPECT_EQ(built.hull->vertex_count(), 8) << round;
        EXPECT_NEAR(built.hull->volume(), 8.0F * 0.5F * 0.7F * 0.3F, 1e-5F);
    }
}

TEST(Hull, StopsAtTheLimitOfCornersAndSaysWhatItCutOff) {
    core::Rng rng(8);
    std::vector<Vec3> points = random_points(rng, 3000, 1.0F);
    for (Vec3& p : points) {
        p.normalize();
    }
    float before = 1.0F;
    for (const int limit : {4, 8, 16, 32, 64}) {
        const BuiltHull built = *build_hull(points, {limit, 0.0F});
        expect_sound(*built.hull);
        EXPECT_LE(built.hull->vertex_count(), limit);
        EXPECT_GT(built.cut_off, 0.0F);
        EXPECT_LT(built.cut_off, before);
        before = built.cut_off;
    }
    // 64 caps on a unit sphere: each covers 4 pi / 64 of it if evenly spread; a cap of that solid
    // angle is 1/32 high. The greedy choice is within a few times that.
    EXPECT_LT(before, 0.12F);
}

TEST(Hull, RefusesWhatHasNoInside) {
    const auto reason = [](const std::vector<Vec3>& points, HullOptions options = {}) {
        const core::Result<BuiltHull> built = build_hull(points, options);
        return built ? std::string() : built.error();
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(reason({}), "hull: fewer than four points");
    EXPECT_EQ(reason({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), "hull: fewer than four points");
    EXPECT_EQ(reason({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}}), "hull: all points are one");
    EXPECT_EQ(reason({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}),
              "hull: all points lie on a line");
    EXPECT_EQ(reason({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 5, 0}}),
              "hull: all points lie in a plane");
    EXPECT_EQ(reason({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.0005F}}).substr(0, 18),
              "hull: thinner than");
    EXPECT_EQ(reason({{0, 0, 0}, {1, nan, 0}, {0, 1, 0}, {1, 1, 1}}),
              "hull: point 1 is not finite or out of range");
    EXPECT_EQ(reason({{0, 0, 0}, {INFINITY, 0, 0}, {0, 1, 0}, {1, 1, 1}}),
              "hull: point 1 is not finite or out of range");
    EXPECT_EQ(reason({{0, 0, 0}, {9e5F, 0, 0}, {0, 1, 0}, {1, 1, 1}}).substr(0, 17),
              "hull: larger than");
    EXPECT_EQ(reason(std::vector<Vec3>(kMaxHullPoints + 1, Vec3::Zero())).substr(0, 15),
              "hull: more than");
    EXPECT_EQ(reason(box_corners(Vec3::Ones()), {65, 0.0F}).substr(0, 19), "hull: max_vertices ");
    EXPECT_EQ(reason(box_corners(Vec3::Ones()), {64, -1.0F}), "hull: tolerance out of range");
}

TEST(Hull, SurvivesGarbage) {
    // Bits as they come: nothing but a result or a reason may come out.
    core::Rng rng(23);
    for (int round = 0; round < 300; ++round) {
        std::vector<Vec3> points;
        const std::uint32_t count = rng.below(40);
        for (std::uint32_t i = 0; i < count; ++i) {
            Vec3 p;
            for (int k = 0; k < 3; ++k) {
                const float wide =
                    std::ldexp(rng.range(-1, 1), static_cast<int>(rng.below(60)) - 40);
                p[k] = round % 3 == 0 ? wide : std::round(rng.range(-2, 2)) * 0.001F;
            }
            points.push_back(p);
        }
        const core::Result<BuiltHull> built = build_hull(points);
        if (built) {
            expect_sound(*built->hull);
        } else {
            EXPECT_FALSE(built.error().empty());
        }
    }
}

TEST(BoxHull, IsThatOfTheBoxsCorners) {
    const Vec3 half(0.5F, 1.0F, 1.5F);
    const BoxHull box(half);
    const HullView view = box.view();
    for (int e = 0; e < view.edge_count; ++e) {
        const HullEdge& edge = view.edges[e];
        const Vec3 d = view.points[edge.to] - view.points[edge.from];
        // The left face lies to the left: its normal and the right one's make up the direction.
        const Vec3 turn = view.faces[edge.left].normal.cross(view.faces[edge.right].normal);
        EXPECT_GT(turn.dot(d), 0.0F) << e;
    }
    for (int f = 0; f < view.face_count; ++f) {
        for (int i = 0; i < 4; ++i) {
            EXPECT_FLOAT_EQ(view.faces[f].normal.dot(view.corner(view.faces[f], i)),
                            view.faces[f].offset);
        }
    }
    const BuiltHull built = *build_hull(box_corners(half));
    const HullView same = built.hull->view();
    for (int e = 0; e < same.edge_count; ++e) {
        const HullEdge& edge = same.edges[e];
        const Vec3 turn = same.faces[edge.left].normal.cross(same.faces[edge.right].normal);
        EXPECT_GT(turn.dot(same.points[edge.to] - same.points[edge.from]), 0.0F) << e;
    }
}

}  // namespace
}  // namespace zoned::physics
