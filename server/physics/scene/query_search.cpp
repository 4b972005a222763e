#include "server/physics/query/query.h"
#include "server/physics/query/query_shape.h"
#include "server/physics/query/query_sinks.h"
#include "server/physics/query/ray_order.h"
#include "server/physics/query/shape_ray.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/ranges.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zoned::physics {

namespace {

/// Farther than any two points that bodies may have, m.
constexpr float kFarthest = 1.0e7F;

struct Path {
    Vec3 direction;  // unit
    float length;
};

/// Empty when nothing can be said about such a path.
std::optional<Path> path_of(const Vec3& origin, const Vec3& direction, float max_distance) {
    const float length = direction.norm();
    if (!fit_position(origin) || !std::isfinite(length) || !(length > 0.0F) ||
        !(max_distance >= 0.0F)) {
        return std::nullopt;
    }
    return Path{direction / length, std::min(max_distance, kFarthest)};
}

/// Empty when no body could be like this.
std::optional<QueryShape> query_shape_of(const ShapeAt& at) {
    CompoundPart part;
    part.shape = at.shape;
    if (!fit_position(at.position) || !fit_orientation(at.orientation) ||
        !why_unfit_part(part).empty()) {
        return std::nullopt;
    }
    const Mat3 rotation = at.orientation.normalized().toRotationMatrix();
    return QueryShape(Placed{at.shape, at.position, rotation});
}

}  // namespace

/// One query on its search through the bodies that it may hit.
class Query::Search {
  public:
    Search(const Query& query, const QueryFilter& filter)
        : scene_(*query.scene_->impl_),
          filter_(filter) {}

    template <class Sink>
    void ray(const Ray& ray, Sink& sink) const {
        const auto path = path_of(ray.origin, ray.direction, ray.max_distance);
        if (!path) {
            return;
        }
        const Vec3& along = path->direction;
        along_path({ray.origin, along, Vec3::Zero()}, path->length, [&](auto row, float limit) {
            float t = 0.0F;
            Vec3 normal = Vec3::Zero();
            if (!cast_ray(scene_.placed(row), ray.origin, along, limit, t, normal)) {
                return limit;
            }
            return sink.take(named(row, {t, ray.origin + t * along, normal}), limit);
        });
    }

    template <class Sink>
    void cast(const ShapeCast& cast, Sink& sink) const {
        const auto path = path_of(cast.start.position, cast.direction, cast.max_distance);
        const auto asker = path ? query_shape_of(cast.start) : std::nullopt;
        if (!asker) {
            return;
        }
        const Vec3 half = 0.5F * (asker->bounds.upper - asker->bounds.lower);
        const Vec3 middle = 0.5F * (asker->bounds.lower + asker->bounds.upper);
        along_path({middle, path->direction, half}, path->length, [&](auto row, float limit) {
            CastHit hit;
            if (!cast_query_shape(*asker, path->direction, limit, scene_.placed(row), hit)) {
                return limit;
            }
            return sink.take(named(row, hit), limit);
        });
    }

    /// Calls visit(row) for the bodies of interest whose boxes overlap an area, and for
    /// half-spaces, until visit returns false.
    template <class Visit>
    void in_area(const Aabb& area, Visit&& visit) const {
        bool goes_on = true;
        const auto test = [&](std::uint32_t row) {
            if (goes_on && wants(row)) {
                goes_on = visit(row);
            }
        };
        for (std::size_t kind = 0; kind < scene_.boxes.size() && goes_on; ++kind) {
            if (wants_kind(kind)) {
                scene_.boxes[kind].query(area, test);
            }
        }
        for (std::size_t i = 0; filter_.statics && i < scene_.planes.size(); ++i) {
            test(scene_.planes[i]);
        }
    }

    bool closest(const QueryShape& asker, float max_distance, QueryHit& hit) const {
        NearestSink sink{hit};
        const auto test = [&](std::uint32_t row, float limit) {
            CastHit found;
            const float within = sink.found ? hit.distance : max_distance;
            if (wants(row) && nearest(asker, within, scene_.placed(row), found)) {
                sink.take(named(row, found), within);
            }
            // The boxes are asked how far they are from the shape's middle.
            return sink.found ? hit.distance + asker.radius : limit;
        };
        float limit = max_distance + asker.radius;
        for (std::size_t i = 0; filter_.statics && i < scene_.planes.size(); ++i) {
            limit = test(scene_.planes[i], limit);
        }
        for (std::size_t kind = 0; kind < scene_.boxes.size(); ++kind) {
            if (wants_kind(kind)) {
                limit = scene_.boxes[kind].nearest(asker.position, limit, test);
            }
        }
        return sink.found;
    }

    [[nodiscard]] BodyId id_of(std::uint32_t row) const { return scene_.bodies.id_of(row); }

    [[nodiscard]] Placed placed(std::uint32_t row) const { return scene_.placed(row); }

  private:
    [[nodiscard]] bool wants_kind(std::size_t kind) const {
        switch (static_cast<BodyKind>(kind)) {
            case BodyKind::kStatic:
                return filter_.statics;
            case BodyKind::kKinematic:
                return filter_.kinematics;
            case BodyKind::kDynamic:
            case BodyKind::kParticle:  // in no index: no question finds them
                break;
        }
        return filter_.dynamics;
    }

