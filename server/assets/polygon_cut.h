// Polygon cut: splits a polygon in space into triangles.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::assets {

/// Cuts a polygon of three corners or more, flat or nearly so, into triangles that face as it does.
/// There are two less of them than corners; some have no area where corners coincide or lie in a
/// line. Appends numbers of corners to `out`. A quadrilateral is cut along its shorter diagonal
/// where both lie within. False when the outline crosses itself so that there is nothing to cut
/// off: the caller then throws the appended numbers away.
///
/// By cutting ears off the polygon as seen along its normal (Meisters, "Polygons have ears",
/// American Mathematical Monthly 82, 1975): the square of the corners, the cube at worst.
bool cut_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& out);

}  // namespace zoned::assets
