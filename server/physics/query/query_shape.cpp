#include "server/physics/query/query_shape.h"

#include "server/physics/narrowphase/near_parts.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// A box of the world as a box in the frame of a body.
Aabb to_frame(const Aabb& box, const Placed& body) {
    const Vec3 middle = body.to_local(0.5F * (box.lower + box.upper));
    const Vec3 half = body.rotation.transpose().cwiseAbs() * (0.5F * (box.upper - box.lower));
    return {middle - half, middle + half};
}

/// Calls visit(Placed) for the parts of a compound that are no sensors and whose boxes overlap an
/// area of the world, until visit returns false.
template <class Visit>
void for_solid_parts(const Placed& body, const Aabb& area, Visit&& visit) {
    const Compound& compound = compound_of(body.shape);
    bool goes_on = true;
    compound.tree().query(to_frame(area, body), [&](std::uint32_t i) {
        const Compound::CompoundChild& part = compound.parts()[i];
        if (goes_on && !part.part.sensor) {
            const Mat3 rotation = body.rotation * part.rotation;
            goes_on =
                visit(Placed{part.part.shape, body.to_world(part.part.frame.position), rotation});
        }
    });
}

/// Calls visit(triangle) for the triangles of a surface in an area of its own frame.
template <class Visit>
void for_triangles_of(const Shape& surface, const Aabb& area, Visit&& visit) {
    if (surface.kind == ShapeKind::kMesh) {
        for_triangles(mesh_of(surface), area, visit);
    } else {
        for_triangles(field_of(surface), area, visit);
    }
}

Aabb box_of(const Shape& surface) {
    return surface.kind == ShapeKind::kMesh ? mesh_of(surface).box() : field_of(surface).box();
}

double height_above(const QueryShape& asker, const Placed& plane, Vec3d& lowest) {
    const Vec3d up = plane.rotation.col(1).cast<double>();
    lowest = asker.core.farthest(-plane.rotation.col(1)) - asker.core.radius() * up;
    return up.dot(lowest - plane.position.cast<double>());
}

bool cast_at_plane(const QueryShape& asker,
                   const Vec3& direction,
                   float limit,
                   const Placed& plane,
                   CastHit& hit) {
    const Vec3 up = plane.rotation.col(1);
    Vec3d lowest = Vec3d::Zero();
    const double gap = height_above(asker, plane, lowest);
    const double closing = -up.cast<double>().dot(direction.cast<double>());
    const bool overlapped = gap < -static_cast<double>(kGraze);
    const double way = gap > 0.0 ? gap / closing : 0.0;
    if (!overlapped && !(closing > kSliding && way <= static_cast<double>(limit))) {
        return false;
    }
    hit.distance = static_cast<float>(way);
    hit.normal = overlapped ? Vec3(-direction) : up;
    hit.point = (lowest + way * direction.cast<double>()).cast<float>();
    return true;
}

/// The part of the path on which the shape's box meets a box, in the frame of both.
struct Stretch {
    float from = 0.0F;
    float to = -1.0F;
};

Stretch stretch_within(const spatial::Sweep& sweep, const Aabb& box, float limit) {
    Stretch s{0.0F, limit};
    const spatial::SweepLanes lanes(sweep);
    for (int i = 0; i < 3; ++i) {
        const float a = (box.lower[i] - sweep.half_extents[i] - sweep.origin[i]) * lanes.slope[i];
        const float b = (box.upper[i] + sweep.half_extents[i] - sweep.origin[i]) * lanes.slope[i];
        s.from = std::max(s.from, std::min(a, b));
        s.to = std::min(s.to, std::max(a, b));
    }
    return s;
}

/// Looks along the path piece by piece, so that a long path across a wide surface meets few
/// triangles. Ends at the first piece with a hit.
bool cast_at_surface(const QueryShape& asker,
                     const Vec3& direction,
                     float limit,
                     const Placed& surface,
                     CastHit& hit) {
    constexpr float kPieces = 64.0F;
    const Aabb start = to_frame(asker.bounds, surface);
    const Vec3 half = 0.5F * (start.upper - start.lower) + Vec3::Constant(1.0e-4F);
    const Vec3 along = surface.rotation.transpose() * direction;
    const spatial::Sweep sweep{0.5F * (start.lower + start.upper), along, half};
    const spatial::SweepLanes lanes(sweep);
    const Stretch stretch = stretch_within(sweep, box_of(surface.shape), limit);
    const float piece = std::max(4.0F * half.maxCoeff(), (stretch.to - stretch.from) / kPieces);
    bool found = false;
    for (float from = stretch.from; from <= stretch.to && !(found && hit.distance < from);
         from += piece) {
        const Vec3 begin = sweep.origin + from * along;
        const Aabb area = swept({begin - half, begin + half}, piece * along);
        for_triangles_of(surface.shape, area, [&](const Triangle& triangle) {
            const float within = found ? hit.distance : limit;
            if (!(triangle.normal.dot(along) < 0.0F) || !lanes.meets(box_of(triangle), within)) {
                return;
            }
            CastHit other;
            if (cast_core(asker.core,
                          asker.inner,
                          direction,
                          within,
                          ConvexCore(triangle, surface),
                          other) &&
                (!found || other.distance < hit.distance)) {
                hit = other;
                found = true;
            }
        });
    }
    return found;
}

