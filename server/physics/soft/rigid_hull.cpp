#include "server/physics/soft/rigid_hull.h"

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"
#include "server/physics/soft/soft_body.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <limits>
#include <vector>

namespace zoned::physics::soft {

namespace {

/// Directions in which the outermost nodes are looked for: to the points of a lattice on a cube's
/// faces, so many along each half edge.
constexpr int kHalfEdge = 2;

/// The outermost nodes, ascending: of a body with millions of them a few dozen make its hull.
std::vector<std::uint32_t> outermost_nodes(const SoftBody& body) {
    std::vector<std::uint32_t> found;
    for (int x = -kHalfEdge; x <= kHalfEdge; ++x) {
        for (int y = -kHalfEdge; y <= kHalfEdge; ++y) {
            for (int z = -kHalfEdge; z <= kHalfEdge; ++z) {
                if (std::max({std::abs(x), std::abs(y), std::abs(z)}) != kHalfEdge) {
                    continue;
                }
                const Vec3 way(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
                float farthest = -std::numeric_limits<float>::infinity();
                std::uint32_t node = 0;
                for (std::uint32_t i = 0; i < body.x.size(); ++i) {
                    const float along = way.dot(body.x[i].head<3>());
                    if (along > farthest) {
                        farthest = along;
                        node = i;
                    }
                }
                found.push_back(node);
            }
        }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace

RigidHull rigid_hull_of(const SoftBody& body) {
    double mass = 0.0;
    Vec3d centre = Vec3d::Zero();
    Vec3d momentum = Vec3d::Zero();
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        const auto m = static_cast<double>(body.mass[i]);
        mass += m;
        centre += m * body.position(i).cast<double>();
        momentum += m * body.v[i].head<3>().cast<double>();
    }
    centre /= mass;
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Vec3d spin = Vec3d::Zero();
    Vec3d half = Vec3d::Zero();
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        const auto m = static_cast<double>(body.mass[i]);
        const Vec3d r = body.position(i).cast<double>() - centre;
        inertia += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
        spin += m * r.cross(body.v[i].head<3>().cast<double>());
        half = half.cwiseMax(r.cwiseAbs());
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia);
    const auto thickness = static_cast<double>(body.material.thickness);
    const double least = 0.4 * mass * thickness * thickness;
    const Vec3d moments = eigen.eigenvalues().cwiseMax(least);
    const Eigen::Matrix3d axes = eigen.eigenvectors();
    RigidHull hull;
    hull.mass = static_cast<float>(mass);
    hull.position = centre.cast<float>();
    hull.velocity = (momentum / mass).cast<float>();
    hull.angular_velocity = (axes * (axes.transpose() * spin).cwiseQuotient(moments)).cast<float>();
    hull.inertia = (axes * moments.asDiagonal() * axes.transpose()).cast<float>();
    hull.half_extents = half.cast<float>();
    return hull;
}

core::Result<BodyDef> rigid_body_of(const SoftBody& body) {
    using Made = core::Result<BodyDef>;
    const RigidHull hull = rigid_hull_of(body);
    std::vector<Vec3> points;
    for (const std::uint32_t i : outermost_nodes(body)) {
        for (int k = 0; k < 6; ++k) {
            const float side = (k & 1) != 0 ? body.material.thickness : -body.material.thickness;
            points.push_back(body.position(i) - hull.position + side * Vec3::Unit(k / 2));
        }
    }
    const auto around = build_hull(points);
    if (!around) {
        return Made::failure(around.error());
    }
    CompoundPart part;
    part.shape = Shape::hull(around->hull);
    part.frame = around->frame;
    part.material.friction = body.material.friction;
    const auto solid = build_compound({&part, 1}, hull.mass, Vec3::Zero(), hull.inertia);
    if (!solid) {
        return Made::failure(solid.error());
    }
    BodyDef def;
    def.shape = Shape::compound(solid->compound);
    def.material = part.material;
    def.mass = hull.mass;
    def.damping = {body.material.drag, body.material.drag};
    def.position = hull.position;
    def.orientation = solid->frame.rotation;
    def.velocity = hull.velocity;
    def.angular_velocity = hull.angular_velocity;
    def.user = body.user;
    return def;
}

void place_rigid(SoftBody& body,
                 const RigidHull& hull,
                 const Vec3& position,
                 const Quat& turn,
                 const Vec3& velocity,
                 const Vec3& angular_velocity) {
    const Mat3 r = turn.toRotationMatrix();
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        const Vec3 arm = r * (body.position(i) - hull.position);
        body.x[i].head<3>() = position + arm;
        body.v[i].head<3>() = velocity + angular_velocity.cross(arm);
    }
    body.start = body.x;
    body.predicted = body.x;
}

}  // namespace zoned::physics::soft
