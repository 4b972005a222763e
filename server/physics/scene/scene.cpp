#include "server/physics/scene/scene.h"

#include "server/physics/integrator/free_flight.h"
#include "server/physics/integrator/stability.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/ranges.h"
#include "shared/core/assert.h"

namespace zoned::physics {

Scene::Scene(const PhysicsSettings& settings) : impl_(std::make_unique<Impl>(settings)) {
    ZONED_ASSERT(why_unfit_integrator(settings.body_integrator).empty() &&
                     why_unfit_integrator(settings.particle_integrator).empty(),
                 "this integrator cannot move the bodies of a scene");
    for (const int pieces : {settings.body_flight_pieces, settings.particle_flight_pieces}) {
        ZONED_ASSERT(pieces >= 1 && pieces <= kMostFlightPieces, "a flight has 1..64 pieces");
    }
}

Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

core::Result<BodyId> Scene::add(const BodyDef& def) {
    std::string reason = why_unfit(def);
    if (!reason.empty()) {
        return core::Result<BodyId>::failure(std::move(reason));
    }
    const std::uint32_t row = impl_->bodies.create(def);
    if (row == kNoIndex) {
        return core::Result<BodyId>::failure("the scene is full");
    }
    impl_->make_room(def.kind);
    impl_->enter_broadphase(row);
    const bool pushed = impl_->bodies.inv_mass[row] > 0.0F;
    const bool moves =
        pushed ? !def.asleep : !(def.velocity.isZero(0.0F) && def.angular_velocity.isZero(0.0F));
    if (moves || def.kind == BodyKind::kParticle) {
        impl_->bodies.mark_awake(row);
    }
    if (pushed && !moves) {
        impl_->stop(row);
    }
    return impl_->bodies.id_of(row);
}

void Scene::remove(BodyId body) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    if (row == kNoIndex) {
        return;
    }
    impl_->drop_contacts(row);
    impl_->joints.for_each_of(
        impl_->bodies, row, [&](std::uint32_t joint, std::uint32_t) { impl_->drop_joint(joint); });
    impl_->disturb_particles(row);
    impl_->leave_broadphase(row);
    impl_->bodies.destroy(row);
}

bool Scene::contains(BodyId body) const {
    return impl_->bodies.row_of(body) != kNoIndex;
}

std::uint32_t Scene::user(BodyId body) const {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "user() of a body that is not in the scene");
    return impl_->bodies.user[row];
}

BodyState Scene::state(BodyId body) const {
    const Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "state() of a body that is not in the scene");
    return {bodies.position[row],
            bodies.orientation[row],
            bodies.velocity[row],
            bodies.is_particle(row) ? Vec3(Vec3::Zero()) : bodies.angular_velocity[row],
            bodies.inv_mass[row] > 0.0F && bodies.awake[row] == 0};
}

BodyHistory Scene::history(BodyId body) const {
    const Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "history() of a body that is not in the scene");
    return {bodies.still_s[row],
            bodies.settled_s[row],
            bodies.position[row] - bodies.settled_at[row],
            bodies.settled_turn[row],
            bodies.substep_level[row],
            bodies.substep_patience[row]};
}

void Scene::set_history(BodyId body, const BodyHistory& history) {
    Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "set_history() of a body that is not in the scene");
    bodies.still_s[row] = history.still_s;
    bodies.settled_s[row] = history.settled_s;
    bodies.settled_at[row] = bodies.position[row] - history.settled_shift;
    bodies.settled_turn[row] = history.settled_turn;
    bodies.substep_level[row] = history.substep_level;
    bodies.substep_patience[row] = history.substep_patience;
}

void Scene::set_state(BodyId body, const BodyState& state) {
    Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "set_state() of a body that is not in the scene");
    if (!fit_position(state.position) || !fit_orientation(state.orientation) ||
        !fit_velocity(state.velocity, state.angular_velocity)) {
        impl_->quarantine(row);
        return;
    }
    impl_->teleport(row, state.position, state.orientation);
    set_velocity(body, state.velocity, state.angular_velocity);
    impl_->wake(row);
    if (state.asleep && bodies.inv_mass[row] > 0.0F) {
        impl_->stop(row);
    }
}

