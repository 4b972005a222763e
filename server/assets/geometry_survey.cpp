#include "server/assets/geometry_survey.h"

#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/scene/stability_warnings.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

namespace zoned::assets {

namespace {

using physics::Triangle;
using physics::TriangleMesh;

template <class... Values>
std::string sentence(const char* format, Values... values) {
    char text[300];
    std::snprintf(text, sizeof(text), format, static_cast<double>(values)...);
    return text;
}

Vec3 middle_of(const Triangle& t) {
    return (t.corner[0] + t.corner[1] + t.corner[2]) / 3.0F;
}

void add(Worst& worst, float value, const Vec3& at) {
    ++worst.count;
    if (value < worst.least) {
        worst.least = value;
        worst.at = at;
    }
}

/// Where a ray meets the triangle from behind, m along it; infinite when it does not. (Moeller and
/// Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2, 1997.)
double cast_back(const Triangle& triangle, const Vec3d& o, const Vec3d& d) {
    const Vec3d a = triangle.corner[0].cast<double>();
    const Vec3d e1 = triangle.corner[1].cast<double>() - a;
    const Vec3d e2 = triangle.corner[2].cast<double>() - a;
    const Vec3d p = d.cross(e2);
    const double determinant = -e1.dot(p);
    if (!(determinant > 0.0)) {
        return INFINITY;
    }
    const Vec3d s = o - a;
    const Vec3d q = s.cross(e1);
    const double u = -s.dot(p);
    const double v = -d.dot(q);
    const double t = -e2.dot(q) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= determinant && t >= 0.0 ? std::abs(t) : INFINITY;
}

/// How far behind the middle of a triangle the surface ends, m; infinite beyond `limit`. Counts the
/// triangles that the ray was tested with.
float thickness_at(const TriangleMesh& mesh,
                   const Triangle& triangle,
                   float limit,
                   std::uint64_t& tests) {
    const Vec3 origin = middle_of(triangle);
    const Vec3 direction = -triangle.normal;
    float found = INFINITY;
    mesh.tree().cast(origin, direction, limit, [&](std::uint32_t item, float nearest) {
        ++tests;
        const double t =
            cast_back(mesh.triangle(item), origin.cast<double>(), direction.cast<double>());
        if (item != triangle.id && t <= static_cast<double>(nearest)) {
            found = static_cast<float>(t);
            return found;
        }
        return nearest;
    });
    return found;
}

template <class T>
std::size_t bytes_of(const std::vector<T>& table) {
    return table.size() * sizeof(T);
}

float farthest_of(const Aabb& box) {
    return std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
}

void add_far(float farthest, float error_budget_m, std::vector<std::string>& out) {
    const float most = physics::farthest_for(error_budget_m);
    if (farthest > most) {
        out.push_back(
            sentence("reaches %g m out, where floats are too coarse for an error budget "
                     "of %g m: at most %g m",
                     farthest,
                     error_budget_m,
                     most));
    }
}

void add_worst(const Worst& worst, const char* format, float limit, std::vector<std::string>& out) {
    if (worst.count > 0) {
        out.push_back(sentence(
            format, worst.count, limit, worst.least, worst.at.x(), worst.at.y(), worst.at.z()));
    }
}

/// Triangles that do not follow each other, so that a limited number of tests is a fair sample.
void look_behind(const TriangleMesh& mesh, MeshSurvey& out) {
    constexpr std::uint64_t kMostTests = 1U << 24;  // a few seconds at most
    constexpr std::uint64_t kStride = 2654435761U;  // a prime: comes by every triangle once
    std::uint64_t tests = 0;
    for (; out.looked < out.triangles && tests < kMostTests; ++out.looked) {
        const auto i = static_cast<std::uint32_t>(out.looked * kStride % out.triangles);
        const Triangle triangle = mesh.triangle(i);
        const float thickness = thickness_at(mesh, triangle, physics::kContactMargin, tests);
        if (thickness < physics::kContactMargin) {
            add(out.sheet, thickness, middle_of(triangle));
        }
    }
}

}  // namespace

MeshSurvey survey(const TriangleMesh& mesh, float error_budget_m) {
    const TriangleMesh::MeshTables& t = mesh.tables();
    MeshSurvey out;
    out.triangles = mesh.triangle_count();
    out.vertices = static_cast<std::uint32_t>(t.vertices.size());
    out.box = mesh.box();
    out.farthest = farthest_of(out.box);
    out.depth = t.tree.depth();
    out.nodes = t.tree.nodes();
    out.bytes = sizeof(TriangleMesh) + bytes_of(t.vertices) + bytes_of(t.corners) +
                bytes_of(t.normals) + bytes_of(t.bends) + t.tree.bytes();
    for (std::uint32_t i = 0; i < out.triangles; ++i) {
        const Triangle triangle = mesh.triangle(i);
        const Vec3 middle = middle_of(triangle);
        float longest = 0.0F;
        for (std::size_t e = 0; e < 3; ++e) {
            const float length = triangle.edge(e).norm();
            longest = std::max(longest, length);
            out.shortest_edge = std::min(out.shortest_edge, length);
        }
        out.longest_edge = std::max(out.longest_edge, longest);
        const float height = triangle.edge(0).cross(triangle.edge(1)).norm() / longest;
        if (longest < error_budget_m) {
            add(out.small, longest, middle);
        } else if (height < error_budget_m) {
            add(out.thin, height, middle);
        }
    }
    look_behind(mesh, out);
    return out;
}

FieldSurvey survey(const physics::Heightfield& field) {
    const physics::Heightfield::HeightfieldTables& t = field.tables();
    FieldSurvey out;
    out.columns = t.columns;
    out.rows = t.rows;
    out.box = field.box();
    out.box.lower.y() = t.lowest;
    out.spacing_x = t.spacing_x;
    out.spacing_z = t.spacing_z;
    out.thickness = t.thickness;
    out.farthest = farthest_of(out.box);
    out.bytes = sizeof(physics::Heightfield) + bytes_of(t.heights);
    float steepest = 0.0F;  // square of the slope
    for (std::uint32_t k = 0; k + 1 < t.rows; ++k) {
        for (std::uint32_t i = 0; i + 1 < t.columns; ++i) {
            const float h00 = field.height(i, k);
            const float h10 = field.height(i + 1, k);
            const float h01 = field.height(i, k + 1);
            const float h11 = field.height(i + 1, k + 1);
            const Vec2 first((h10 - h00) / t.spacing_x, (h11 - h10) / t.spacing_z);
            const Vec2 second((h11 - h01) / t.spacing_x, (h01 - h00) / t.spacing_z);
            const float slope = std::max(first.squaredNorm(), second.squaredNorm());
            if (slope > steepest) {
                steepest = slope;
                out.steepest_i = i;
                out.steepest_k = k;
            }
        }
    }
    out.steepest_deg =
        elementary::atan2(std::sqrt(steepest), 1.0F) * 180.0F / std::numbers::pi_v<float>;
    return out;
}

std::vector<std::string> stability_warnings_of(const MeshSurvey& mesh, float error_budget_m) {
    std::vector<std::string> out;
    add_far(mesh.farthest, error_budget_m, out);
    add_worst(mesh.small,
              "%g triangles are smaller than the error budget of %g m (longest edge %g m at "
              "%.4g %.4g %.4g): they cost time and change nothing",
              error_budget_m,
              out);
    add_worst(mesh.thin,
              "%g triangles are slivers lower than the error budget of %g m (%g m at %.4g %.4g "
              "%.4g): rounding tilts them",
              error_budget_m,
              out);
    add_worst(mesh.sheet,
              "%g triangles have the surface's other side within the contact margin of %g m behind "
              "them (%g m at %.4g %.4g %.4g): bodies on both sides of it may touch",
              physics::kContactMargin,
              out);
    return out;
}

std::vector<std::string> stability_warnings_of(const FieldSurvey& field,
                                               float level_m,
                                               float error_budget_m) {
    std::vector<std::string> out;
    add_far(field.farthest, error_budget_m, out);
    if (level_m > error_budget_m) {
        out.push_back(
            sentence("its samples are steps of %g m, coarser than the error budget of %g "
                     "m: more bits or less height make it smooth",
                     level_m,
                     error_budget_m));
    }
    const float spacing = std::min(field.spacing_x, field.spacing_z);
    if (spacing < error_budget_m) {
        out.push_back(sentence("its samples lie %g m apart, closer than the error budget of %g m",
                               spacing,
                               error_budget_m));
    }
    if (field.thickness < physics::kContactMargin) {
        out.push_back(
            sentence("is %g m thick under its lowest sample, thinner than the contact "
                     "margin of %g m",
                     field.thickness,
                     physics::kContactMargin));
    }
    return out;
}

}  // namespace zoned::assets
