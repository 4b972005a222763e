// build: computes
// Meshes and heightfields: how they are built, and the contacts that bodies have with them.
#include "server/physics/narrowphase/collide_triangle.h"
#include "server/physics/narrowphase/contact_set.h"
#include "server/physics/query/shape_ray.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace zoned::physics {
namespace {

float rough(float x, float z) {
    return 0.5F * std::sin(1.3F * x + 0.2F) * std::cos(1.7F * z);
}

TEST(Mesh, KnowsHowItBendsAtEachEdge) {
    // A roof along z: two slopes of 45 degrees, convex at the ridge; and the same as a valley.
    for (const float up : {1.0F, -1.0F}) {
        MeshInput in;
        const Vec3 a(0, 0, -1);
        const Vec3 b(0, 0, 1);
        in.add(a, Vec3(-1, -up, 0), b);
        in.add(a, b, Vec3(1, -up, 0));
        const BuiltMesh built = *build_mesh(in.vertices, in.indices);
        EXPECT_EQ(built.open_edges, 4U);
        EXPECT_EQ(built.degenerate + built.shared_edges + built.turned_edges, 0U);
        const Triangle left = built.mesh->triangle(0);
        const Triangle right = built.mesh->triangle(1);
        EXPECT_GT(left.normal.y(), 0.7F);
        const EdgeBend bend = left.bend[2];
        EXPECT_NEAR(std::atan2(bend.sine, bend.cosine), up > 0 ? 1.5707963F : 0.0F, 1e-5F);
        EXPECT_NEAR(std::atan2(right.bend[0].sine, right.bend[0].cosine),
                    up > 0 ? 1.5707963F : 0.0F,
                    1e-5F);
        EXPECT_EQ(left.bend[0].sine, 1.0F);
    }
}

TEST(Mesh, CountsWhatIsOddAndRefusesWhatIsBroken) {
    MeshInput in;
    in.add({0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    in.add({0, 0, 0}, {1, 0, 0}, {2, 0, 0});   // no area
    in.add({0, 0, 0}, {1, 0, 0}, {1, 0, 0});   // two equal corners
    in.add({0, 0, 0}, {0, 0, 1}, {-1, 0, 0});  // faces the other side at a shared edge
    in.add({1, 0, 0}, {0, 0, 1}, {1, 1, 1});
    in.add({1, 0, 0}, {0, 0, 1}, {1, -1, 1});  // the third triangle at an edge
    const BuiltMesh built = *build_mesh(in.vertices, in.indices);
    EXPECT_EQ(built.degenerate, 2U);
    EXPECT_EQ(built.turned_edges, 1U);
    EXPECT_EQ(built.shared_edges, 1U);
    EXPECT_EQ(built.mesh->triangle_count(), 4U);
    // Of 18 corners 6 are places; (2, 0, 0) is named by a triangle without area only.
    EXPECT_EQ(built.merged, 18U - 7U);
    EXPECT_EQ(built.unused, 0U);
    EXPECT_EQ(built.mesh->tables().vertices.size(), 6U);
    EXPECT_EQ(built.first_degenerate, 1U);
    EXPECT_EQ(built.first_turned, (std::array<std::uint32_t, 2>{0, 1}));
    EXPECT_EQ(built.first_shared, (std::array<std::uint32_t, 2>{1, 2}));
    const auto reason = [](std::vector<Vec3> vertices,
                           std::vector<std::uint32_t> indices,
                           MeshOptions options = {}) {
        const auto mesh = build_mesh(vertices, indices, options);
        return mesh ? std::string() : mesh.error();
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(reason({{0, 0, 0}, {0, 0, 1}, {1, nan, 0}}, {0, 1, 2}),
              "mesh: vertex 2 is not finite or out of range");
    EXPECT_EQ(reason({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}, {0, 1, 3}),
              "mesh: index 2 names no vertex");
    EXPECT_EQ(reason({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}, {0, 1}),
              "mesh: the number of indices is no multiple of three");
    EXPECT_EQ(reason({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, {0, 1, 2}),
              "mesh: no triangle has an area");
    std::vector<Vec3> fan = {{0, 0, 0}, {0, 1, 0}};
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t i = 0; i <= kMaxEdgeTriangles; ++i) {
        const float angle = 0.05F * static_cast<float>(i);
        fan.emplace_back(std::cos(angle), 0.0F, std::sin(angle));
        leaves.insert(leaves.end(), {0, 1, i + 2});
    }
    EXPECT_EQ(reason(fan, leaves), "mesh: more than 64 triangles at the edge of vertices 0 and 1");
    leaves.resize(3 * kMaxEdgeTriangles);
    EXPECT_EQ(reason(fan, leaves), "");
    EXPECT_EQ(reason({}, {}), "mesh: no triangle has an area");
    EXPECT_EQ(reason({{0, 0, 0}}, {}, {nan}), "mesh: weld out of range");
}

TEST(Mesh, LeavesOutWhatIsThereAlready) {
    MeshInput in;
    in.add({0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    in.add({0, 0, 0}, {1, 0, 0}, {0, 0, 1});  // its back: another one
    for (int i = 0; i < 100000; ++i) {
        in.add({1, 0, 0}, {0, 0, 0}, {0, 0, 1});
    }
    const BuiltMesh built = *build_mesh(in.vertices, in.indices);
    EXPECT_EQ(built.repeated, 100000U);
    EXPECT_EQ(built.first_repeated, 2U);
    EXPECT_EQ(built.mesh->triangle_count(), 2U);
    EXPECT_EQ(built.open_edges + built.turned_edges + built.shared_edges, 0U);
}

TEST(Mesh, WeldsWhatLiesNear) {
    MeshInput in = grid_mesh(10, 0.5F, rough);
    core::Rng rng(81);
    for (Vec3& v : in.vertices) {
        v += 1.0e-4F * random_points(rng, 1, 1.0F)[0];
    }
    const BuiltMesh apart = *build_mesh(in.vertices, in.indices);
    EXPECT_EQ(apart.open_edges, 600U);
    const BuiltMesh welded = *build_mesh(in.vertices, in.indices, {1.0e-3F});
    EXPECT_EQ(welded.open_edges, 40U);
}

TEST(Mesh, TreeFindsWhatLookingAtAllFinds) {
    core::Rng rng(82);
    MeshInput in;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 at = random_points(rng, 1, 10.0F)[0];
        const std::vector<Vec3> p = random_points(rng, 3, i % 50 == 0 ? 5.0F : 0.5F);
        in.add(at + p[0], at + p[1], at + p[2]);
    }
    const BuiltMesh built = *build_mesh(in.vertices, in.indices);
    const TriangleMesh& mesh = *built.mesh;
    for (int round = 0; round < 200; ++round) {
        const Vec3 lower = random_points(rng, 1, 10.0F)[0];
        const Aabb area{lower, lower + Vec3::Constant(rng.range(0.0F, 4.0F))};
        std::vector<std::uint32_t> found;
        mesh.tree().query(area, [&](std::uint32_t i) { found.push_back(i); });
        std::sort(found.begin(), found.end());
        EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Triangle t = mesh.triangle(i);
            const Aabb box{t.corner[0].cwiseMin(t.corner[1]).cwiseMin(t.corner[2]),
                           t.corner[0].cwiseMax(t.corner[1]).cwiseMax(t.corner[2])};
            if (box.overlaps(area)) {
                ASSERT_TRUE(std::binary_search(found.begin(), found.end(), i));
            }
        }
    }
}

TEST(Heightfield, HasTheTrianglesOfItsSamples) {
    const Shape shape = field_shape(9, 0.5F, rough);
    const Heightfield& field = field_of(shape);
    for (std::uint32_t k = 0; k < 8; ++k) {
        for (std::uint32_t i = 0; i < 8; ++i) {
            for (std::uint32_t half = 0; half < 2; ++half) {
                const Triangle t = field.triangle(i, k, half);
                EXPECT_GT(t.normal.y(), 0.0F);
                EXPECT_EQ(t.id, 2 * (8 * k + i) + half);
                for (const Vec3& c : t.corner) {
                    EXPECT_NEAR(c.y(), rough(c.x(), c.z()), 1e-6F);
                }
                const Vec3 middle = (t.corner[0] + t.corner[1] + t.corner[2]) / 3.0F;
                Triangle at;
                ASSERT_TRUE(field.triangle_at(middle + Vec3(0, 5, 0), at));
                EXPECT_EQ(at.id, t.id);
            }
        }
    }
    Triangle none;
    EXPECT_FALSE(field.triangle_at(Vec3(2.1F, 0, 0), none));
    EXPECT_FALSE(field.triangle_at(Vec3(NAN, 0, 0), none));
}

TEST(Heightfield, BendsLikeTheMeshOfTheSameTriangles) {
    const Shape shape = field_shape(9, 0.5F, rough);
    const Heightfield& field = field_of(shape);
    MeshInput in;
    std::vector<Triangle> triangles;
    for (std::uint32_t k = 0; k < 8; ++k) {
        for (std::uint32_t i = 0; i < 8; ++i) {
            for (std::uint32_t half = 0; half < 2; ++half) {
                triangles.push_back(field.triangle(i, k, half));
                const auto& c = triangles.back().corner;
                in.add(c[0], c[1], c[2]);
            }
        }
    }
    const BuiltMesh built = *build_mesh(in.vertices, in.indices);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        const Triangle t = built.mesh->triangle(i);
        for (std::size_t e = 0; e < 3; ++e) {
            EXPECT_NEAR(t.bend[e].sine, triangles[i].bend[e].sine, 1e-6F) << i << " " << e;
            EXPECT_NEAR(t.bend[e].cosine, triangles[i].bend[e].cosine, 1e-6F);
        }
    }
}

TEST(Heightfield, RefusesWhatIsNoGrid) {
    const auto reason = [](std::size_t samples, const FieldOptions& options, float value = 1.0F) {
        const auto field = build_heightfield(std::vector<float>(samples, value), options);
        return field ? std::string() : field.error();
    };
    FieldOptions two;
    two.columns = 2;
    two.rows = 2;
    EXPECT_EQ(reason(4, two), "");
    EXPECT_EQ(reason(5, two), "heightfield: has 5 samples instead of columns times rows");
    EXPECT_EQ(reason(4, two, NAN), "heightfield: sample 0 of row 0 is not finite or out of range");
    EXPECT_EQ(reason(4, two, 1e30F),
              "heightfield: sample 0 of row 0 is not finite or out of range");
    FieldOptions flat = two;
    flat.spacing_x = 0.0F;
    EXPECT_EQ(reason(4, flat), "heightfield: spacing out of range");
    FieldOptions thin = two;
    thin.rows = 1;
    EXPECT_EQ(reason(2, thin).substr(0, 30), "heightfield: columns and rows ");
    FieldOptions wide = two;
    wide.columns = 0xFFFFFFFFU;
    wide.rows = 0xFFFFFFFFU;
    EXPECT_EQ(reason(1, wide).substr(0, 30), "heightfield: columns and rows ");
}

/// The nearest front hit over all triangles, by the plane and the three edges.
bool cast_all(const std::vector<Triangle>& triangles, const Vec3& o, const Vec3& d, float& t) {
    bool hit = false;
    t = 1e9F;
    for (const Triangle& triangle : triangles) {
        const double rate = triangle.normal.cast<double>().dot(d.cast<double>());
        const double height = triangle.normal.cast<double>().dot(o.cast<double>() -
                                                                 triangle.corner[0].cast<double>());
        if (rate >= 0 || height < 0) {
            continue;
        }
        const double at = -height / rate;
        const Vec3d p = o.cast<double>() + at * d.cast<double>();
        bool inside = true;
        for (std::size_t e = 0; e < 3; ++e) {
            inside &= triangle.outward(e).cast<double>().dot(
                          p - triangle.corner[e].cast<double>()) < 1e-6;
        }
        if (inside && at < t) {
            t = static_cast<float>(at);
            hit = true;
        }
    }
    return hit;
}

TEST(CastRay, HitsSurfacesWhereLookingAtAllTrianglesHits) {
    core::Rng rng(83);
    const MeshInput in = grid_mesh(12, 0.5F, rough);
    const Shape mesh = mesh_shape(in);
    const Shape field = field_shape(13, 0.5F, rough);
    for (const Shape& shape : {mesh, field}) {
        std::vector<Triangle> triangles;
        const bool is_mesh = shape.kind == ShapeKind::kMesh;
        for (std::uint32_t i = 0; i < 288; ++i) {
            triangles.push_back(is_mesh ? mesh_of(shape).triangle(i)
                                        : field_of(shape).triangle(i / 2 % 12, i / 24, i % 2));
        }
        int hits = 0;
        for (int round = 0; round < 3000; ++round) {
            Vec3 o = random_points(rng, 1, 4.0F)[0];
            Vec3 d = (random_points(rng, 1, 3.0F)[0].cwiseProduct(Vec3(1, 0.1F, 1)) - o);
            d.normalize();
            if (round % 7 == 0) {
                d = -Vec3::UnitY();  // down a column, often along a line of the grid
                o.x() = 0.5F * std::round(2.0F * o.x());
            }
            float expected = 0.0F;
            float t = 0.0F;
            Vec3 n;
            const bool hit = cast_all(triangles, o, d, expected);
            ASSERT_EQ(cast_ray({shape, Vec3::Zero(), Mat3::Identity()}, o, d, 100.0F, t, n), hit)
                << round << " mesh " << is_mesh << " from " << o.transpose();
            if (hit) {
                ++hits;
                ASSERT_LT(n.dot(d), 0.0F);
                // A float normal shifts the plane by up to 1e-6 m, seen under the ray's angle.
                ASSERT_NEAR(t, expected, 1e-6F - 1e-6F / n.dot(d)) << round;
                EXPECT_FALSE(cast_ray(
                    {shape, Vec3::Zero(), Mat3::Identity()}, o, d, expected - 1e-3F, t, n));
            }
        }
        EXPECT_GT(hits, 800);
    }
}

/// Distance from a point to the nearest triangle.
float distance_to(const Heightfield& field, const Vec3& p) {
    float least = INFINITY;
    const Heightfield::HeightfieldCells cells = field.cells_over(Aabb{p, p}.grown(2.0F));
    for (std::uint32_t k = cells.first_k; k < cells.last_k; ++k) {
        for (std::uint32_t i = cells.first_i; i < cells.last_i; ++i) {
            for (std::uint32_t half = 0; half < 2; ++half) {
                least = std::min(
                    least,
                    (nearest_on_triangle(field.triangle(i, k, half).corner, p).point - p).norm());
            }
        }
    }
    return least;
}

TEST(CollideSurface, FindsTheDistanceOfASphereToTheWholeSurface) {
    // Whatever edges are filtered: the least gap of all contacts is the distance to the surface.
    core::Rng rng(84);
    const Shape shape = field_shape(21, 0.5F, [](float x, float z) { return 2.0F * rough(x, z); });
    const Heightfield& field = field_of(shape);
    const Shape ball = Shape::sphere(0.3F);
    ContactSet set;
    int contacts = 0;
    for (int round = 0; round < 5000; ++round) {
        Vec3 p = random_points(rng, 1, 4.0F)[0];
        p.y() = 2.0F * rough(p.x(), p.z()) + rng.range(0.05F, 0.45F);
        const float distance = distance_to(field, p);
        Triangle under;
        if (!field.triangle_at(p, under) || under.height(p) <= 0.0F) {
            continue;
        }
        set.collide({ball, p, Mat3::Identity()},
                    {shape, Vec3::Zero(), Mat3::Identity()},
                    {0.02F, Vec3::Zero(), 0.0F});
        float least = INFINITY;
        for (const PartManifold& m : set.manifolds()) {
            ++contacts;
            EXPECT_LT(m.manifold.normal.y(), 0.1F);  // from the ball to the ground
            for (std::size_t i = 0; i < static_cast<std::size_t>(m.manifold.count); ++i) {
                least = std::min(least, m.manifold.points[i].separation);
            }
        }
        if (distance - 0.3F <= 0.0199F) {
            ASSERT_NEAR(least, distance - 0.3F, 2e-4F) << round << " at " << p.transpose();
        } else if (distance - 0.3F > 0.0201F) {
            ASSERT_EQ(least, INFINITY) << round;
        }
    }
    EXPECT_GT(contacts, 1000);
}

TEST(CollideSurface, GivesABoxOnAFloorOfTrianglesOneManifoldOfFourPoints) {
    core::Rng rng(85);
    const Shape floor = mesh_shape(grid_mesh(40, 0.25F, [](float, float) { return 0.0F; }));
    const Shape box = Shape::box(Vec3(0.5F, 0.25F, 0.4F));
    const Shape hull = hull_shape(box_corners(Vec3(0.5F, 0.25F, 0.4F)));
    ContactSet set;
    for (int round = 0; round < 500; ++round) {
        const float x = rng.range(-3, 3);
        const Vec3 p(x, 0.249F, rng.range(-3, 3));
        const Mat3 turn(Eigen::AngleAxisf(rng.range(0, 6), Vec3::UnitY()));
        for (const Shape& shape : {box, hull}) {
            set.collide({floor, Vec3::Zero(), Mat3::Identity()},
                        {shape, p, turn},
                        {0.02F, Vec3::Zero(), 0.0F});
            ASSERT_EQ(set.manifolds().size(), 1U) << round;
            const Manifold& m = set.manifolds()[0].manifold;
            ASSERT_EQ(m.count, 4);
            EXPECT_NEAR(m.normal.y(), 1.0F, 1e-6F);
            // They span the box's base nearly whole.
            float area = 0.0F;
            for (std::size_t i = 0; i < 4; ++i) {
                EXPECT_NEAR(m.points[i].separation, -0.001F, 1e-5F);
                for (std::size_t k = 0; k < 4; ++k) {
                    area = std::max(area, (m.points[i].point - m.points[k].point).norm());
                }
            }
            EXPECT_GT(area, 1.2F);  // of a diagonal of 1.28 m
        }
    }
}

}  // namespace
}  // namespace zoned::physics
