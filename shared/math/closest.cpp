#include "shared/math/closest.h"

#include <algorithm>
#include <cmath>

namespace zoned {

namespace {

/// Below this distance the direction between the closest points is rounding noise.
constexpr float kTouching = 1e-6F;

float outside(float x, float h) {
    return x > h ? x - h : (x < -h ? x + h : 0.0F);
}

/// Half the derivative of the squared distance with respect to t at middle + t half.
float slope_at(float t, const Vec3& middle, const Vec3& half, const Vec3& h) {
    return half.x() * outside(middle.x() + t * half.x(), h.x()) +
           half.y() * outside(middle.y() + t * half.y(), h.y()) +
           half.z() * outside(middle.z() + t * half.z(), h.z());
}

/// The t in [-1, 1] where the segment is closest to the box; the least one where several are.
float closest_parameter(const Vec3& middle, const Vec3& half, const Vec3& h) {
    float lo = -1.0F;
    float slope_lo = slope_at(lo, middle, half, h);
    if (slope_lo >= 0.0F) {
        return lo;
    }
    float hi = 1.0F;
    float slope_hi = slope_at(hi, middle, half, h);
    if (slope_hi <= 0.0F) {
        return hi;
    }
    // Narrow [lo, hi] by the points where the segment crosses a face's plane: between two of them
    // the slope is linear.
    for (int axis = 0; axis < 3; ++axis) {
        if (half[axis] == 0.0F) {
            continue;
        }
        for (const float face : {-h[axis], h[axis]}) {
            const float t = (face - middle[axis]) / half[axis];
            if (t > lo && t < hi) {
                const float slope = slope_at(t, middle, half, h);
                if (slope < 0.0F) {
                    lo = t;
                    slope_lo = slope;
                } else {
                    hi = t;
                    slope_hi = slope;
                }
            }
        }
    }
    return std::clamp(lo - slope_lo * (hi - lo) / (slope_hi - slope_lo), lo, hi);
}

/// The least translation that parts a segment from a box that it intersects.
SegmentBoxDistance least_translation(const Vec3& middle, const Vec3& half, const Vec3& h) {
    SegmentBoxDistance best;
    float least = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
        const float overlap = h[axis] + std::abs(half[axis]) - std::abs(middle[axis]);
        if (axis == 0 || overlap < least) {
            least = overlap;
            best.faces = Vec3::Zero();
            best.faces[axis] = middle[axis] < 0.0F ? -1.0F : 1.0F;
            best.normal = best.faces;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 cross = half.cross(Vec3::Unit(axis));
        const float length = cross.norm();
        if (length <= 1e-3F * half.norm()) {
            continue;  // nearly parallel: the faces speak for this axis
        }
        const float across = cross.dot(middle);
        const float overlap = (h.dot(cross.cwiseAbs()) - std::abs(across)) / length;
        // A face is preferred to an edge that is no better but for rounding: its normal is exact.
        if (overlap < 0.999F * least) {
            least = overlap;
            best.normal = cross * ((across < 0.0F ? -1.0F : 1.0F) / length);
            best.faces = best.normal.cwiseSign();
        }
    }
    best.distance = -least;
    return best;
}

}  // namespace

SegmentBoxDistance segment_box_distance(const Vec3& middle,
                                        const Vec3& half,
                                        const Vec3& half_extents) {
    const float t = closest_parameter(middle, half, half_extents);
    Vec3 apart;
    Vec3 faces;
    for (int axis = 0; axis < 3; ++axis) {
        apart[axis] = outside(middle[axis] + t * half[axis], half_extents[axis]);
        faces[axis] = apart[axis] > 0.0F ? 1.0F : (apart[axis] < 0.0F ? -1.0F : 0.0F);
    }
    const float distance = apart.norm();
    if (distance < kTouching) {
        return least_translation(middle, half, half_extents);
    }
    return {apart / distance, distance, faces};
}

}  // namespace zoned
