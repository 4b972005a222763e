// Broadphase part of a step: which pairs of bodies may touch.
#include "server/physics/bounds.h"
#include "server/physics/scene_impl.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// How far a body may go before the grid hears of it again, m.
constexpr float kFatMargin = 0.05F;

/// True when some part of the box lies below the plane.
bool dips_into(const Aabb& box, const Vec3& origin, const Vec3& up) {
    const Vec3 centre = 0.5F * (box.lower + box.upper);
    const Vec3 half = 0.5F * (box.upper - box.lower);
    return up.dot(centre - origin) <= up.cwiseAbs().dot(half);
}

}  // namespace

/// Sees to it that the fat box of each body that may move holds all that it can reach in the step.
void Scene::Impl::refresh_bounds(float dt) {
    const auto refresh = [&](std::uint32_t row, const Vec3& pull) {
        const Vec3 travel = dt * bodies.velocity[row] + dt * dt * pull;
        // Turning carries no point farther than the arc, nor out of the bounding sphere.
        const float turn = std::min(1.0F, dt * bodies.angular_velocity[row].norm());
        const bool turns = bodies.shape[row].kind != ShapeKind::kSphere;
        const float spread = kContactMargin + (turns ? turn * bodies.radius[row] : 0.0F);
        const Aabb reach = swept(bodies.bounds[row].grown(spread), travel);
        if (!encloses(bodies.fat[row], reach)) {
            bodies.fat[row] = reach.grown(kFatMargin);
            grid_of(row).update(row, bodies.fat[row]);
            pending.push_back(row);
        }
    };
    for (const std::uint32_t row : bodies.awake_list) {
        refresh(row, settings.gravity);
    }
    for (const std::uint32_t row : bodies.mover_list) {
        refresh(row, Vec3::Zero());
    }
}

/// The grids answer ray casts and boxes between steps too, so their boxes must hold the bodies
/// wherever the solver put them.
void Scene::Impl::follow_bounds() {
    for (const auto* list : {&bodies.awake_list, &bodies.mover_list}) {
        for (const std::uint32_t row : *list) {
            if (!encloses(bodies.fat[row], bodies.bounds[row])) {
                bodies.fat[row] = bodies.bounds[row].grown(kContactMargin + kFatMargin);
                grid_of(row).update(row, bodies.fat[row]);
                pending.push_back(row);
            }
        }
    }
}

bool Scene::Impl::near(std::uint32_t a, std::uint32_t b) const {
    if (bodies.is_plane(a)) {
        return dips_into(bodies.fat[b], bodies.position[a], bodies.rotation[a].col(1));
    }
    if (bodies.is_plane(b)) {
        return dips_into(bodies.fat[a], bodies.position[b], bodies.rotation[b].col(1));
    }
    return bodies.fat[a].overlaps(bodies.fat[b]);
}

/// Looks for partners of the bodies whose box is new. At least one of a pair is dynamic.
void Scene::Impl::find_pairs(float dt) {
    new_pairs.clear();
    for (const std::uint32_t row : pending) {
        const auto meet = [&](std::uint32_t other) {
            if (other != row && !graph.contains(row, other)) {
                new_pairs.emplace_back(std::min(row, other), std::max(row, other));
            }
        };
        if (bodies.is_plane(row)) {
            for (std::uint32_t other = 0; other < bodies.rows(); ++other) {
                if (bodies.alive[other] != 0 && bodies.is_dynamic(other) && near(row, other)) {
                    meet(other);
                }
            }
            continue;
        }
        grids[static_cast<std::size_t>(BodyKind::kDynamic)].query(bodies.fat[row], meet);
        if (bodies.is_dynamic(row)) {
            grids[static_cast<std::size_t>(BodyKind::kStatic)].query(bodies.fat[row], meet);
            grids[static_cast<std::size_t>(BodyKind::kKinematic)].query(bodies.fat[row], meet);
            for (const std::uint32_t plane : planes) {
                if (near(row, plane)) {
                    meet(plane);
                }
            }
        }
    }
    pending.clear();
    // Two new boxes find each other twice; the order must not depend on the grid's history.
    std::sort(new_pairs.begin(), new_pairs.end());
    new_pairs.erase(std::unique(new_pairs.begin(), new_pairs.end()), new_pairs.end());
    for (const auto& [a, b] : new_pairs) {
        const std::uint32_t contact = graph.create(bodies, a, b);
        if (graph[contact].active_place == kNoIndex) {
            // Nobody will look at a pair at rest again: it must know now whether it touches.
            update_contact(contact, dt);
            graph[contact].touching =
                graph[contact].count > 0 && graph[contact].points[0].separation <= kTouch;
        }
    }
}

}  // namespace zoned::physics
