#include "server/physics/query/surface_ray.h"

#include "server/physics/query/shape_ray.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// (Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2,
/// 1997), for fronts, in doubles: a ray that meets an edge meets one of the two triangles.
bool cast_front(const Triangle& triangle, const Vec3d& o, const Vec3d& d, double& t) {
    const Vec3d a = triangle.corner[0].cast<double>();
    const Vec3d e1 = triangle.corner[1].cast<double>() - a;
    const Vec3d e2 = triangle.corner[2].cast<double>() - a;
    const Vec3d p = d.cross(e2);
    const double determinant = e1.dot(p);
    if (!(determinant > 0.0)) {
        return false;
    }
    const Vec3d s = o - a;
    const double slack = 1.0e-12 * determinant;
    const double u = s.dot(p);
    const Vec3d q = s.cross(e1);
    const double v = d.dot(q);
    if (u < -slack || v < -slack || u + v > determinant + slack) {
        return false;
    }
    t = e2.dot(q) / determinant;
    return t >= 0.0;
}

/// Steps over the values of one coordinate at which a ray enters the next cell.
struct CellSteps {
    int step = 0;
    std::int64_t cell = 0;
    double next = INFINITY;   // ray parameter at which the next cell begins
    double every = INFINITY;  // and how much it grows by per cell

    CellSteps(double origin, double direction, double start, double spacing, double half) {
        const double at = (origin + start * direction) / spacing + half;
        cell = static_cast<std::int64_t>(std::floor(at));
        if (direction != 0.0) {
            step = direction > 0.0 ? 1 : -1;
            const double border = static_cast<double>(cell) + (step > 0 ? 1.0 : 0.0);
            next = ((border - half) * spacing - origin) / direction;
            every = spacing / std::abs(direction);
        }
    }

    void advance() {
        cell += step;
        next += every;
    }
};

/// The part of the ray over the field, and below its highest point.
bool clip_ray(const Aabb& box, const Vec3d& o, const Vec3d& d, double& enter, double& leave) {
    for (int i = 0; i < 3; ++i) {
        const double lower = box.lower[i];
        const double upper = box.upper[i];
        if (d[i] == 0.0) {
            if (o[i] < lower || o[i] > upper) {
                return false;
            }
            continue;
        }
        const double t0 = (lower - o[i]) / d[i];
        const double t1 = (upper - o[i]) / d[i];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    return enter <= leave;
}

}  // namespace

bool cast_mesh(const TriangleMesh& mesh,
               const Vec3& origin,
               const Vec3& direction,
               float limit,
               float& t,
               Vec3& normal) {
    const Vec3d o = origin.cast<double>();
    const Vec3d d = direction.cast<double>();
    bool hit = false;
    std::uint32_t best = 0;
    const auto test = [&](std::uint32_t i, float bound) {
        const Triangle triangle = mesh.triangle(i);
        double at = 0.0;
        if (!cast_front(triangle, o, d, at) || !(static_cast<float>(at) <= bound)) {
            return bound;
        }
        // Of two at the same distance the lower one wins, whatever the order of the tree.
        if (hit && static_cast<float>(at) == bound && i > best) {
            return bound;
        }
        hit = true;
        best = i;
        normal = triangle.normal;
        return static_cast<float>(at);
    };
    t = mesh.tree().cast(origin, direction, limit, test);
    return hit;
}

bool cast_heightfield(const Heightfield& field,
                      const Vec3& origin,
                      const Vec3& direction,
                      float limit,
                      float& t,
                      Vec3& normal) {
    const Vec3d o = origin.cast<double>();
    const Vec3d d = direction.cast<double>();
    double enter = 0.0;
    double leave = limit;
    // A flat field's box has no height: a hair more, so that rounding does not pass it by.
    if (!clip_ray(field.box().grown(1.0e-3F), o, d, enter, leave)) {
        return false;
    }
    const Heightfield::HeightfieldTables& tables = field.tables();
    const auto columns = static_cast<std::int64_t>(tables.columns) - 1;
    const auto rows = static_cast<std::int64_t>(tables.rows) - 1;
    CellSteps x(o.x(), d.x(), enter, tables.spacing_x, 0.5 * static_cast<double>(columns));
    CellSteps z(o.z(), d.z(), enter, tables.spacing_z, 0.5 * static_cast<double>(rows));
    for (;;) {
        // A ray along the border, or within rounding of it, keeps to the outermost cells.
        const auto i = static_cast<std::uint32_t>(std::clamp<std::int64_t>(x.cell, 0, columns - 1));
        const auto k = static_cast<std::uint32_t>(std::clamp<std::int64_t>(z.cell, 0, rows - 1));
        bool hit = false;
        for (std::uint32_t half = 0; half < 2; ++half) {
            const Triangle triangle = field.bare_triangle(i, k, half);
            double at = 0.0;
            if (cast_front(triangle, o, d, at) && at <= limit && (!hit || at < t)) {
                hit = true;
                t = static_cast<float>(at);
                normal = triangle.normal;
            }
        }
        if (hit) {
            return true;
        }
        CellSteps& nearer = x.next <= z.next ? x : z;
        if (!(nearer.next <= leave)) {
            return false;
        }
        nearer.advance();
    }
}

bool cast_compound(const Compound& compound,
                   const Vec3& origin,
                   const Vec3& direction,
                   float limit,
                   float& t,
                   Vec3& normal) {
    bool hit = false;
    std::uint32_t best = 0;
    const auto test = [&](std::uint32_t i, float bound) {
        const Compound::CompoundChild& part = compound.parts()[i];
        const Placed placed{part.part.shape, part.part.frame.position, part.rotation};
        float at = 0.0F;
        Vec3 out = Vec3::Zero();
        if (part.part.sensor || !cast_ray(placed, origin, direction, bound, at, out) ||
            (hit && at == bound && i > best)) {
            return bound;
        }
        hit = true;
        best = i;
        normal = out;
        return at;
    };
    t = compound.tree().cast(origin, direction, limit, test);
    return hit;
}

}  // namespace zoned::physics
