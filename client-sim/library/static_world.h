// StaticWorld: boxes, doors, platforms and ground of a zone in world coordinates, for the C
// interface.
#pragma once

#include "client-sim/library/sized_struct.h"
#include "client-sim/library/zoned_client.h"
#include "client-sim/view/world_info.h"

namespace zoned::library {

/// A vector into an array of three numbers.
template <class Number, class Vector>
void give_vector(Number (&out)[3], const Vector& from) {
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = static_cast<Number>(from[axis]);
    }
}

inline void give_quaternion(float (&out)[4], const Quat& from) {
    out[0] = from.x();
    out[1] = from.y();
    out[2] = from.z();
    out[3] = from.w();
}

[[nodiscard]] zoned_client_zone_info zone_info(const view::ZoneInfo& zone);

/// The boxes, then the doors as they are at `tick` and the platforms as they are at `own_tick`.
void add_boxes(const view::ZoneInfo& zone,
               Tick tick,
               Tick own_tick,
               SizedArray<zoned_client_box>& out);

/// Nine numbers for each of the first `capacity` triangles; returns how many there are.
std::size_t copy_triangles(const view::ZoneInfo& zone, double* out, std::size_t capacity);

}  // namespace zoned::library
