#include "server/physics/shapes/convex/hull.h"

#include "server/physics/shapes/convex/hull_faces.h"
#include "server/physics/shapes/mass_properties.h"
#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace zoned::physics {

namespace {

using HullTables = ConvexHull::HullTables;

float tolerance_of(const HullOptions& options, double extent) {
    if (options.tolerance > 0.0F) {
        return options.tolerance;
    }
    return static_cast<float>(std::min(1.0e-5 * extent, std::max(1.0e-4, 4.0e-7 * extent)));
}

std::string why_unfit_points(std::span<const Vec3> points, const HullOptions& options) {
    if (points.size() < 4) {
        return "hull: fewer than four points";
    }
    if (points.size() > kMaxHullPoints) {
        return "hull: more than " + std::to_string(kMaxHullPoints) + " points";
    }
    if (options.max_vertices < 4 || options.max_vertices > kMaxHullVertices) {
        return "hull: max_vertices out of range 4.." + std::to_string(kMaxHullVertices);
    }
    if (!(options.tolerance >= 0.0F && options.tolerance <= kMaxSize)) {
        return "hull: tolerance out of range";
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!fit_position(points[i])) {
            return "hull: point " + std::to_string(i) + " is not finite or out of range";
        }
    }
    return {};
}

/// The corners that the faces use, renamed 0.. in the order of the points.
std::vector<Vec3d> compact(std::span<const Vec3d> points, FaceLoops& loops) {
    std::map<int, int> names;
    for (const auto& loop : loops) {
        for (const int c : loop) {
            names[c] = 0;
        }
    }
    std::vector<Vec3d> corners;
    for (auto& [point, name] : names) {
        name = static_cast<int>(corners.size());
        corners.push_back(points[static_cast<std::size_t>(point)]);
    }
    for (auto& loop : loops) {
        for (int& c : loop) {
            c = names[c];
        }
    }
    return corners;
}

MassProperties mass_of(const std::vector<Vec3d>& corners, const FaceLoops& loops) {
    Vec3d middle = Vec3d::Zero();
    for (const Vec3d& c : corners) {
        middle += c / static_cast<double>(corners.size());
    }
    SurfaceIntegral integral(middle);
    for (const auto& loop : loops) {
        const auto at = [&](std::size_t i) {
            return corners[static_cast<std::size_t>(loop[i])];
        };
        for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
            integral.add(at(0), at(i), at(i + 1));
        }
    }
    return integral.result();
}

void fill_corners(const std::vector<Vec3d>& corners, HullTables& t) {
    t.vertices = static_cast<int>(corners.size());
    const int count = padded(t.vertices);
    t.box = {Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
    for (int i = 0; i < count; ++i) {
        const Vec3 c = corners[static_cast<std::size_t>(std::min(i, t.vertices - 1))].cast<float>();
        t.x.push_back(c.x());
        t.y.push_back(c.y());
        t.z.push_back(c.z());
        t.box.lower = t.box.lower.cwiseMin(c);
        t.box.upper = t.box.upper.cwiseMax(c);
        t.radius = std::max(t.radius, c.norm());
    }
}

void fill_faces(const std::vector<Vec3d>& corners, const FaceLoops& loops, HullTables& t) {
    std::map<std::pair<int, int>, std::uint8_t> left;
    for (const auto& loop : loops) {
        const auto name = static_cast<std::uint8_t>(t.faces.size());
        HullFace face{};
        face.first = static_cast<std::uint16_t>(t.loops.size());
        face.corners = static_cast<std::uint16_t>(loop.size());
        Vec3d normal = Vec3d::Zero();
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const int from = loop[i];
            const int to = loop[(i + 1) % loop.size()];
            t.loops.push_back(static_cast<std::uint8_t>(from));
            left[{from, to}] = name;
            // Newell's sum over the outline is the mean plane of a polygon that is nearly flat.
            normal += corners[static_cast<std::size_t>(from)].cross(
                corners[static_cast<std::size_t>(to)]);
        }
        face.normal = normal.normalized().cast<float>();
        face.offset = -lowest({t.x.data(), t.y.data(), t.z.data(), static_cast<int>(t.x.size())},
                              -face.normal);
        t.faces.push_back(face);
        t.inner = t.faces.size() == 1 ? face.offset : std::min(t.inner, face.offset);
    }
    // The planes of faces that were merged lie a little outside of some corners.
    t.inner *= 0.999F;
    for (const auto& [edge, face] : left) {
        if (edge.first < edge.second) {
            t.edges.push_back({static_cast<std::uint8_t>(edge.first),
                               static_cast<std::uint8_t>(edge.second),
                               face,
                               left[{edge.second, edge.first}]});
            const HullEdge& added = t.edges.back();
            const float cosine = t.faces[added.left].normal.dot(t.faces[added.right].normal);
            t.half_cosines.push_back(std::sqrt(std::max(0.5F * (1.0F + cosine), 0.0F)));
        }
    }
}

