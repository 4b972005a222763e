#include "server/physics/narrowphase/surface_face.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

constexpr std::array<std::uint8_t, 3> kLoop = {0, 1, 2};
constexpr std::array<HullEdge, 3> kEdges = {{{0, 1, 0, 0}, {1, 2, 0, 0}, {2, 0, 0, 0}}};

/// Corners whose height along a direction differs by less than this share of the edge between them
/// are equally high: the edge touches as a whole. As kParallel.
constexpr float kLevelEdge = 5.0e-3F;

float signed_unit(float x) {
    return x >= 0.0F ? 1.0F : -1.0F;
}

}  // namespace

SurfaceFace::SurfaceFace(const Triangle& triangle) : triangle_(triangle) {
    for (std::size_t i = 0; i < kGroup; ++i) {
        const Vec3& p = triangle.corner[std::min<std::size_t>(i, 2)];
        x_[i] = p.x();
        y_[i] = p.y();
        z_[i] = p.z();
    }
    face_ = {triangle.normal, triangle.normal.dot(triangle.corner[0]), 0, 3};
}

HullView SurfaceFace::view() const {
    return {{x_.data(), y_.data(), z_.data(), kGroup}, &face_, kLoop.data(), kEdges.data(), 1, 3};
}

/// Whether the surface has this normal at the feature of the triangle that is farthest along it.
bool SurfaceFace::allows(const Vec3& unit) const {
    std::array<float, 3> height{};
    for (std::size_t i = 0; i < 3; ++i) {
        height[i] = unit.dot(triangle_.corner[i]);
    }
    const std::size_t top =
        static_cast<std::size_t>(std::max_element(height.begin(), height.end()) - height.begin());
    const std::size_t before = (top + 2) % 3;
    const std::size_t after = (top + 1) % 3;
    const float level_before = kLevelEdge * triangle_.edge(before).norm();
    const float level_after = kLevelEdge * triangle_.edge(top).norm();
    const bool along_before = height[top] - height[before] <= level_before;
    const bool along_after = height[top] - height[after] <= level_after;
    if (along_before && along_after) {
        return unit.dot(triangle_.normal) > 0.0F;
    }
    return (along_after || triangle_.allows(before, unit)) &&
           (along_before || triangle_.allows(top, unit));
}

void SurfaceFace::test_faces(const HullView& hull,
                             float margin,
                             float scale,
                             HullAxis& best) const {
    for (int f = 0; f < hull.face_count; ++f) {
        const HullFace& face = hull.faces[f];
        const float gap = std::min({face.normal.dot(triangle_.corner[0]),
                                    face.normal.dot(triangle_.corner[1]),
                                    face.normal.dot(triangle_.corner[2])}) -
                          face.offset;
        if (gap > margin) {
            // Apart, whether the surface has this normal or not.
            best = {gap, AxisKind::kFaceB, 0, f, -face.normal};
            return;
        }
        const float bias = best.kind == AxisKind::kFaceA ? kFaceBias * scale : 0.0F;
        if (gap > best.separation + bias && allows(-face.normal)) {
            best = {gap, AxisKind::kFaceB, 0, f, -face.normal};
        }
    }
}

/// Whether an axis on the arc of edge i may have a gap greater than `least` to a hull whose lowest
/// corner is given. The gap is at most that of the corner alone: see NearEdges for the bound.
bool SurfaceFace::may_part(std::size_t i, const Vec3& foot, float least) const {
    const EdgeBend& bend = triangle_.bend[i];
    const Vec3 up = foot - triangle_.corner[i];
    if (bend.cosine < 0.0F) {
        return up.norm() > least;
    }
    const float height = triangle_.normal.dot(up);
    const float aside = triangle_.outward(i).dot(up);
    const float most = std::max(height, bend.cosine * height + bend.sine * aside);
    const float half_cosine = std::sqrt(0.5F * (1.0F + bend.cosine));
    return most > std::min(least, least * half_cosine);
}

/// The arc of an edge of the surface runs from the triangle's normal to the end of the bend. An arc
/// longer than a quarter circle is tested in two pieces, since the test of crossing arcs takes the
/// shorter arc between two ends.
void SurfaceFace::test_edges(const HullView& hull, float least, HullAxis& best) const {
    constexpr float kLeastBend = 1.0e-2F;
    const Vec3 foot = hull.points[support(hull.points, -triangle_.normal)];
    for (std::size_t i = 0; i < 3; ++i) {
        const EdgeBend& bend = triangle_.bend[i];
        if ((bend.sine < kLeastBend && bend.cosine > 0.0F) || !may_part(i, foot, least)) {
            continue;
        }
        const Vec3 from = triangle_.corner[i];
        const Vec3 direction = triangle_.edge(i);
        const Vec3 outward = triangle_.outward(i);
        const Vec3 end = bend.cosine * triangle_.normal + bend.sine * outward;
        const bool wide = bend.cosine < 0.0F;
        for (int j = 0; j < hull.edge_count; ++j) {
            const HullEdge& edge = hull.edges[j];
            const Vec3 pb = hull.points[edge.from];
            const Vec3 db = hull.points[edge.to] - pb;
            const float cba = hull.faces[edge.left].normal.dot(direction);
            const float dba = hull.faces[edge.right].normal.dot(direction);
            if (!(cba * dba < 0.0F)) {
                continue;
            }
            const auto crosses = [&](const Vec3& left, const Vec3& right) {
                const float adc = db.dot(left);
                const float bdc = db.dot(right);
                return adc * bdc < 0.0F && cba * bdc < 0.0F;
            };
            const bool meets = wide ? crosses(triangle_.normal, outward) || crosses(outward, end)
                                    : crosses(triangle_.normal, end);
            Vec3 axis = direction.cross(db);
            const float length2 = axis.squaredNorm();
            if (!meets ||
                length2 < kParallel * kParallel * direction.squaredNorm() * db.squaredNorm()) {
                continue;
            }
            axis *= signed_unit(axis.dot(wide ? outward : Vec3(triangle_.normal + end))) /
                    std::sqrt(length2);
            const float gap = axis.dot(pb - from);
            if (gap > best.separation) {
                best = {gap, AxisKind::kEdges, static_cast<int>(i), j, axis};
            }
        }
    }
}

HullAxes SurfaceFace::find_axes(const HullView& hull, float margin, float scale) const {
    HullAxes out;
    out.face.separation = lowest(hull.points, triangle_.normal) - face_.offset;
    out.face.normal = triangle_.normal;
    if (out.face.separation > margin) {
        return out;
    }
    test_faces(hull, margin, scale, out.face);
    if (out.face.separation <= margin) {
        test_edges(hull, out.face.separation + kEdgeBias * scale, out.edges);
    }
    return out;
}

}  // namespace zoned::physics
