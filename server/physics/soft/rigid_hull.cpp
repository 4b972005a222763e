#include "server/physics/soft/rigid_hull.h"

#include "server/physics/soft/soft_body.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace zoned::physics::soft {

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
    const double least = std::max(1.0e-6 * eigen.eigenvalues().maxCoeff(), 1.0e-12);
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
