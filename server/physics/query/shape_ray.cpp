#include "server/physics/query/shape_ray.h"

#include "server/physics/query/surface_ray.h"
#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Smallest root t >= 0 of the ray against a ball about `centre`; false on a miss. A ray that
/// starts inside gives t = 0.
bool cast_ball(const Vec3& o, const Vec3& d, const Vec3& centre, float r, float& t, Vec3& normal) {
    const Vec3 m = o - centre;
    const float c = m.squaredNorm() - r * r;
    if (c <= 0.0F) {
        t = 0.0F;
        normal = -d;
        return true;
    }
    const float b = m.dot(d);
    // The discriminant from the distance to the line loses no digits when the ball is far away.
    const float miss2 = (m - b * d).squaredNorm();
    if (b > 0.0F || miss2 > r * r) {
        return false;
    }
    t = -b - std::sqrt(r * r - miss2);
    normal = (m + t * d) / r;
    return true;
}

bool cast_box(const Vec3& o, const Vec3& d, const Vec3& half, float& t, Vec3& normal) {
    float enter = -INFINITY;
    float leave = INFINITY;
    int axis = 0;
    for (int i = 0; i < 3; ++i) {
        if (d[i] == 0.0F) {
            if (std::abs(o[i]) > half[i]) {
                return false;
            }
            continue;
        }
        const float t0 = (-half[i] - o[i]) / d[i];
        const float t1 = (half[i] - o[i]) / d[i];
        if (std::min(t0, t1) > enter) {
            enter = std::min(t0, t1);
            axis = i;
        }
        leave = std::min(leave, std::max(t0, t1));
    }
    if (enter > leave || leave < 0.0F) {
        return false;
    }
    if (enter <= 0.0F) {
        t = 0.0F;
        normal = -d;
        return true;
    }
    t = enter;
    normal = Vec3::Unit(axis) * (d[axis] > 0.0F ? -1.0F : 1.0F);
    return true;
}

/// A capsule is the hull of its cylinder side and its two end balls: the side counts where the hit
/// lies between the ends, otherwise the nearer ball does.
bool cast_capsule(const Vec3& o, const Vec3& d, const Shape& shape, float& t, Vec3& normal) {
    const float r = shape.radius;
    const float h = shape.half_segment;
    const Vec3 nearest(0.0F, std::clamp(o.y(), -h, h), 0.0F);
    if ((o - nearest).squaredNorm() <= r * r) {
        t = 0.0F;
        normal = -d;
        return true;
    }
    const float a = d.x() * d.x() + d.z() * d.z();
    if (a > 1.0e-12F) {
        const float b = o.x() * d.x() + o.z() * d.z();
        const float c = o.x() * o.x() + o.z() * o.z() - r * r;
        const float root = b * b - a * c;
        if (root >= 0.0F && c > 0.0F) {
            const float side = (-b - std::sqrt(root)) / a;
            const float y = o.y() + side * d.y();
            if (side >= 0.0F && std::abs(y) <= h) {
                t = side;
                normal = Vec3(o.x() + side * d.x(), 0.0F, o.z() + side * d.z()) / r;
                return true;
            }
        }
    }
    bool hit = false;
    t = INFINITY;
    for (const float end : {-h, h}) {
        float t_end = 0.0F;
        Vec3 n_end = Vec3::Zero();
        if (cast_ball(o, d, Vec3(0.0F, end, 0.0F), r, t_end, n_end) && t_end < t) {
            t = t_end;
            normal = n_end;
            hit = true;
        }
    }
    return hit;
}

/// Clips the ray by the planes of the faces (Cyrus and Beck, "Generalized two- and
/// three-dimensional clipping", Computers and Graphics 3, 1978).
bool cast_hull(const Vec3& o, const Vec3& d, const HullView& hull, float& t, Vec3& normal) {
    float enter = 0.0F;
    float leave = INFINITY;
    int face = -1;
    for (int f = 0; f < hull.face_count; ++f) {
        const float above = hull.faces[f].normal.dot(o) - hull.faces[f].offset;
        const float rate = hull.faces[f].normal.dot(d);
        if (rate < 0.0F) {
            if (above > -enter * rate) {
                enter = above / -rate;
                face = f;
            }
        } else if (above > 0.0F) {
            return false;
        } else if (rate > 0.0F) {
            leave = std::min(leave, -above / rate);
        }
        if (enter > leave) {
            return false;
        }
    }
    t = enter;
    normal = face < 0 ? Vec3(-d) : hull.faces[face].normal;
    return true;
}

bool cast_half_space(const Vec3& o, const Vec3& d, float& t, Vec3& normal) {
    if (o.y() <= 0.0F) {
        t = 0.0F;
        normal = -d;
        return true;
    }
    if (d.y() >= 0.0F) {
        return false;
    }
    t = -o.y() / d.y();
    normal = Vec3::UnitY();
    return true;
}

}  // namespace

bool cast_ray(const Placed& shape,
              const Vec3& origin,
              const Vec3& direction,
              float limit,
              float& t,
              Vec3& normal) {
    const Vec3 o = shape.to_local(origin);
    const Vec3 d = shape.rotation.transpose() * direction;
    Vec3 local = Vec3::Zero();
    bool hit = false;
    switch (shape.shape.kind) {
        case ShapeKind::kSphere:
            hit = cast_ball(o, d, Vec3::Zero(), shape.shape.radius, t, local);
            break;
        case ShapeKind::kBox:
            hit = cast_box(o, d, shape.shape.half_extents, t, local);
            break;
        case ShapeKind::kCapsule:
            hit = cast_capsule(o, d, shape.shape, t, local);
            break;
        case ShapeKind::kHull:
            hit = cast_hull(o, d, hull_of(shape.shape).view(), t, local);
            break;
        case ShapeKind::kMesh:
            hit = cast_mesh(mesh_of(shape.shape), o, d, limit, t, local);
            break;
        case ShapeKind::kHeightfield:
            hit = cast_heightfield(field_of(shape.shape), o, d, limit, t, local);
            break;
        case ShapeKind::kCompound:
            hit = cast_compound(compound_of(shape.shape), o, d, limit, t, local);
            break;
        case ShapeKind::kPlane:
            hit = cast_half_space(o, d, t, local);
            break;
    }
    normal = shape.rotation * local;
    return hit && t <= limit;
}

}  // namespace zoned::physics
