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

// Nanoseconds to tell a structure about a moved box and to find its partners, boxes of one size and
// of sizes over two decades, all of them moving, at the density of a pile (one core, g++ 12, AVX):
//
//     boxes   all pairs      grid        octree      quadtree    sort, sweep   tree
//     32       36    31    252   314    289   305    278   292    46    46     48    77
//     64       49    36    336   401    464   408    420   375    51    51     58    79
//     128      70    74    359   494    513   761    490   716    64    70     57   100
//     512     202   262    458   705    930   979    826   908   131   210     99   176
//     4096   1474  1618    883  2185   1813  2811   1629  2355   274   722    155   366
//     32768     -     -   3433 11190   5179  6129   6703  7402   827  2032    247   719
//
// Rays compare alike (210 ns against 200 ns in 128 boxes, 3.3 us against 0.46 us in 4,096), and so
// do boxes of which a tenth moves. So neither the spread of sizes nor how many move has a say.
BroadphaseKind choose_kind(std::uint32_t boxes) {
    constexpr std::uint32_t kFew = 128;
    return boxes <= kFew ? BroadphaseKind::kAllPairs : BroadphaseKind::kTree;
}

}  // namespace zoned::spatial
