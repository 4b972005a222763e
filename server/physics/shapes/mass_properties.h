// Mass properties: volume, centre of mass, inertia and principal axes of solids, in double.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"

#include <span>
#include <string>

namespace zoned::physics {

using Mat3d = Eigen::Matrix3d;

/// Of a solid of mass `mass`: its tensor is about its centre, along the axes that it is given in.
struct MassProperties {
    double mass = 0.0;              ///< kg; the volume in m3 for density 1
    Vec3d centre = Vec3d::Zero();   ///< m
    Mat3d inertia = Mat3d::Zero();  ///< kg m2
};

/// Adds up the integrals over tetrahedra from a common apex, one for each triangle of a closed
/// surface: the divergence theorem (Mirtich, "Fast and accurate computation of polyhedral mass
/// properties", J. Graphics Tools 1(2), 1996), with the covariance of the canonical tetrahedron
/// (Blow and Binstock, "How to find the inertia tensor", 2004). Exact up to rounding.
class SurfaceIntegral {
  public:
    /// The nearer the apex is to the surface, the fewer digits cancel.
    explicit SurfaceIntegral(const Vec3d& apex) : apex_(apex) {}

    /// A triangle of the surface, counter-clockwise seen from outside.
    void add(const Vec3d& a, const Vec3d& b, const Vec3d& c);
    /// Of the solid of density 1. The mass is negative when the surface is inside out.
    [[nodiscard]] MassProperties result() const;

  private:
    Vec3d apex_;
    double volume_ = 0.0;
    Vec3d first_ = Vec3d::Zero();   // integral of x
    Mat3d second_ = Mat3d::Zero();  // integral of x x^T
};

/// Of several solids taken together: the centre is the mean, the tensors are summed by the parallel
/// axis theorem. Massless parts count for nothing.
MassProperties sum_of(std::span<const MassProperties> parts);

/// The same solid in other axes: x becomes rotation * x + position.
MassProperties moved(const MassProperties& solid, const Mat3d& rotation, const Vec3d& position);

/// Principal moments and axes of a tensor.
struct PrincipalAxes {
    Vec3d moments = Vec3d::Zero();
    /// From principal axes into those of the tensor. The axes can be named in 24 ways; this one
    /// turns least. A tensor that is diagonal already keeps its axes.
    Mat3d rotation = Mat3d::Identity();
};

/// Three numbers as text, for reasons.
std::string listed(const Vec3d& v);

/// Symmetry and the sum of two moments may be off by 1e-5 of the trace, for the rounding of floats.
/// Fails with the reason when the tensor is not finite, not symmetric, not positive, or one moment
/// exceeds the sum of the other two, which no distribution of mass can have.
core::Result<PrincipalAxes> principal_axes(const Mat3d& tensor);

}  // namespace zoned::physics