float thickness(const HullView& view) {
    float least = INFINITY;
    for (int f = 0; f < view.face_count; ++f) {
        const HullFace& face = view.faces[f];
        least = std::min(least, face.offset - lowest(view.points, face.normal));
    }
    return least;
}

}  // namespace

ConvexHull::ConvexHull(HullTables tables)
    : Geometry(ShapeKind::kHull),
      t_(std::move(tables)),
      view_{{t_.x.data(), t_.y.data(), t_.z.data(), static_cast<int>(t_.x.size())},
            t_.faces.data(),
            t_.loops.data(),
            t_.edges.data(),
            static_cast<int>(t_.faces.size()),
            static_cast<int>(t_.edges.size()),
            t_.half_cosines.data(),
            Vec3::Zero(),
            t_.inner} {
}

core::Result<BuiltHull> build_hull(std::span<const Vec3> points, const HullOptions& options) {
    using Built = core::Result<BuiltHull>;
    std::string reason = why_unfit_points(points, options);
    if (!reason.empty()) {
        return Built::failure(std::move(reason));
    }
    std::vector<Vec3d> exact;
    exact.reserve(points.size());
    Aabb box{points[0], points[0]};
    for (const Vec3& p : points) {
        exact.emplace_back(p.cast<double>());
        box = {box.lower.cwiseMin(p), box.upper.cwiseMax(p)};
    }
    const double extent = (box.upper - box.lower).maxCoeff();
    if (!(extent <= kMaxSize)) {
        return Built::failure("hull: larger than " + std::to_string(kMaxSize) + " m");
    }
    const double tolerance = tolerance_of(options, extent);
    core::Result<TriangleHull> triangles = quickhull(exact, options.max_vertices, tolerance);
    if (!triangles) {
        return Built::failure(triangles.error());
    }
    FaceLoops loops = merge_faces(exact, *triangles, tolerance);
    std::vector<Vec3d> corners = compact(exact, loops);
    const MassProperties solid = mass_of(corners, loops);
    const core::Result<PrincipalAxes> axes = principal_axes(solid.inertia);
    if (!(solid.mass > 0.0) || !axes) {
        return Built::failure("hull: has no volume");
    }
    for (Vec3d& c : corners) {
        c = axes->rotation.transpose() * (c - solid.centre);
    }
    HullTables tables;
    fill_corners(corners, tables);
    fill_faces(corners, loops, tables);
    tables.volume = static_cast<float>(solid.mass);
    tables.moments_per_kg = (axes->moments / solid.mass).cast<float>();
    BuiltHull out;
    out.hull = std::make_shared<const ConvexHull>(std::move(tables));
    out.frame = {solid.centre.cast<float>(),
                 Quat(Eigen::Quaterniond(axes->rotation).normalized().cast<float>())};
    out.cut_off = static_cast<float>(triangles->cut_off);
    if (!(thickness(out.hull->view()) >= kMinSize)) {
        return Built::failure("hull: thinner than " + std::to_string(kMinSize) + " m");
    }
    return out;
}

Shape Shape::hull(std::shared_ptr<const ConvexHull> hull) {
    Shape shape;
    shape.kind = ShapeKind::kHull;
    shape.geometry = std::move(hull);
    return shape;
}

}  // namespace zoned::physics
