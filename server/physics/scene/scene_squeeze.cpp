// Bodies that are squeezed: movers and static bodies are endlessly heavy, and two that close on a
// body at an angle throw it out as fast as the angle is small.
#include "server/physics/scene/scene_impl.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// The hardest blow of one mover gives a body at rest twice the mover's speed (restitution 1).
constexpr float kOfMovers = 2.0F;
/// Overlaps are undone no faster than this besides, m/s.
constexpr float kPushedApart_mps = 3.0F;

}  // namespace

/// A body is squeezed if a mover and at least one other mover or static body press on it, and
/// nothing else holds it. It leaves no faster than kOfMovers times the fastest of them, or than it
/// came: a lone blow, a lift and a push along the ground are slower. What has no mass takes no
/// momentum from anybody.
void Scene::Impl::limit_squeezed(float dt) {
    if (bodies.mover_list.empty()) {
        return;
    }
    list_pressed_by_movers();
    for (const std::uint32_t index : solve_list) {
        const Pair& pair = graph.pair(index);
        note_press(pair.a, pair.b, graph[index].step_impulse);
        note_press(pair.b, pair.a, graph[index].step_impulse);
    }
    for (const SqueezedBody& body : squeezed) {
        if (body.several && !body.held) {
            slow_squeezed(body, dt);
        }
    }
}

/// In the order of contacts, which threads do not change; `squeeze_place` leads to them.
void Scene::Impl::list_pressed_by_movers() {
    squeezed.clear();
    squeeze_place.resize(bodies.rows(), kNoIndex);
    for (const std::uint32_t index : solve_list) {
        const Pair& pair = graph.pair(index);
        for (const auto& [row, other] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)}) {
            const bool pressed = bodies.kind[other] == BodyKind::kKinematic &&
                                 bodies.simulated(row) && graph[index].step_impulse > 0.0F;
            const std::uint32_t place = squeeze_place[row];
            const bool listed = place < squeezed.size() && squeezed[place].row == row;
            if (pressed && !listed) {
                squeeze_place[row] = static_cast<std::uint32_t>(squeezed.size());
                squeezed.push_back({row, other, 0.0F, false, bodies.first_joint[row] != kNoIndex});
            }
        }
    }
}

void Scene::Impl::note_press(std::uint32_t row, std::uint32_t other, float impulse) {
    const std::uint32_t place = squeeze_place[row];
    if (place >= squeezed.size() || squeezed[place].row != row || !(impulse > 0.0F)) {
        return;
    }
    SqueezedBody& body = squeezed[place];
    body.several = body.several || other != body.first;
    body.held = body.held || bodies.inv_mass[other] > 0.0F;
    const Vec3 arm = bodies.position[row] - bodies.position[other];
    const Vec3 surface = bodies.velocity[other] + bodies.angular_velocity[other].cross(arm);
    body.fastest_mps = std::max(body.fastest_mps, surface.norm());
}

void Scene::Impl::slow_squeezed(const SqueezedBody& body, float dt) {
    const StepStart& start = starts[body.row];
    const float most = std::max((start.velocity + dt * settings.gravity).norm(),
                                kOfMovers * body.fastest_mps + kPushedApart_mps);
    // A blow off the centre turns the surface no faster than the mover comes (a rod: 0.87 of it).
    const float spin = bodies.angular_velocity[body.row].norm();
    const float most_spin = std::max(
        start.spin.norm(), (body.fastest_mps + kPushedApart_mps) / bodies.radius[body.row]);
    const float speed = bodies.velocity[body.row].norm();
    bodies.velocity[body.row] *= speed > most ? most / speed : 1.0F;
    bodies.angular_velocity[body.row] *= spin > most_spin ? most_spin / spin : 1.0F;
    // Within the step it may have been faster than it is in the end.
    const Vec3 way = bodies.position[body.row] - start.position;
    const float far_m = way.norm();
    const float share = far_m > most * dt ? most * dt / far_m : 1.0F;
    Quat orientation = bodies.orientation[body.row];
    const float cosine = orientation.dot(start.orientation);
    const float most_sine = 0.5F * most_spin * dt;
    if (1.0F - cosine * cosine > most_sine * most_sine) {
        const Vec3 half = 0.5F * dt * bodies.angular_velocity[body.row];
        orientation = (Quat(1.0F, half.x(), half.y(), half.z()) * start.orientation).normalized();
    } else if (share == 1.0F) {
        return;
    }
    bodies.set_pose(body.row, start.position + share * way, orientation);
}

}  // namespace zoned::physics
