// Query: finds the bodies in a scene by rays, moving shapes, overlaps and nearest distance.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/core/ids.h"
#include "shared/math/aabb.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::physics {

class Scene;

/// Which bodies a question is about.
struct QueryFilter {
    std::uint32_t ignore_user = 0;           ///< leaves out bodies with this tag; 0 = nobody
    std::uint32_t categories = 0xFFFFFFFFU;  ///< only bodies in one of these categories
    bool statics = true;
    bool kinematics = true;
    bool dynamics = true;
    bool sensors = false;
};

struct Ray {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitX();  ///< any length but zero
    float max_distance = 0.0F;       ///< m; may be infinite
};

/// A convex shape (sphere, box, capsule or hull) where it stands. The shape must outlive it.
struct ShapeAt {
    const Shape& shape;
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
};

/// A convex shape that moves straight on without turning.
struct ShapeCast {
    ShapeAt start;
    Vec3 direction = Vec3::UnitX();  ///< any length but zero
    float max_distance = 0.0F;       ///< m; may be infinite
};

struct QueryHit {
    BodyId body;  ///< none: nothing was hit
    std::uint32_t user = 0;
    /// Along the normalised direction, m; of `closest` the gap. 0 where they overlap at the start.
    float distance = 0.0F;
    Vec3 point = Vec3::Zero();  ///< on the surface of the body, world
    /// Unit, outward from the body; against the direction where they overlap at the start.
    Vec3 normal = Vec3::UnitY();
};

/// How many answers there are, and how many of them found room.
struct QueryCount {
    std::size_t written = 0;
    bool more = false;  ///< others were left out
};

/// A view of a scene, valid while nothing is changed in it; several threads may use it at once. No
/// query allocates. Input that is not finite or a shape that no body could have hits nothing. Of
/// equal distances the lower id comes first, so that answers depend on the scene alone.
///
/// Rays and moving shapes hit the fronts of triangles only. A moving shape may only touch a body at
/// the start (overlap it by up to 5 mm). The body then holds it where it moves towards the body,
/// not where it slides along or leaves. So a box that lies on the floor is not held by the floor.
///
/// Worlds ask `ray` today. Reached by no world yet: game rules will use the other queries (all
/// hits, batches, moving shapes, overlaps, nearest bodies).
class Query {
  public:
    /// The nearest hit; false: there is none.
    bool ray(const Ray& ray, const QueryFilter& filter, QueryHit& hit) const;
    /// Whether there is any hit: cheaper than to know which.
    [[nodiscard]] bool ray_any(const Ray& ray, const QueryFilter& filter) const;
    /// One hit per body, the nearest ones that find room in `hits`, nearest first.
    QueryCount ray_all(const Ray& ray, const QueryFilter& filter, std::span<QueryHit> hits) const;
    /// The nearest hit of each ray; `hits` is as long as `rays`. Large batches in large scenes are
    /// cast in an order of their own (see ray_order.h); the answers are those of `ray`.
    void rays(std::span<const Ray> rays, const QueryFilter& filter, std::span<QueryHit> hits) const;

    /// The same for moving shapes. Distances are exact to some micrometres.
    bool cast(const ShapeCast& cast, const QueryFilter& filter, QueryHit& hit) const;
    [[nodiscard]] bool cast_any(const ShapeCast& cast, const QueryFilter& filter) const;
    QueryCount cast_all(const ShapeCast& cast,
                        const QueryFilter& filter,
                        std::span<QueryHit> hits) const;
    void casts(std::span<const ShapeCast> casts,
               const QueryFilter& filter,
               std::span<QueryHit> hits) const;

    /// Bodies that overlap a shape (touching counts), those with the lowest ids that find room,
    /// ascending.
    QueryCount overlap(const ShapeAt& shape,
                       const QueryFilter& filter,
                       std::span<BodyId> bodies) const;
    [[nodiscard]] bool overlap_any(const ShapeAt& shape, const QueryFilter& filter) const;

    /// The body nearest to a point or shape within `max_distance`; false: there is none. Where they
    /// overlap, the distance is 0, `point` the query's position and `normal` up.
    bool closest_to_point(const Vec3& point,
                          float max_distance,
                          const QueryFilter& filter,
                          QueryHit& hit) const;
    bool closest(const ShapeAt& shape,
                 float max_distance,
                 const QueryFilter& filter,
                 QueryHit& hit) const;

  private:
    friend class Scene;
    class Search;

    explicit Query(const Scene& scene) : scene_(&scene) {}

    const Scene* scene_;
};

}  // namespace zoned::physics
