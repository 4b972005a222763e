// Questions to a scene between steps: rays, boxes, islands.
#include "server/physics/scene_impl.h"
#include "server/physics/shape_ray.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

bool Scene::ray_cast(const Vec3& origin,
                     const Vec3& direction,
                     float max_distance,
                     std::uint32_t ignore_user,
                     RayHit& hit) const {
    const float length = direction.norm();
    if (!origin.allFinite() || !std::isfinite(length) || length <= 0.0F ||
        !(max_distance >= 0.0F)) {
        return false;
    }
    const Bodies& bodies = impl_->bodies;
    const Vec3 along = direction / length;
    std::uint32_t best = kNoIndex;
    const auto test = [&](std::uint32_t row, float limit) {
        if (bodies.sensor[row] != 0 || (ignore_user != 0 && bodies.user[row] == ignore_user)) {
            return limit;
        }
        float t = 0.0F;
        Vec3 normal = Vec3::Zero();
        if (!cast_ray(impl_->placed(row), origin, along, limit, t, normal)) {
            return limit;
        }
        // Of two at the same distance the lower row wins, whatever the order of the grid.
        if (best != kNoIndex && t == limit && row >= best) {
            return limit;
        }
        best = row;
        hit.normal = normal;
        return t;
    };
    float limit = max_distance;
    for (const std::uint32_t row : impl_->planes) {
        limit = test(row, limit);
    }
    for (const spatial::BoxIndex& boxes : impl_->boxes) {
        limit = boxes.cast({origin, along, Vec3::Zero()}, limit, test);
    }
    if (best == kNoIndex) {
        return false;
    }
    hit.body = bodies.id_of(best);
    hit.user = bodies.user[best];
    hit.distance = limit;
    hit.point = origin + limit * along;
    return true;
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
