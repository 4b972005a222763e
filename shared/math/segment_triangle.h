// segment_triangle: the closest points between a segment and a triangle that is solid behind.
#pragma once

#include "shared/math/types.h"

#include <array>

namespace zoned {

/// A triangle, counter-clockwise seen from the front.
struct FacedTriangle {
    std::array<Vec3, 3> corner;
    Vec3 normal = Vec3::UnitY();  ///< unit, to the front

    [[nodiscard]] float height(const Vec3& p) const { return normal.dot(p - corner[0]); }
};

/// Position of a segment relative to a triangle.
struct SegmentTriangleDistance {
    /// Unit vector from the triangle to the segment: moving the segment along it parts the two.
    Vec3 normal = Vec3::UnitY();
    /// Metres; where the segment pierces the triangle the height of its lower end over the plane,
    /// which is not positive, and `normal` is the triangle's own.
    float distance = 0.0F;
};

/// Nearest point of a triangle, and the corners of the feature that it lies on.
struct TrianglePoint {
    Vec3 point = Vec3::Zero();
    int edge = -1;    ///< lies within this edge
    int corner = -1;  ///< is this corner; neither: within the face
};

/// (Ericson, Real-Time Collision Detection, 5.1.5.)
TrianglePoint nearest_on_triangle(const std::array<Vec3, 3>& corner, const Vec3& p);

/// Distance of the segment middle +- half to a triangle with an area, in metres. Exact up to
/// rounding: unless the segment pierces the triangle, the closest points are an end of the segment
/// and a point of the triangle, or lie on the segment and an edge (Ericson, 5.1.9, 5.1.10). A
/// segment of length zero is a point.
SegmentTriangleDistance segment_triangle_distance(const Vec3& middle,
                                                  const Vec3& half,
                                                  const FacedTriangle& t);

/// Whether an axis-aligned box around `centre` and a triangle overlap; touching counts as apart
/// (separating axes; Akenine-Moeller, "Fast 3D triangle-box overlap testing", JGT 6(1), 2001).
bool box_triangle_overlap(const Vec3& centre, const Vec3& half_extents, const FacedTriangle& t);

}  // namespace zoned
