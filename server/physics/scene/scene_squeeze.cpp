// Bodies that are squeezed: movers and static bodies are endlessly heavy, and two that close on a
// body from nearly opposite sides throw it out as fast as the angle between them is small.
#include "server/physics/scene/scene_impl.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Two surfaces of which the normals into the body have a cosine below this squeeze it: a wedge of
/// 60 degrees or less, which is faster than twice what closes it.
constexpr float kOpposite = -0.5F;
/// Overlaps are undone no faster than this besides, m/s.
constexpr float kPushedApart_mps = 3.0F;

}  // namespace

/// Looks at what movers press on: where nothing moves by itself, at nothing.
void Scene::Impl::limit_squeezed(float dt) {
    squeezed.clear();
    for (const std::uint32_t mover : bodies.mover_list) {
        graph.for_each_of(bodies, mover, [&](std::uint32_t /*contact*/, std::uint32_t row) {
            if (bodies.simulated(row)) {
                squeezed.push_back(row);
            }
        });
    }
    std::sort(squeezed.begin(), squeezed.end());
    squeezed.erase(std::unique(squeezed.begin(), squeezed.end()), squeezed.end());
    for (const std::uint32_t row : squeezed) {
        if (bodies.first_joint[row] == kNoIndex) {
            list_presses(row);
            const float fastest_mps = fastest_squeeze();
            if (fastest_mps >= 0.0F) {
                slow_squeezed(row, fastest_mps, dt);
            }
        }
    }
}

/// All that presses on the body; nothing where something that has a mass does: it takes and gives
/// momentum.
void Scene::Impl::list_presses(std::uint32_t row) {
    presses.clear();
    bool held = false;
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        const Vec3 arm = bodies.position[row] - bodies.position[other];
        const Vec3 surface = bodies.velocity[other] + bodies.angular_velocity[other].cross(arm);
        graph.for_chain(contact, [&](std::uint32_t record) {
            const Contact& at = graph[record];
            // A record without points is of no solve.
            if (graph.pair(record).count > 0 && at.step_impulse > 0.0F) {
                held = held || bodies.inv_mass[other] > 0.0F;
                presses.push_back({graph.pair(contact).a == row ? -at.normal : at.normal,
                                   (1.0F + at.grip.restitution) * surface.norm(),
                                   bodies.kind[other] == BodyKind::kKinematic});
            }
        });
    });
    if (held) {
        presses.clear();
    }
}

/// Of what squeezes it together with something opposite, m/s; below 0: nothing does.
float Scene::Impl::fastest_squeeze() const {
    float fastest_mps = -1.0F;
    for (const Press& mover : presses) {
        for (const Press& other : presses) {
            if (mover.moves && mover.normal.dot(other.normal) < kOpposite) {
                fastest_mps = std::max({fastest_mps, mover.blow_mps, other.blow_mps});
            }
        }
    }
    return fastest_mps;
}

/// A blow leaves a body its speed across, and gives it that of what strikes it, with what bounces.
/// A squeezed body gets no more than by one blow in a step.
void Scene::Impl::slow_squeezed(std::uint32_t row, float blow_mps, float dt) {
    const StepStart& start = starts[row];
    const float push_mps = blow_mps + kPushedApart_mps;
    const float most = elementary::hypot((start.velocity + dt * settings.gravity).norm(), push_mps);
    // Off the centre it turns the surface no faster than it comes (a rod: 0.87 of it).
    const float most_spin = std::max(start.spin.norm(), push_mps / bodies.radius[row]);
    const float speed = bodies.velocity[row].norm();
    const float spin = bodies.angular_velocity[row].norm();
    bodies.velocity[row] *= speed > most ? most / speed : 1.0F;
    bodies.angular_velocity[row] *= spin > most_spin ? most_spin / spin : 1.0F;
    // Within the step it may have been faster than it is in the end.
    const Vec3 way = bodies.position[row] - start.position;
    const float far_m = way.norm();
    const float share = far_m > most * dt ? most * dt / far_m : 1.0F;
    Quat orientation = bodies.orientation[row];
    const float sine = 2.0F * (orientation * start.orientation.conjugate()).vec().norm();
    if (sine > most_spin * dt) {
        const Vec3 half = 0.5F * dt * bodies.angular_velocity[row];
        orientation = (Quat(1.0F, half.x(), half.y(), half.z()) * start.orientation).normalized();
    } else if (share == 1.0F) {
        return;
    }
    bodies.set_pose(row, start.position + share * way, orientation);
}

}  // namespace zoned::physics