    [[nodiscard]] bool wants(std::uint32_t row) const {
        const Bodies& bodies = scene_.bodies;
        return (filter_.ignore_user == 0 || bodies.user[row] != filter_.ignore_user) &&
               (filter_.categories & bodies.filter[row].category) != 0 &&
               (filter_.sensors || bodies.sensor[row] == 0);
    }

    [[nodiscard]] QueryHit named(std::uint32_t row, const CastHit& hit) const {
        return {
            scene_.bodies.id_of(row), scene_.bodies.user[row], hit.distance, hit.point, hit.normal};
    }

    /// Calls limit = test(row, limit) for the bodies of interest that a sweep may meet.
    template <class Test>
    void along_path(const spatial::Sweep& sweep, float limit, Test&& test) const {
        for (std::size_t i = 0; filter_.statics && i < scene_.planes.size() && limit >= 0.0F; ++i) {
            if (wants(scene_.planes[i])) {
                limit = test(scene_.planes[i], limit);
            }
        }
        for (std::size_t kind = 0; kind < scene_.boxes.size() && limit >= 0.0F; ++kind) {
            if (wants_kind(kind)) {
                limit = scene_.boxes[kind].cast(
                    sweep, limit, [&](std::uint32_t row, float current) -> float {
                        return wants(row) ? test(row, current) : current;
                    });
            }
        }
    }

    const Scene::Impl& scene_;
    const QueryFilter& filter_;
};

bool Query::ray(const Ray& ray, const QueryFilter& filter, QueryHit& hit) const {
    NearestSink sink{hit};
    Search(*this, filter).ray(ray, sink);
    return sink.found;
}

bool Query::ray_any(const Ray& ray, const QueryFilter& filter) const {
    AnySink sink;
    Search(*this, filter).ray(ray, sink);
    return sink.found;
}

QueryCount Query::ray_all(const Ray& ray,
                          const QueryFilter& filter,
                          std::span<QueryHit> hits) const {
    AllSink sink{hits};
    Search(*this, filter).ray(ray, sink);
    return sink.sorted();
}

void Query::rays(std::span<const Ray> rays,
                 const QueryFilter& filter,
                 std::span<QueryHit> hits) const {
    ZONED_ASSERT(rays.size() == hits.size(), "each ray needs room for its hit");
    const Bodies& bodies = scene_->impl_->bodies;
    if (worth_ordering(rays.size(), bodies.count)) {
        order_rays(rays, hits);
        for (QueryHit& hit : hits) {
            const std::uint32_t index = hit.user;
            if (!ray(rays[index], filter, hit)) {
                hit = QueryHit();
            }
            hit.user = index;
        }
        put_in_place(hits);
        for (QueryHit& hit : hits) {
            hit.user = hit.body ? bodies.user[bodies.row_of(hit.body)] : 0;
        }
        return;
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!ray(rays[i], filter, hits[i])) {
            hits[i] = QueryHit();
        }
    }
}

bool Query::cast(const ShapeCast& cast, const QueryFilter& filter, QueryHit& hit) const {
    NearestSink sink{hit};
    Search(*this, filter).cast(cast, sink);
    return sink.found;
}

bool Query::cast_any(const ShapeCast& cast, const QueryFilter& filter) const {
    AnySink sink;
    Search(*this, filter).cast(cast, sink);
    return sink.found;
}

QueryCount Query::cast_all(const ShapeCast& cast,
                           const QueryFilter& filter,
                           std::span<QueryHit> hits) const {
    AllSink sink{hits};
    Search(*this, filter).cast(cast, sink);
    return sink.sorted();
}

void Query::casts(std::span<const ShapeCast> casts,
                  const QueryFilter& filter,
                  std::span<QueryHit> hits) const {
    ZONED_ASSERT(casts.size() == hits.size(), "each cast needs room for its hit");
    for (std::size_t i = 0; i < casts.size(); ++i) {
        if (!cast(casts[i], filter, hits[i])) {
            hits[i] = QueryHit();
        }
    }
}

QueryCount Query::overlap(const ShapeAt& shape,
                          const QueryFilter& filter,
                          std::span<BodyId> bodies) const {
    IdSink sink{bodies};
    const Search search(*this, filter);
    if (const auto asker = query_shape_of(shape)) {
        search.in_area(asker->bounds, [&](std::uint32_t row) {
            if (overlaps(*asker, search.placed(row))) {
                sink.take(search.id_of(row));
            }
            return true;
        });
    }
    return sink.sorted();
}

bool Query::overlap_any(const ShapeAt& shape, const QueryFilter& filter) const {
    const Search search(*this, filter);
    bool found = false;
    if (const auto asker = query_shape_of(shape)) {
        search.in_area(asker->bounds, [&](std::uint32_t row) {
            found = overlaps(*asker, search.placed(row));
            return !found;
        });
    }
    return found;
}

bool Query::closest_to_point(const Vec3& point,
                             float max_distance,
                             const QueryFilter& filter,
                             QueryHit& hit) const {
    return fit_position(point) && max_distance >= 0.0F &&
           Search(*this, filter).closest(QueryShape(point), std::min(max_distance, kFarthest), hit);
}

bool Query::closest(const ShapeAt& shape,
                    float max_distance,
                    const QueryFilter& filter,
                    QueryHit& hit) const {
    const auto asker = query_shape_of(shape);
    return asker && max_distance >= 0.0F &&
           Search(*this, filter).closest(*asker, std::min(max_distance, kFarthest), hit);
}

}  // namespace zoned::physics
