#include "server/spatial/broadphase_kind.h"

namespace zoned::spatial {

std::string_view name_of(BroadphaseKind kind) {
    switch (kind) {
        case BroadphaseKind::kAutomatic:
            return "automatic";
        case BroadphaseKind::kAllPairs:
            return "all_pairs";
        case BroadphaseKind::kGrid:
            return "grid";
        case BroadphaseKind::kOctree:
            return "octree";
        case BroadphaseKind::kQuadtree:
            return "quadtree";
        case BroadphaseKind::kSortAndSweep:
            return "sort_and_sweep";
        case BroadphaseKind::kTree:
            return "tree";
    }
    return "unknown";
}

BroadphaseKind choose_kind(std::uint32_t boxes) {
    return boxes <= 32 ? BroadphaseKind::kAllPairs : BroadphaseKind::kTree;
}

}  // namespace zoned::spatial
