// Pair scenes: soft bodies that meet, and by how much one lies within the other, found apart from
// the server's own search.
#pragma once

#include "tests/unit/soft/soft_test.h"
#include "shared/math/segment_triangle.h"

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace zoned::physics::soft {

/// A soft body as it was defined, with the closed surface that its faces or tetrahedra bound.
struct MeetingBody {
    SoftId id;
    std::vector<SoftFace> surface;  ///< faces of sheets too
    bool closed = false;
    float thickness = 0.0F;
    float mass = 0.0F;
};

inline std::vector<SoftFace> outside_of(const SoftDef& def) {
    if (!def.faces.empty()) {
        return def.faces;
    }
    // Each side of a tetrahedron that no other one has.
    std::map<std::array<std::uint32_t, 3>, std::pair<int, SoftFace>> sides;
    for (const SoftTetrahedron& t : def.tetrahedra) {
        for (std::size_t left_out = 0; left_out < 4; ++left_out) {
            SoftFace face{};
            std::size_t k = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                if (i != left_out) {
                    face[k++] = t[i];
                }
            }
            const Vec3 a = def.nodes[face[0]].position;
            const Vec3 n = (def.nodes[face[1]].position - a).cross(def.nodes[face[2]].position - a);
            if (n.dot(def.nodes[t[left_out]].position - a) > 0.0F) {
                std::swap(face[1], face[2]);
            }
            SoftFace key = face;
            std::sort(key.begin(), key.end());
            auto& side = sides[key];
            ++side.first;
            side.second = face;
        }
    }
    std::vector<SoftFace> outer;
    for (const auto& [key, side] : sides) {
        if (side.first == 1) {
            outer.push_back(side.second);
        }
    }
    return outer;
}

inline MeetingBody put_meeting(SoftBodies& bodies, const SoftDef& def) {
    MeetingBody body;
    body.id = put(bodies, def);
    body.surface = outside_of(def);
    body.closed = !def.tetrahedra.empty() || def.material.gas_pressure > 0.0F;
    body.thickness = def.material.thickness;
    for (const SoftNode& n : def.nodes) {
        body.mass += n.mass;
    }
    return body;
}

inline std::array<Vec3, 3> corners_now(const SoftBodies& bodies,
                                       const MeetingBody& body,
                                       const SoftFace& face) {
    return {bodies.position(body.id, face[0]),
            bodies.position(body.id, face[1]),
            bodies.position(body.id, face[2])};
}

/// How many times the surface winds about the point: the sum of the solid angles of its faces (van
/// Oosterom and Strackee, "The solid angle of a plane triangle", 1983) over 4 pi.
inline double winding(const SoftBodies& bodies, const MeetingBody& body, const Vec3& p) {
    double sum = 0.0;
    for (const SoftFace& f : body.surface) {
        const std::array<Vec3, 3> c = corners_now(bodies, body, f);
        const Vec3d r0 = (c[0] - p).cast<double>();
        const Vec3d r1 = (c[1] - p).cast<double>();
        const Vec3d r2 = (c[2] - p).cast<double>();
        const double l0 = r0.norm();
        const double l1 = r1.norm();
        const double l2 = r2.norm();
        sum += 2.0 * std::atan2(r0.dot(r1.cross(r2)),
                                l0 * l1 * l2 + r0.dot(r1) * l2 + r1.dot(r2) * l0 + r2.dot(r0) * l1);
    }
    return sum / (4.0 * std::numbers::pi);
}

inline float distance_to(const SoftBodies& bodies, const MeetingBody& body, const Vec3& p) {
    float least = INFINITY;
    for (const SoftFace& f : body.surface) {
        least = std::min(least,
                         (p - nearest_on_triangle(corners_now(bodies, body, f), p).point).norm());
    }
    return least;
}

/// Of all nodes of `a` against the surface of `b`: the least distance, negative by the depth of one
/// that lies within it, m.
inline float gap_to(const SoftBodies& bodies, const MeetingBody& a, const MeetingBody& b) {
    float gap = INFINITY;
    const Aabb near = bodies.bounds(b.id).grown(0.2F);
    for (std::size_t i = 0; i < bodies.node_count(a.id); ++i) {
        const Vec3 p = bodies.position(a.id, i);
        if (!b.surface.empty() && near.contains(p)) {
            const float distance = distance_to(bodies, b, p);
            const bool within = b.closed && winding(bodies, b, p) > 0.5;
            gap = std::min(gap, within ? -distance : distance);
        }
    }
    return gap;
}

inline float gap_between(const SoftBodies& bodies, const MeetingBody& a, const MeetingBody& b) {
    return std::min(gap_to(bodies, a, b), gap_to(bodies, b, a));
}

/// The bodies that rest on a plane at height 0 m.
inline void add_floor(Scene& scene) {
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::plane();
    EXPECT_TRUE(scene.add(floor).ok());
}

/// Solved by the method, with its default substeps.
inline SoftDef solved_by(SoftMethod method, SoftDef def) {
    def.solver.method = method;
    return def;
}

inline SoftDef jelly_at(const Vec3& centre, float side = 1.0F, int nodes = 4, float mass = 5.0F) {
    JellyDef def;
    def.centre = centre;
    def.size = Vec3::Constant(side);
    def.nodes = {nodes, nodes, nodes};
    def.mass = mass;
    def.damping_share = 0.4F;
    def.bulk_modulus = 2.0e4F;
    SoftDef out = *build_jelly(def);
    out.material.thickness = 0.02F;
    return out;
}

inline SoftDef balloon_at(const Vec3& centre, int splits = 2, float mass = 1.0F) {
    BalloonDef def;
    def.centre = centre;
    def.splits = splits;
    def.mass = mass;
    def.damping_share = 0.3F;
    def.gas_pressure = 1.033e5F;
    SoftDef out = *build_balloon(def);
    out.material.thickness = 0.02F;
    out.material.drag = 0.5F;
    return out;
}

inline SoftDef sheet_at(const Vec3& corner, int nodes = 15, float side = 2.0F) {
    ClothDef def;
    def.origin = corner;
    def.size_x = def.size_z = side;
    def.nx = def.nz = nodes;
    def.stiffness = 1.0e3F;
    def.shear_stiffness = 500.0F;
    def.bend_stiffness = 5.0F;
    SoftDef out = *build_cloth(def);
    out.material.thickness = 0.02F;
    out.material.drag = 0.5F;
    return out;
}

inline SoftDef rope_at(const Vec3& middle, float length = 3.0F, int nodes = 25) {
    RopeDef def;
    def.from = middle - 0.5F * length * Vec3::UnitX();
    def.to = middle + 0.5F * length * Vec3::UnitX();
    def.nodes = nodes;
    def.stiffness = 5.0e3F;
    def.pin_from = false;
    SoftDef out = *build_rope(def);
    out.material.thickness = 0.03F;
    out.material.drag = 0.5F;
    return out;
}

inline Vec3 centre_of(const SoftBodies& bodies, SoftId id) {
    return bodies.rigid_hull(id).position;
}

inline bool all_finite(const SoftBodies& bodies, SoftId id) {
    for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
        if (!bodies.position(id, i).allFinite() || !bodies.velocity(id, i).allFinite()) {
            return false;
        }
    }
    return true;
}

}  // namespace zoned::physics::soft
