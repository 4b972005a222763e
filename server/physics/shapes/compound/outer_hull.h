// Outer hull: one convex hull around all parts of a compound, for a view from afar.
#pragma once

#include "server/physics/shapes/compound/compound.h"

namespace zoned::physics {

struct OuterHull {
    /// In the compound's own frame, so that a body changes from one to the other where it stands.
    std::shared_ptr<const Compound> compound;
    /// How far the parts stand out of the hull at most, m: round parts are cut to corners, and of
    /// many corners only the farthest are kept.
    float cut_off = 0.0F;
};

/// The hull of the parts that have a mass, with the first one's material and filter. It rests on
/// level ground as the compound does, where the compound's parts have corners. Fails with the
/// reason where none can be built.
core::Result<OuterHull> outer_hull_of(const Compound& compound);

}  // namespace zoned::physics
