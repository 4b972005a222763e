// ConvexCore: a convex shape as corners and a radius, and the distance between two of them.
#pragma once

#include "server/physics/narrowphase/collide.h"
#include "server/physics/shapes/convex/hull_view.h"
#include "server/physics/shapes/surface.h"

#include <array>

namespace zoned::physics {

/// All points within `radius` of the hull of some corners: a sphere is one corner with a radius, a
/// capsule two, a box eight corners with none. Corners are floats about an origin in doubles, along
/// world axes, so that far from the world's origin nothing is lost.
class ConvexCore {
  public:
    /// Sphere, box, capsule or hull, its surface moved in by up to `inset` metres.
    explicit ConvexCore(const Placed& shape, float inset = 0.0F);
    /// A triangle in the frame of a surface.
    ConvexCore(const Triangle& triangle, const Placed& surface);
    explicit ConvexCore(const Vec3& point);

    [[nodiscard]] const Vec3d& origin() const { return origin_; }

    [[nodiscard]] double radius() const { return radius_; }

    /// Greatest distance of a corner from the origin along an axis, m.
    [[nodiscard]] float extent() const { return extent_; }

    [[nodiscard]] PointsView points() const { return {x_.data(), y_.data(), z_.data(), count_}; }

    /// The same corners, moved by `shift`.
    [[nodiscard]] ConvexCore moved(const Vec3d& shift) const;

    /// The corner that lies farthest along a direction, world coordinates; the middle of those that
    /// lie as far.
    [[nodiscard]] Vec3d farthest(const Vec3& direction) const;

  private:
    ConvexCore() = default;

    void add(const Vec3& corner);
    void pad();

    // Without initialisers: most shapes have few corners.
    std::array<float, kMaxHullVertices> x_;
    std::array<float, kMaxHullVertices> y_;
    std::array<float, kMaxHullVertices> z_;
    int count_ = 0;
    float extent_ = 0.0F;
    double radius_ = 0.0;
    Vec3d origin_ = Vec3d::Zero();
};

/// How far a core `a`, moved by `shift`, is from a core `b`.
struct CoreGap {
    /// m; zero or less: they overlap. Below -(radius of a + radius of b) nothing is known but that.
    double gap = 0.0;
    bool deep = false;              ///< the corners' hulls overlap: normal and point mean nothing
    Vec3d normal = Vec3d::UnitY();  ///< unit, from b to a
    Vec3d point = Vec3d::Zero();    ///< on the surface of b, world
};

CoreGap gap_between(const ConvexCore& a, const Vec3d& shift, const ConvexCore& b);

struct CastHit {
    float distance = 0.0F;
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitY();
};

/// Shapes that overlap by up to this only touch, m: bodies that rest on each other do.
inline constexpr float kGraze = 0.005F;

/// Moves core `a` along `direction` (unit) until it touches `b`; false when it does not within
/// `limit` metres. `inner` is the same shape, kGraze smaller. Where `inner` is clear of b at the
/// start, the two only touch. Then a is held if it moves towards b, and not held if it slides along
/// b or leaves it.
///
/// The gap of two convex sets is a convex function of the distance moved, so Newton's method from
/// the near side never passes the root (conservative advancement: Mirtich, PhD thesis, Berkeley
/// 1996).
bool cast_core(const ConvexCore& a,
               const ConvexCore& inner,
               const Vec3& direction,
               float limit,
               const ConvexCore& b,
               CastHit& hit);

/// The part of `direction` (unit) towards a surface that counts as sliding along it.
inline constexpr double kSliding = 1.0e-5;

}  // namespace zoned::physics
