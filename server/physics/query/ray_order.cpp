#include "server/physics/query/ray_order.h"

#include "server/physics/shapes/ranges.h"
#include "server/spatial/morton.h"

#include <algorithm>
#include <utility>

namespace zoned::physics {

void order_rays(std::span<const Ray> rays, std::span<QueryHit> hits) {
    Aabb box = Aabb{Vec3::Constant(kMaxCoordinate), Vec3::Constant(-kMaxCoordinate)};
    for (const Ray& ray : rays) {
        if (fit_position(ray.origin)) {
            box = {box.lower.cwiseMin(ray.origin), box.upper.cwiseMax(ray.origin)};
        }
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
        hits[i].body = BodyId(spatial::morton_code(rays[i].origin, box));
        hits[i].user = static_cast<std::uint32_t>(i);
    }
    std::sort(hits.begin(), hits.end(), [](const QueryHit& a, const QueryHit& b) {
        return a.body.value != b.body.value ? a.body.value < b.body.value : a.user < b.user;
    });
}

/// Follows the cycles of the permutation: each swap brings one hit to where it stays.
void put_in_place(std::span<QueryHit> hits) {
    for (std::size_t k = 0; k < hits.size(); ++k) {
        while (hits[k].user != k) {
            std::swap(hits[k], hits[hits[k].user]);
        }
    }
}

}  // namespace zoned::physics