bool overlaps_surface(const QueryShape& asker, const Placed& surface) {
    if (surface.shape.kind == ShapeKind::kHeightfield) {
        const Vec3 p = surface.to_local(asker.position);
        Triangle under;
        if (field_of(surface.shape).triangle_at(p, under) && under.height(p) <= 0.0F) {
            return true;
        }
    }
    bool found = false;
    for_triangles_of(surface.shape, to_frame(asker.bounds, surface), [&](const Triangle& triangle) {
        found = found ||
                gap_between(asker.core, Vec3d::Zero(), ConvexCore(triangle, surface)).gap <= 0.0;
    });
    return found;
}

bool take_gap(const CoreGap& gap, float limit, const QueryShape& asker, CastHit& hit) {
    if (gap.deep || gap.gap <= 0.0) {
        hit = {0.0F, asker.position, Vec3::UnitY()};
        return true;
    }
    if (!(gap.gap <= static_cast<double>(limit))) {
        return false;
    }
    hit = {static_cast<float>(gap.gap), gap.point.cast<float>(), gap.normal.cast<float>()};
    return true;
}

/// Looks in boxes about the shape that double until a triangle is found within them.
bool nearest_on_surface(const QueryShape& asker, float limit, const Placed& surface, CastHit& hit) {
    const Aabb whole = box_of(surface.shape);
    const Aabb at = to_frame(asker.bounds, surface);
    const Vec3 apart = (whole.lower - at.upper).cwiseMax(at.lower - whole.upper).cwiseMax(0.0F);
    const float farthest = apart.norm() + (whole.upper - whole.lower).norm();
    const float most = std::min(limit, farthest + (at.upper - at.lower).norm());
    bool found = overlaps_surface(asker, surface);
    if (found) {
        hit = {0.0F, asker.position, Vec3::UnitY()};
        return true;
    }
    for (float reach = std::max(apart.maxCoeff() + 0.5F, 1.0F); !found; reach *= 2.0F) {
        const float within = std::min(reach, most);
        const Aabb area = at.grown(within);
        for_triangles_of(surface.shape, area, [&](const Triangle& triangle) {
            const CoreGap gap =
                gap_between(asker.core, Vec3d::Zero(), ConvexCore(triangle, surface));
            found |= take_gap(gap, found ? hit.distance : within, asker, hit);
        });
        if (within >= most) {
            break;
        }
    }
    return found;
}

}  // namespace

QueryShape::QueryShape(const Placed& shape)
    : position(shape.position),
      core(shape),
      inner(shape, kGraze),
      bounds(shape_bounds(shape.shape, shape.position, shape.rotation)),
      radius((bounds.upper - position).cwiseMax(position - bounds.lower).norm()) {
}

QueryShape::QueryShape(const Vec3& point)
    : position(point),
      core(point),
      inner(point),
      bounds{point, point} {
}

bool cast_query_shape(const QueryShape& asker,
                      const Vec3& direction,
                      float limit,
                      const Placed& body,
                      CastHit& hit) {
    switch (body.shape.kind) {
        case ShapeKind::kPlane:
            return cast_at_plane(asker, direction, limit, body, hit);
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            return cast_at_surface(asker, direction, limit, body, hit);
        case ShapeKind::kCompound: {
            bool found = false;
            for_solid_parts(body, swept(asker.bounds, limit * direction), [&](const Placed& part) {
                CastHit other;
                const float within = found ? hit.distance : limit;
                if (cast_core(
                        asker.core, asker.inner, direction, within, ConvexCore(part), other) &&
                    (!found || other.distance < hit.distance)) {
                    hit = other;
                    found = true;
                }
                return true;
            });
            return found;
        }
        default:
            return cast_core(asker.core, asker.inner, direction, limit, ConvexCore(body), hit);
    }
}

bool overlaps(const QueryShape& asker, const Placed& body) {
    switch (body.shape.kind) {
        case ShapeKind::kPlane: {
            Vec3d lowest = Vec3d::Zero();
            return height_above(asker, body, lowest) <= 0.0;
        }
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            return overlaps_surface(asker, body);
        case ShapeKind::kCompound: {
            bool found = false;
            for_solid_parts(body, asker.bounds, [&](const Placed& part) {
                found = gap_between(asker.core, Vec3d::Zero(), ConvexCore(part)).gap <= 0.0;
                return !found;
            });
            return found;
        }
        default:
            return gap_between(asker.core, Vec3d::Zero(), ConvexCore(body)).gap <= 0.0;
    }
}

bool nearest(const QueryShape& asker, float limit, const Placed& body, CastHit& hit) {
    switch (body.shape.kind) {
        case ShapeKind::kPlane: {
            CoreGap gap;
            Vec3d lowest = Vec3d::Zero();
            gap.gap = height_above(asker, body, lowest);
            gap.normal = body.rotation.col(1).cast<double>();
            gap.point = lowest - gap.gap * gap.normal;
            return take_gap(gap, limit, asker, hit);
        }
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            return nearest_on_surface(asker, limit, body, hit);
        case ShapeKind::kCompound: {
            bool found = false;
            for_solid_parts(body, asker.bounds.grown(limit), [&](const Placed& part) {
                const CoreGap gap = gap_between(asker.core, Vec3d::Zero(), ConvexCore(part));
                found |= take_gap(gap, found ? hit.distance : limit, asker, hit);
                return true;
            });
            return found;
        }
        default:
            return take_gap(
                gap_between(asker.core, Vec3d::Zero(), ConvexCore(body)), limit, asker, hit);
    }
}

}  // namespace zoned::physics