void Scene::set_velocity(BodyId body, const Vec3& velocity, const Vec3& angular_velocity) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "set_velocity() of a body that is not in the scene");
    impl_->set_velocity(row, velocity, angular_velocity);
}

void Scene::apply_impulse(BodyId body, const Vec3& impulse, const Vec3& point) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "apply_impulse() to a body that is not in the scene");
    impl_->push(row, impulse, (point - impl_->bodies.position[row]).cross(impulse));
}

float Scene::response(BodyId body, const Vec3& point, const Vec3& direction) const {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "response() of a body that is not in the scene");
    const Bodies& bodies = impl_->bodies;
    if (bodies.inv_mass[row] == 0.0F || bodies.is_particle(row)) {
        return bodies.inv_mass[row];
    }
    const Mat3 r = bodies.inertia_axes(row, bodies.rotation[row]);
    const Vec3 moment = r.transpose() * (point - bodies.position[row]).cross(direction);
    return bodies.inv_mass[row] + moment.dot(bodies.inv_inertia[row].cwiseProduct(moment));
}

void Scene::apply_force(BodyId body, const Vec3& force, const Vec3& point) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "apply_force() to a body that is not in the scene");
    impl_->add_force(row, force, (point - impl_->bodies.position[row]).cross(force));
}

void Scene::apply_force(BodyId body, const Vec3& force) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "apply_force() to a body that is not in the scene");
    impl_->add_force(row, force, Vec3::Zero());
}

void Scene::apply_torque(BodyId body, const Vec3& torque) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "apply_torque() to a body that is not in the scene");
    impl_->add_force(row, Vec3::Zero(), torque);
}

void Scene::wake(BodyId body) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    if (row != kNoIndex) {
        impl_->wake(row);
    }
}

void Scene::set_filter(BodyId body, const Filter& filter) {
    const std::uint32_t row = impl_->bodies.row_of(body);
    ZONED_ASSERT(row != kNoIndex, "set_filter() of a body that is not in the scene");
    impl_->set_filter(row, filter);
}

void Scene::work_with(compute::Team* team) {
    impl_->team = team != nullptr ? team : &impl_->alone;
}

StepStats Scene::step(float dt) {
    return impl_->step(dt);
}

std::span<const BodyId> Scene::moved() const {
    return impl_->moved;
}

std::span<const ContactEvent> Scene::contact_events() const {
    return impl_->events;
}

std::span<const SensorEvent> Scene::sensor_events() const {
    return impl_->sensor_events;
}

std::uint32_t Scene::body_count() const {
    return impl_->bodies.count;
}

std::uint32_t Scene::awake_count() const {
    return impl_->bodies.awake_dynamic + impl_->bodies.awake_particles;
}

void Scene::hash(core::StateHash& hash) const {
    const Bodies& bodies = impl_->bodies;
    const auto add = [&hash](const Vec3& v) {
        hash.add(v.x());
        hash.add(v.y());
        hash.add(v.z());
    };
    hash.add(bodies.count);
    for (std::uint32_t row = 0; row < bodies.rows(); ++row) {
        if (bodies.alive[row] == 0) {
            continue;
        }
        hash.add(bodies.id_of(row).value);
        hash.add((static_cast<std::uint32_t>(bodies.awake[row]) << 8) |
                 static_cast<std::uint32_t>(bodies.kind[row]));
        add(bodies.position[row]);
        const Quat& q = bodies.orientation[row];
        hash.add(q.w());
        add(q.vec());
        add(bodies.velocity[row]);
        add(bodies.angular_velocity[row]);
        hash.add(bodies.still_s[row]);
        hash.add(bodies.settled_s[row]);
    }
}

}  // namespace zoned::physics
