// Shape, material and body definitions of the rigid-body engine.
#pragma once

#include "server/physics/shapes/material.h"
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
    kMesh,
    kHeightfield,
    kCompound,
};

/// Kinds up to kHull are convex: the contact of two of them is one manifold.
inline constexpr std::size_t kConvexKinds = 5;

inline bool is_convex(ShapeKind kind) {
    return static_cast<std::size_t>(kind) < kConvexKinds;
}

/// A form that a few numbers cannot say: built once, never changed, shared by all shapes that use
/// it.
struct Geometry {
    const ShapeKind kind;

    Geometry(const Geometry&) = delete;
    Geometry& operator=(const Geometry&) = delete;

  protected:
    explicit Geometry(ShapeKind k) : kind(k) {}

    ~Geometry() = default;
};

class ConvexHull;
class TriangleMesh;
class Heightfield;
class Compound;

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
    static Shape mesh(std::shared_ptr<const TriangleMesh> mesh);         ///< static bodies only
    static Shape heightfield(std::shared_ptr<const Heightfield> field);  ///< static bodies only
    static Shape compound(std::shared_ptr<const Compound> compound);
};

/// Where a frame lies in another one.
struct Frame {
    Vec3 position = Vec3::Zero();  ///< m
    Quat rotation = Quat::Identity();
};

/// Share of its speed that a body loses per second at low rates: v' = -c v, 1/s.
struct Damping {
    float linear = 0.0F;
    float angular = 0.0F;
};

/// The frame `inner` of `outer` as seen from where `outer` is given.
inline Frame operator*(const Frame& outer, const Frame& inner) {
    return {outer.position + outer.rotation * inner.position, outer.rotation * inner.rotation};
}

enum class BodyKind : std::uint8_t {
    kStatic,     ///< never moves
    kKinematic,  ///< moves with the velocity that it is given, pushes others, is pushed by nobody
    kDynamic,
    kParticle,  ///< a point with a mass, see scene_particles.cpp; cheap by the thousand
};

/// The contacts of a body that are events besides those of PhysicsSettings; a sum of these. A pair
/// reports the events that either of its bodies asks for. No contact ends or lasts while the bodies
/// sleep.
inline constexpr std::uint8_t kTellBegin = 1;    ///< also without a tag
inline constexpr std::uint8_t kTellPersist = 2;  ///< in each step after the first
inline constexpr std::uint8_t kTellEnd = 4;      ///< also by removal, teleport or a new joint

struct BodyDef {
    BodyKind kind = BodyKind::kDynamic;
    Shape shape;
    Material material;  ///< of compounds the parts' own count
    Filter filter;
    Damping damping;
    bool sensor = false;  ///< meets others without pushing them, see SensorEvent
    float mass = 1.0F;    ///< kg, dynamic only, > 0
    /// Principal moments of inertia, kg m2; zero: those of the shape filled evenly.
    Vec3 moments = Vec3::Zero();
    /// Or all of the tensor about the centre of mass, body axes, kg m2; zero: see `moments`. At
    /// most one of the two may be given.
    Mat3 inertia = Mat3::Zero();
    std::uint8_t events = 0;       ///< sum of kTellBegin, kTellPersist, kTellEnd
    Vec3 position = Vec3::Zero();  ///< centre of mass, m
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();          ///< m/s
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
    std::uint32_t user = 0;  ///< the caller's tag, e.g. an entity id's value; 0 = none
    bool asleep = false;     ///< dynamic: starts asleep
};

}  // namespace zoned::physics
