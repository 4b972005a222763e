#include "tests/scenario/overlaps.h"

#include "tests/scenario/penetration.h"

#include <algorithm>
#include <cstddef>

namespace zoned::scenario {

namespace {

struct Mover {
    std::size_t index;
    double reach;
    double lower;  ///< of its bounding sphere along x
};

}  // namespace

Overlaps find_overlaps(std::span<const Body> bodies, std::span<const Pose> poses) {
    Overlaps found;
    const auto keep = [](double depth, std::vector<double>& list) {
        if (depth > 0.0) {
            list.push_back(depth);
        }
    };
    std::vector<Mover> movers;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const bool finite =
            poses[i].position.allFinite() && poses[i].orientation.coeffs().allFinite();
        if (bodies[i].mass > 0.0 && finite) {
            const double reach = bounding_radius(bodies[i].solid);
            movers.push_back({i, reach, poses[i].position.x() - reach});
        }
    }
    for (const Mover& mover : movers) {
        const Solid& solid = bodies[mover.index].solid;
        keep(depth_below_ground(solid, poses[mover.index]), found.floor);
        for (std::size_t k = 0; k < bodies.size(); ++k) {
            if (bodies[k].mass == 0.0) {
                keep(penetration(bodies[k].solid, poses[k], solid, poses[mover.index]),
                     found.fixed);
            }
        }
    }
    // Sort and sweep along x: a body that begins before this one ends may touch it.
    std::sort(movers.begin(), movers.end(), [](const Mover& a, const Mover& b) {
        return a.lower < b.lower;
    });
    for (std::size_t i = 0; i < movers.size(); ++i) {
        const Mover& a = movers[i];
        const double end = a.lower + 2.0 * a.reach;
        for (std::size_t j = i + 1; j < movers.size() && movers[j].lower <= end; ++j) {
            const Mover& b = movers[j];
            const double reach = a.reach + b.reach;
            const Vec3d between = poses[b.index].position - poses[a.index].position;
            if (between.squaredNorm() < reach * reach) {
                keep(penetration(bodies[a.index].solid,
                                 poses[a.index],
                                 bodies[b.index].solid,
                                 poses[b.index]),
                     found.pairs);
            }
        }
    }
    return found;
}

}  // namespace zoned::scenario
