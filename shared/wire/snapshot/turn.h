// Turns: rotation vectors and quaternions into each other, with the same bits everywhere.
#pragma once

#include "shared/wire/snapshot/snapshot.h"

namespace zoned::wire::snapshot {

/// Axis times angle, rad, at most pi long.
using Turn = std::array<float, 3>;

/// a after b.
Rotation operator*(const Rotation& a, const Rotation& b);
Rotation conjugate(const Rotation& r);

/// The turn from one orientation to another, the short way round, to 1e-6 rad. Sums, products,
/// quotients and roots alone: libraries differ in the last bit of sine and arc.
Turn turn_between(const Rotation& from, const Rotation& to);

/// The orientation after a turn from another, to 1e-6; turns of more than pi count as pi,
/// those that no float holds the square of as none.
Rotation turned(const Rotation& from, const Turn& turn);

}  // namespace zoned::wire::snapshot
