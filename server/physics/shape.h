// Shape, material and body definitions of the rigid-body engine.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>

namespace zoned::physics {

enum class ShapeKind : std::uint8_t {
    kSphere,
    kBox,
    kCapsule,
    kPlane
};

/// Geometry in body coordinates, centred on the body's centre of mass.
struct Shape {
    ShapeKind kind = ShapeKind::kSphere;
    Vec3 half_extents = Vec3::Constant(0.5F);  ///< box, m
    float radius = 0.5F;                       ///< sphere, capsule, m
    float half_segment = 0.5F;                 ///< capsule along body y, m
    // A plane is a half-space: solid below the body's local x-z plane, normal +y. Static bodies
    // only.

    static Shape sphere(float radius);
    static Shape box(const Vec3& half_extents);
    static Shape capsule(float radius, float half_segment);
    static Shape plane();
};

/// How a pair's coefficients combine: friction sqrt(a b), restitution max(a, b).
struct Material {
    float friction = 0.5F;
    float restitution = 0.0F;
};

/// Two bodies collide when each one's mask holds a bit of the other's category.
struct Filter {
    std::uint32_t category = 1;
    std::uint32_t mask = 0xFFFFFFFFU;
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
    Filter filter;
    float mass = 1.0F;             ///< kg, dynamic only, > 0
    Vec3 position = Vec3::Zero();  ///< centre of mass, m
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();          ///< m/s
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
    std::uint32_t user = 0;  ///< the caller's tag, e.g. an entity id's value; 0 = none
    bool asleep = false;     ///< dynamic: starts asleep
};

}  // namespace zoned::physics
