// Questions to a scene between steps that need no Query: boxes, islands.
#include "server/physics/scene/scene_impl.h"

#include <algorithm>

namespace zoned::physics {

Query Scene::query() const {
    return Query(*this);
}

bool Scene::ray_cast(const Vec3& origin,
                     const Vec3& direction,
                     float max_distance,
                     std::uint32_t ignore_user,
                     RayHit& hit) const {
    QueryFilter filter;
    filter.ignore_user = ignore_user;
    return query().ray({origin, direction, max_distance}, filter, hit);
}

void Scene::overlap(const Aabb& area, std::vector<BodyId>& out) const {
    const Bodies& bodies = impl_->bodies;
    const std::size_t first = out.size();
    for (const spatial::BoxIndex& boxes : impl_->boxes) {
        boxes.query(area, [&](std::uint32_t row) {
            if (bodies.bounds[row].overlaps(area)) {
                out.push_back(bodies.id_of(row));
            }
        });
    }
    for (const std::uint32_t row : impl_->planes) {
        const Vec3 up = bodies.rotation[row].col(1);
        const Vec3 centre = 0.5F * (area.lower + area.upper);
        const Vec3 half = 0.5F * (area.upper - area.lower);
        if (up.dot(centre - bodies.position[row]) <= up.cwiseAbs().dot(half)) {
            out.push_back(bodies.id_of(row));
        }
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
}

void Scene::island_of(BodyId body, std::vector<BodyId>& out) const {
    const Bodies& bodies = impl_->bodies;
    const std::uint32_t start = bodies.row_of(body);
    if (start == kNoIndex) {
        return;
    }
    std::vector<std::uint8_t>& marks = impl_->marks;
    marks.resize(bodies.rows(), 0);
    const std::size_t first = out.size();
    out.push_back(body);
    marks[start] = 1;
    for (std::size_t i = first; i < out.size(); ++i) {
        const std::uint32_t row = (out[i].value & 0xFFFFFU) - 1;
        impl_->graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
            if (impl_->graph.pair(contact).touching && bodies.is_dynamic(other) &&
                marks[other] == 0) {
                marks[other] = 1;
                out.push_back(bodies.id_of(other));
            }
        });
    }
    for (std::size_t i = first; i < out.size(); ++i) {
        marks[(out[i].value & 0xFFFFFU) - 1] = 0;
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
}

}  // namespace zoned::physics
