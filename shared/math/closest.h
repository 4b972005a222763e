// closest: the closest points between a segment and a box: distance, direction and the nearest
// faces.
#pragma once

#include "shared/math/types.h"

namespace zoned {

/// Position of a segment relative to a box, in the box's own axes with the box's centre as origin.
struct SegmentBoxDistance {
    /// Unit vector from the box to the segment: moving the segment along it parts the two.
    Vec3 normal = Vec3::UnitY();
    /// Metres; negative where they intersect. Its magnitude is then the least translation along
    /// `normal` that separates them.
    float distance = 0.0F;
    /// Per axis the sign of the face that the closest point of the box lies on, 0 for none: one
    /// entry other than zero is a face, two an edge, three a corner.
    Vec3 faces = Vec3::Zero();
};

/// Distance of the segment middle +- half to the box [-half_extents, half_extents], all in box axes
/// and metres. Exact up to rounding: the squared distance along the segment is convex and piecewise
/// quadratic, its minimum is found from the zero of its piecewise linear derivative. Where segment
/// and box intersect (or touch within a micrometre) the separating axes of segment and box are
/// compared instead (Gottschalk, Lin, Manocha, "OBBTree", SIGGRAPH 1996). A segment of length zero
/// is a point.
SegmentBoxDistance segment_box_distance(const Vec3& middle,
                                        const Vec3& half,
                                        const Vec3& half_extents);

}  // namespace zoned
