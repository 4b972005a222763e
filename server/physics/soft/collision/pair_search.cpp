// Finds the nodes of one soft body that may come to faces of another within a step.
#include "server/physics/soft/collision/soft_pairs.h"
#include "shared/math/segment_triangle.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

/// A node's own outward direction tells the side of a face where the two are no more than so far
/// from square to each other (cosine).
constexpr float kFacing = 0.3F;

/// How a body moves: as a whole, and its nodes against that, m/s.
struct SkinMotion {
    Vec3 mean = Vec3::Zero();
    float spread = 0.0F;
};

SkinMotion motion_of(const SoftBody& body) {
    SkinMotion motion;
    if (body.asleep || body.skin.nodes.empty()) {
        return motion;
    }
    for (const std::uint32_t i : body.skin.nodes) {
        motion.mean += body.v[i].head<3>();
    }
    motion.mean /= static_cast<float>(body.skin.nodes.size());
    for (const std::uint32_t i : body.skin.nodes) {
        motion.spread = std::max(motion.spread, (body.v[i].head<3>() - motion.mean).squaredNorm());
    }
    motion.spread = std::sqrt(motion.spread);
    return motion;
}

std::array<Vec3, 3> corners_of(const SoftBody& body, std::uint32_t face) {
    const SoftFace& f = body.skin.faces[face];
    return {body.position(f[0]), body.position(f[1]), body.position(f[2])};
}

Vec3 normal_of(const std::array<Vec3, 3>& c) {
    return (c[1] - c[0]).cross(c[2] - c[0]).normalized();
}

}  // namespace

void PairSearch::run(std::uint32_t body, std::uint32_t other) {
    const SoftBody& a = bodies[body];
    const SoftBody& b = bodies[other];
    const SkinMotion from = motion_of(a);
    const SkinMotion to = motion_of(b);
    const Vec3 way = dt * (from.mean - to.mean);
    const float reach =
        a.material.thickness + b.material.thickness + dt * (from.spread + to.spread) + fall;
    for (const std::uint32_t i : a.skin.nodes) {
        const Vec3 x = a.position(i);
        const Aabb sweep = Aabb{x.cwiseMin(x + way), x.cwiseMax(x + way)}.grown(reach);
        if (!sweep.overlaps(b.box)) {
            continue;
        }
        SkinNode at{body, other, i, static_cast<std::uint32_t>(faces.size()), 0, false};
        at.inside = b.skin.closed && b.box.contains(x) && leave_inside(b, x);
        if (!at.inside) {
            gather(a, b, i, sweep);
        }
        at.end = static_cast<std::uint32_t>(faces.size());
        if (at.end > at.first) {
            nodes.push_back(at);
        }
    }
}

/// Where the nearest face has the node behind it. Of faces that share the nearest point the one
/// that looks straightest at the node decides: the others may show their backs to a node outside.
/// The distance is found first, so that the order in which the tree visits faces decides nothing.
bool PairSearch::leave_inside(const SoftBody& other, const Vec3& x) {
    const float everywhere = (other.box.upper - other.box.lower).norm();
    const auto from_face = [&](std::uint32_t face) {
        return Vec3(x - nearest_on_triangle(corners_of(other, face), x).point);
    };
    const float distance =
        other.skin.tree.nearest(x, everywhere, [&](std::uint32_t face, float limit) {
            return std::min(limit, from_face(face).norm());
        });
    const float reach = distance + 1.0e-5F * (everywhere + distance);
    std::uint32_t nearest = 0;
    float straight = 0.0F;
    other.skin.tree.nearest(x, reach, [&](std::uint32_t face, float limit) {
        const Vec3 d = from_face(face);
        const float height = normal_of(corners_of(other, face)).dot(d);
        const bool straighter = std::abs(height) > std::abs(straight) ||
                                (std::abs(height) == std::abs(straight) && face < nearest);
        if (d.norm() <= reach && straighter) {
            nearest = face;
            straight = height;
        }
        return limit;
    });
    if (straight < 0.0F) {
        faces.push_back({nearest, 1.0F});
        return true;
    }
    return false;
}

void PairSearch::gather(const SoftBody& body,
                        const SoftBody& other,
                        std::uint32_t node,
                        const Aabb& way) {
    const Vec3 x = body.position(node);
    const float thickness = body.material.thickness + other.material.thickness;
    const auto first = static_cast<std::ptrdiff_t>(faces.size());
    other.skin.tree.query(way, [&](std::uint32_t face) {
        if (other.skin.segments) {
            faces.push_back({face, 0.0F});
            return;
        }
        const std::array<Vec3, 3> corner = corners_of(other, face);
        const Vec3 n = normal_of(corner);
        const float height = n.dot(x - corner[0]);
        if (other.skin.closed) {
            if (height > -thickness) {
                faces.push_back({face, 1.0F});
            }
            return;
        }
        float side = height < 0.0F ? -1.0F : 1.0F;
        // A sheet that a closed body has sunk into by less than the distance that they keep belongs
        // outside of it.
        if (body.skin.closed && std::abs(height) < thickness) {
            const float facing = body.skin.normals[node].dot(n);
            side = std::abs(facing) > kFacing ? (facing > 0.0F ? -1.0F : 1.0F) : side;
        }
        faces.push_back({face, side});
    });
    std::sort(faces.begin() + first, faces.end(), [](const NearFace& a, const NearFace& b) {
        return a.face < b.face;
    });
}

}  // namespace zoned::physics::soft
