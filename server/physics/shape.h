// Shape, material and body definitions of the rigid-body engine.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <memory>

namespace zoned::physics {

enum class ShapeKind : std::uint8_t {
    kSphere,
    kBox,
    kCapsule,
    kPlane,
    kHull,
};

inline constexpr std::size_t kShapeKinds = 5;

/// What a few numbers cannot say: built once, never changed, shared by all shapes that use it.
struct Geometry {
    const ShapeKind kind;

    Geometry(const Geometry&) = delete;
    Geometry& operator=(const Geometry&) = delete;

  protected:
    explicit Geometry(ShapeKind k) : kind(k) {}

    ~Geometry() = default;
};

class ConvexHull;

/// Geometry in body coordinates, centred on the body's centre of mass, along its principal axes of
/// inertia.
struct Shape {
    ShapeKind kind = ShapeKind::kSphere;
    Vec3 half_extents = Vec3::Constant(0.5F);  ///< box, m
    float radius = 0.5F;                       ///< sphere, capsule, m
    float half_segment = 0.5F;                 ///< capsule along body y, m
    std::shared_ptr<const Geometry> geometry;  ///< the other kinds
    // A plane is a half-space: solid below the body's local x-z plane, normal +y. Static bodies
    // only.

    static Shape sphere(float radius);
    static Shape box(const Vec3& half_extents);
    static Shape capsule(float radius, float half_segment);
    static Shape plane();
    static Shape hull(std::shared_ptr<const ConvexHull> hull);
};

/// Where a frame lies in another one.
struct Frame {
    Vec3 position = Vec3::Zero();  ///< m
    Quat rotation = Quat::Identity();
};

/// The frame `inner` of `outer` as seen from where `outer` is given.
inline Frame operator*(const Frame& outer, const Frame& inner) {
    return {outer.position + outer.rotation * inner.position, outer.rotation * inner.rotation};
}

/// How a pair's coefficients combine: friction sqrt(a b), restitution max(a, b).
struct Material {
    float friction = 0.5F;
    float restitution = 0.0F;
};

enum class BodyKind : std::uint8_t {
    kStatic,     ///< never moves
    kKinematic,  ///< moves with the velocity that it is given, pushes others, is pushed by nobody
    kDynamic,
};

struct BodyDef {
    BodyKind kind = BodyKind::kDynamic;
    Shape shape;
    Material material;
    float mass = 1.0F;             ///< kg, dynamic only, > 0
    Vec3 position = Vec3::Zero();  ///< centre of mass, m
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();          ///< m/s
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
    std::uint32_t user = 0;  ///< the caller's tag, e.g. an entity id's value; 0 = none
    bool asleep = false;     ///< dynamic: starts asleep
};

}  // namespace zoned::physics
