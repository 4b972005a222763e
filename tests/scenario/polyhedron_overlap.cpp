#include "tests/scenario/polyhedron_overlap.h"

#include "tests/scenario/penetration.h"

#include <algorithm>
#include <cmath>

namespace zoned::scenario {

namespace {

/// Points and directions of a polyhedron in other axes.
struct Placed {
    std::vector<Vec3d> points;
    std::vector<Vec3d> normals;  // by face
    const SolidGeometry& geometry;

    Placed(const SolidGeometry& g, const Pose& pose) : geometry(g) {
        for (const Vec3d& p : g.points) {
            points.push_back(pose.position + pose.orientation * p);
        }
        for (const SolidFace& face : g.faces) {
            normals.push_back(pose.orientation * face.normal);
        }
    }

    /// Farthest along n.
    [[nodiscard]] double reach(const Vec3d& n) const {
        double most = -INFINITY;
        for (const Vec3d& p : points) {
            most = std::max(most, n.dot(p));
        }
        return most;
    }
};

/// How far b, moved along n, overlaps a.
double overlap_along(const Placed& a, const Placed& b, const Vec3d& n) {
    return a.reach(n) + b.reach(-n);
}

/// The arcs between the normals at two edges cross: the edges form a face of the difference.
bool arcs_cross(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    const Vec3d ba = b.cross(a);
    const Vec3d dc = d.cross(c);
    const double cba = c.dot(ba);
    const double dba = d.dot(ba);
    const double adc = a.dot(dc);
    const double bdc = b.dot(dc);
    return cba * dba < 0.0 && adc * bdc < 0.0 && cba * bdc > 0.0;
}

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = (b - a).cross(c - a);
    const auto inside = [&](const Vec3d& u, const Vec3d& v) {
        return n.dot((v - u).cross(p - u)) >= 0.0;
    };
    if (inside(a, b) && inside(b, c) && inside(c, a)) {
        return std::abs(n.normalized().dot(p - a));
    }
    const auto to_edge = [&p](const Vec3d& u, const Vec3d& v) {
        const Vec3d d = v - u;
        const double t = std::clamp(d.dot(p - u) / d.squaredNorm(), 0.0, 1.0);
        return (p - u - t * d).norm();
    };
    return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double signed_distance(const SolidGeometry& hull, const Vec3d& p) {
    double highest = -INFINITY;
    double nearest = INFINITY;
    for (const SolidFace& face : hull.faces) {
        const double height = face.normal.dot(p) - face.offset;
        highest = std::max(highest, height);
        for (std::size_t i = 2; height > 0.0 && i < face.ring.size(); ++i) {
            nearest = std::min(nearest,
                               distance_to_triangle(p,
                                                    hull.points[face.ring[0]],
                                                    hull.points[face.ring[i - 1]],
                                                    hull.points[face.ring[i]]));
        }
    }
    return highest <= 0.0 ? highest : nearest;
}

/// Of a point that a triangle lies above: how far below, else 0.
double depth_of(const SolidGeometry& surface, const SolidFace& face, const Vec3d& p) {
    const double depth = face.offset - face.normal.dot(p);
    if (depth <= 0.0) {
        return 0.0;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d& a = surface.points[face.ring[i]];
        const Vec3d& b = surface.points[face.ring[(i + 1) % 3]];
        if (face.normal.dot((b - a).cross(p - a)) < 0.0) {
            return 0.0;
        }
    }
    return depth;
}

/// Visits the points of a convex solid that can be deepest along `normal`; `turn` leads from its
/// axes.
template <typename Visit>
void low_points(const Solid& solid, const Quatd& turn, const Vec3d& normal, Visit visit) {
    if (solid.form == Form::kSphere) {
        visit(-solid.radius * normal);
    } else if (solid.form == Form::kCapsule) {
        for (const double end : {-1.0, 1.0}) {
            visit(turn * Vec3d(0.0, end * solid.half_segment, 0.0) - solid.radius * normal);
        }
    } else if (solid.form == Form::kBox) {
        for (int i = 0; i < 8; ++i) {
            const Vec3d sign(
                (i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
            visit(turn * sign.cwiseProduct(solid.half_extents));
        }
    } else {
        for (const Vec3d& p : solid.geometry->points) {
            visit(turn * p);
        }
    }
}

}  // namespace

double polyhedra_overlap(const SolidGeometry& a, const SolidGeometry& b, const Pose& b_in_a) {
    const Placed pa(a, Pose());
    const Placed pb(b, b_in_a);
    double least = INFINITY;
    for (const Vec3d& n : pa.normals) {
        least = std::min(least, overlap_along(pa, pb, n));
    }
    for (const Vec3d& n : pb.normals) {
        least = std::min(least, overlap_along(pa, pb, -n));
    }
    if (least <= 0.0) {
        return 0.0;
    }
    for (const SolidEdge& ea : a.edges) {
        const Vec3d da = pa.points[ea.corners[1]] - pa.points[ea.corners[0]];
        const Vec3d& na = pa.normals[ea.faces[0]];
        const Vec3d& nb = pa.normals[ea.faces[1]];
        for (const SolidEdge& eb : b.edges) {
            if (!arcs_cross(na, nb, -pb.normals[eb.faces[0]], -pb.normals[eb.faces[1]])) {
                continue;
            }
            const Vec3d db = pb.points[eb.corners[1]] - pb.points[eb.corners[0]];
            Vec3d n = da.cross(db);
            if (n.norm() < 1e-9 * da.norm() * db.norm()) {
                continue;  // parallel: a face's normal has it
            }
            n.normalize();
            n = n.dot(na + nb) < 0.0 ? Vec3d(-n) : n;
            least =
                std::min(least, n.dot(pa.points[ea.corners[0]]) - n.dot(pb.points[eb.corners[0]]));
        }
    }
    return std::max(least, 0.0);
}

double least_distance(const SolidGeometry& hull, const Vec3d& centre, const Vec3d& half) {
    const auto at = [&](double t) {
        return signed_distance(hull, centre + t * half);
    };
    if (half.isZero(0.0)) {
        return at(0.0);
    }
    // It is convex along the segment: thirds close in on the least.
    double lower = -1.0;
    double upper = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double left = lower + (upper - lower) / 3.0;
        const double right = upper - (upper - lower) / 3.0;
        (at(left) < at(right) ? upper : lower) = at(left) < at(right) ? right : left;
    }
    return std::min({at(0.5 * (lower + upper)), at(-1.0), at(1.0)});
}

double depth_behind(const SolidGeometry& surface,
                    const Pose& at_surface,
                    const Solid& solid,
                    const Pose& at) {
    const Quatd back = at_surface.orientation.conjugate();
    const Vec3d centre = back * (at.position - at_surface.position);
    const Quatd turn = back * at.orientation;
    const double reach = bounding_radius(solid);
    const auto cell = [&](double x, int axis) {
        const int i = static_cast<int>(std::floor(x / surface.cell)) -
                      surface.cell_lower[static_cast<std::size_t>(axis)];
        return std::clamp(i, 0, surface.cell_counts[static_cast<std::size_t>(axis)] - 1);
    };
    double most = 0.0;
    const auto look = [&](const SolidFace& face) {
        const double height = face.normal.dot(centre) - face.offset;
        if (height < 0.0 || height > reach) {
            return;
        }
        low_points(solid, turn, face.normal, [&](const Vec3d& p) {
            most = std::max(most, depth_of(surface, face, centre + p));
        });
    };
    for (int z = cell(centre.z() - reach, 1); z <= cell(centre.z() + reach, 1); ++z) {
        for (int x = cell(centre.x() - reach, 0); x <= cell(centre.x() + reach, 0); ++x) {
            const auto i =
                static_cast<std::size_t>(z) * static_cast<std::size_t>(surface.cell_counts[0]) +
                static_cast<std::size_t>(x);
            for (std::uint32_t k = surface.cell_starts[i]; k < surface.cell_starts[i + 1]; ++k) {
                look(surface.faces[surface.cell_triangles[k]]);
            }
        }
    }
    return most;
}

}  // namespace zoned::scenario
