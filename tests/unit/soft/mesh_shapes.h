// Mesh shapes: squares and balls of triangles, and what bodies made of them weigh and look like.
#pragma once

#include "server/physics/soft/builders/mesh_builder.h"
#include "tests/unit/soft/soft_test.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics::soft {

/// A square in the plane z = 0 that hangs from y = 0: n x n vertices, each cell cut in two.
inline MeshBodyDef square_mesh(int n, float size = 2.0F) {
    MeshBodyDef def;
    def.mass = 0.8F;
    const auto index = [n](int i, int j) {
        return static_cast<std::uint32_t>(j * n + i);
    };
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const float cell = size / static_cast<float>(n - 1);
            def.vertices.emplace_back(
                cell * static_cast<float>(i), -cell * static_cast<float>(j), 0.0F);
        }
    }
    for (int j = 0; j + 1 < n; ++j) {
        for (int i = 0; i + 1 < n; ++i) {
            for (const std::uint32_t v : {index(i, j),
                                          index(i, j + 1),
                                          index(i + 1, j),
                                          index(i + 1, j),
                                          index(i, j + 1),
                                          index(i + 1, j + 1)}) {
                def.indices.push_back(v);
            }
        }
    }
    return def;
}

/// The surface of a balloon, faces outward.
inline MeshBodyDef ball_mesh(int splits, const Vec3& centre = Vec3::Zero()) {
    BalloonDef balloon;
    balloon.splits = splits;
    balloon.centre = centre;
    const SoftDef built = *build_balloon(balloon);
    MeshBodyDef def;
    def.mass = balloon.mass;
    def.bend_stiffness = 0.0F;
    for (const SoftNode& node : built.nodes) {
        def.vertices.push_back(node.position);
    }
    for (const SoftFace& face : built.faces) {
        def.indices.insert(def.indices.end(), face.begin(), face.end());
    }
    return def;
}

/// Mass and centre of mass.
inline std::pair<double, Vec3d> weight_of(const SoftDef& def) {
    double mass = 0.0;
    Vec3d centre = Vec3d::Zero();
    for (const SoftNode& node : def.nodes) {
        mass += static_cast<double>(node.mass);
        centre += static_cast<double>(node.mass) * node.position.cast<double>();
    }
    return {mass, centre / mass};
}

/// The same of the sheet itself: each triangle weighs by its area, at its middle.
inline std::pair<double, Vec3d> weight_of(const MeshBodyDef& def) {
    double area = 0.0;
    Vec3d centre = Vec3d::Zero();
    for (std::size_t i = 0; i < def.indices.size(); i += 3) {
        const Vec3d a = def.vertices[def.indices[i]].cast<double>();
        const Vec3d b = def.vertices[def.indices[i + 1]].cast<double>();
        const Vec3d c = def.vertices[def.indices[i + 2]].cast<double>();
        const double part = 0.5 * (b - a).cross(c - a).norm();
        area += part;
        centre += part * (a + b + c) / 3.0;
    }
    return {static_cast<double>(def.mass), centre / area};
}

inline std::vector<Vec3> drawn(const SoftBodies& bodies, SoftId id) {
    std::vector<Vec3> out(bodies.vertex_count(id));
    bodies.vertices(id, out);
    return out;
}

inline SoftDef built_mesh(const MeshBodyDef& def) {
    auto built = build_mesh_body(def);
    EXPECT_TRUE(built.ok()) << (built.ok() ? "" : built.error());
    return built.ok() ? *built : SoftDef();
}

/// Rounding of a weighted sum.
inline float hung_rounding(const SoftVertex& v, const SoftDef& def) {
    float sum = std::abs(v.offset);
    for (std::size_t k = 0; k < 4; ++k) {
        sum += std::abs(v.weight[k]) * def.nodes[v.node[k]].position.norm();
    }
    return 8.0F * std::numeric_limits<float>::epsilon() * sum;
}

inline void expect_drawn_as_the_mesh(const MeshBodyDef& mesh, const SoftDef& built) {
    SoftBodies bodies;
    const std::vector<Vec3> seen = drawn(bodies, put(bodies, built));
    std::size_t found = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const float rounding =
            built.vertices.empty() ? 0.0F : hung_rounding(built.vertices[i], built);
        found += std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) {
            return (v - seen[i]).norm() <= rounding;
        });
    }
    EXPECT_EQ(found, seen.size());
}

}  // namespace zoned::physics::soft
