// Particles: points with a mass that fly, and bounce, slide and rest on unyielding bodies.
#include "server/physics/integrator/free_flight.h"
#include "server/physics/integrator/integrate.h"
#include "server/physics/query/shape_ray.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// A particle meets so many surfaces in a step; after the last one it waits for the next step.
constexpr int kMostBumps = 4;
/// A particle that rests somewhere wakes when something within this distance changes, m.
constexpr float kNearby = 0.01F;

/// How far off a surface a particle is put: out of reach of rounding, so that no path ever begins
/// behind the surface that stopped it.
float skin_at(const Vec3& x) {
    return 1.0e-5F + 2.4e-7F * x.cwiseAbs().maxCoeff();
}

Aabb box_about(const Vec3& x) {
    return Aabb{x, x}.grown(kNearby);
}

}  // namespace

/// The rest of a particle's step: constant acceleration over `left` seconds.
struct Scene::Impl::ParticleFlight {
    Vec3 position, velocity, acceleration;
    float left = 0.0F;
    bool supported = false;       // by something that stands still
    float beyond = 1.0F;          // surfaces count up to so many skins behind the end
    const Vec3* after = nullptr;  // acceleration once a surface was met, where it is another

    [[nodiscard]] Vec3 end_velocity() const { return velocity + left * acceleration; }

    /// The mean of both velocities is exact, and rounds as fly_free does.
    [[nodiscard]] Vec3 way() const { return (0.5F * left) * (velocity + end_velocity()); }
};

struct Scene::Impl::Bump {
    std::uint32_t body = kNoIndex;
    float share = INFINITY;     // of the path
    Vec3 point = Vec3::Zero();  // just off the surface
    Vec3 normal = Vec3::UnitY();
    Vec3 surface_velocity = Vec3::Zero();
    Vec3 before = Vec3::Zero();  // on the path, off the surface by as much
    Frame end;                   // where a kinematic body will be
};

bool Scene::Impl::meets_particle(std::uint32_t row, std::uint32_t other) const {
    return bodies.sensor[other] == 0 && bodies.filter[row].meets(bodies.filter[other]);
}

/// The first surface on the straight line to where the flight ends. The true path bends off it by g
/// t^2 / 8, a third of a millimetre. But each line begins where the last one ended, so that nothing
/// is passed through.
void Scene::Impl::find_bump(std::uint32_t row, const ParticleFlight& flight, Bump& bump) const {
    const Vec3 way = flight.way();
    const float length = way.norm();
    if (!(length > 1.0e-12F)) {
        return;
    }
    const Vec3 along = way / length;
    const float skin = skin_at(flight.position);
    float limit = length + flight.beyond * skin;
    const auto test = [&](std::uint32_t other, float within) {
        float t = 0.0F;
        Vec3 normal = Vec3::Zero();
        if (!meets_particle(row, other) ||
            !cast_ray(placed(other), flight.position, along, within, t, normal) ||
            (bump.body != kNoIndex && t == within && other > bump.body)) {
            return within;
        }
        bump.body = other;
        bump.share = std::min(1.0F, t / length);
        bump.normal = normal;
        bump.point = flight.position + t * along + skin * normal;
        const float back = skin / std::max(0.05F, -along.dot(normal));
        bump.before = flight.position + std::max(0.0F, t - back) * along;
        return t;
    };
    for (const std::uint32_t plane : planes) {
        limit = test(plane, limit);
    }
    boxes[0].cast({flight.position, along, Vec3::Zero()}, limit, test);
}

/// The same against kinematic bodies, as seen from each of them: a body that comes up to a particle
/// hits it like one that the particle flies into. The particle is carried on to where the surface
/// is at the end.
void Scene::Impl::find_moving_bump(std::uint32_t row,
                                   const ParticleFlight& flight,
                                   float dt,
                                   Bump& bump) const {
    const Vec3 to = flight.position + flight.way();
    const Aabb area{flight.position.cwiseMin(to), flight.position.cwiseMax(to)};
    boxes[1].query(area.grown(kNearby), [&](std::uint32_t other) {
        if (!meets_particle(row, other)) {
            return;
        }
        const float damping = 1.0F / (1.0F + dt * bodies.damping[other].linear);
        const Vec3& v = bodies.velocity[other];
        const Vec3 w = bodies.angular_velocity[other] / (1.0F + dt * bodies.damping[other].angular);
        const Vec3 shift = (0.5F * dt) * (v + damping * v);
        const Vec3 at_end = bodies.position[other] + shift;
        const Quat facing = turned(bodies.orientation[other], Vec3(dt * w));
        const Mat3 turned_end = facing.toRotationMatrix();
        const float began = 1.0F - flight.left / dt;
        const Vec3 place = bodies.position[other] + began * shift;
        const Mat3 turned_now =
            turned(bodies.orientation[other], Vec3(began * dt * w)).toRotationMatrix();
        const Vec3 from = turned_now.transpose() * (flight.position - place);
        const Vec3 way = turned_end.transpose() * (to - at_end) - from;
        const float length = way.norm();
        if (!(length > 1.0e-12F)) {
            return;
        }
        static const Mat3 kStill = Mat3::Identity();
        const float skin = skin_at(flight.position);
        float t = 0.0F;
        Vec3 normal = Vec3::Zero();
        const Placed local{bodies.shape[other], Vec3::Zero(), kStill};
        if (!cast_ray(local, from, way / length, length + skin, t, normal) ||
            !(std::min(1.0F, t / length) < bump.share)) {
            return;
        }
        const Vec3 on_body = from + t / length * way + skin * normal;
        bump.body = other;
        bump.share = std::min(1.0F, t / length);
        bump.end = {at_end, facing};
        bump.normal = turned_end * normal;
        bump.point = at_end + turned_end * on_body;
        bump.surface_velocity = v + w.cross(turned_end * on_body);
    });
}

/// Goes to where the true path meets the surface. In a narrow crease the other side may stand
/// before it: then the particle stays on the straight line, which is known to be free.
void Scene::Impl::land(std::uint32_t row,
                       const Bump& bump,
                       float time,
                       ParticleFlight& flight) const {
    Vec3 to = flight.position + time * flight.velocity + (0.5F * time * time) * flight.acceleration;
    to += bump.normal.dot(bump.point - to) * bump.normal;
    ParticleFlight check{flight.position, to - flight.position, Vec3::Zero(), 1.0F};
    check.beyond = 0.25F;
    Bump other;
    find_bump(row, check, other);
    flight.position = other.body == kNoIndex ? to : bump.before;
}

/// Coulomb friction and Newton's restitution at the surface. The speed at the surface follows from
/// the height that was lost, so that a bounce rises as the restitution says. A particle that does
/// not bounce slides on for the rest of the step.
void Scene::Impl::bounce(std::uint32_t row, const Bump& bump, ParticleFlight& flight) const {
    const Vec3& n = bump.normal;
    const float before = n.dot(flight.velocity);
    float pull = n.dot(flight.acceleration);
    const float height = n.dot(flight.position - bump.point);
    float time = bump.share * flight.left;
    if (bodies.kind[bump.body] == BodyKind::kStatic && pull < 0.0F) {
        const float speed = std::sqrt(std::max(0.0F, before * before - 2.0F * pull * height));
        time = std::clamp((-speed - before) / pull, 0.0F, flight.left);
        land(row, bump, time, flight);
        flight.velocity += time * flight.acceleration;
        flight.velocity += (-speed - n.dot(flight.velocity)) * n;
    } else {
        land(row, bump, time, flight);
        flight.velocity += time * flight.acceleration;
    }
    flight.left -= time;
    if (flight.after != nullptr) {
        flight.acceleration = *std::exchange(flight.after, nullptr);
        pull = n.dot(flight.acceleration);
    }
    const Grip grip = combine(bodies.material[row], bodies.material[bump.body]);
    const Vec3 relative = flight.velocity - bump.surface_velocity;
    const float closing = std::max(0.0F, -n.dot(relative));
    const bool bounces = closing > settings.restitution_speed_mps && grip.restitution > 0.0F;
    const float away = bounces ? grip.restitution * closing : 0.0F;
    Vec3 slide = relative - n.dot(relative) * n;
    const auto rub = [&](float most) {
        const float speed = slide.norm();
        slide *= speed > most ? 1.0F - most / speed : 0.0F;
    };
    rub(grip.friction * (closing + away));
    if (bounces || pull >= 0.0F) {
        flight.velocity = bump.surface_velocity + slide + std::max(away, n.dot(relative)) * n;
        return;
    }
    // On the surface for the rest of the step: the mean velocity is exact while it slides.
    const Vec3 start = slide;
    slide += flight.left * (flight.acceleration - pull * n);
    rub(grip.friction * -pull * flight.left);
    flight.velocity = bump.surface_velocity + start;
    flight.acceleration =
        flight.left > 0.0F ? Vec3((slide - start) / flight.left) : Vec3(Vec3::Zero());
    flight.supported |= bodies.kind[bump.body] == BodyKind::kStatic;
}

/// Goes with the surface of a kinematic body to where that ends up, and on along it; not to the
/// other side of a wall.
void Scene::Impl::ride(std::uint32_t row,
                       const Bump& bump,
                       const Vec3& from,
                       ParticleFlight& flight) const {
    const Vec3 mean = 0.5F * (flight.velocity + flight.end_velocity());
    const Vec3 way = flight.left * (mean - bump.surface_velocity);
    const float length = way.norm();
    Vec3 to = bump.point;
    if (length > 1.0e-12F) {
        const Mat3 facing = bump.end.rotation.toRotationMatrix();
        const Placed surface{bodies.shape[bump.body], bump.end.position, facing};
        const float skin = skin_at(to);
        float t = 0.0F;
        Vec3 normal = Vec3::Zero();
        const bool again = cast_ray(surface, to, way / length, length + skin, t, normal);
        to += (again ? std::max(0.0F, t - skin) : length) * (way / length);
    }
    constexpr float kAll = 1.0F;
    const ParticleFlight push{from, to - from, Vec3::Zero(), kAll};
    Bump wall;
    flight.velocity = flight.end_velocity();
    find_bump(row, push, wall);
    flight.position = wall.body != kNoIndex ? wall.before : to;
}

/// Bends the path of a step, as if nothing were on it, from the default's to another integrator's
/// (or the default's in several pieces). The result is a parabola that ends at that integrator's
/// position and velocity. It need not begin with the particle's velocity (semi-implicit Euler's is
/// a straight line). False where the integrator gave up.
bool Scene::Impl::bend_flight(std::uint32_t row,
                              const Vec3& pull,
                              float dt,
                              ParticleFlight& flight) const {
    Vec3 way = Vec3::Zero();
    Vec3 velocity = flight.velocity;
    const bool arrived = free_flight_in(settings.particle_flight_pieces,
                                        settings.particle_integrator,
                                        {pull, bodies.damping[row].linear},
                                        dt,
                                        way,
                                        velocity);
    const Vec3 mean = way / dt;
    flight.velocity = 2.0F * mean - velocity;
    flight.acceleration = 2.0F * (velocity - mean) / dt;
    return arrived;
}

void Scene::Impl::step_particle(std::uint32_t row, float dt) {
    const Vec3 pull = settings.gravity + bodies.inv_mass[row] * bodies.force[row];
    const Vec3 start = bodies.velocity[row];
    const Vec3 end = (start + dt * pull) / (1.0F + dt * bodies.damping[row].linear);
    const bool damped = bodies.damping[row].linear > 0.0F;
    ParticleFlight flight{
        bodies.position[row], start, damped ? Vec3((end - start) / dt) : pull, dt};
    const Vec3 after = flight.acceleration;
    // A particle that lies still on something is left to the default: others would lift and drop it
    // by turns. Without drag the default's pieces add up to its whole.
    const bool other = settings.particle_integrator != IntegratorKind::kDefault ||
                       (settings.particle_flight_pieces > 1 && damped);
    if (other && bodies.still_s[row] == 0.0F) {
        flight.after = &after;
        if (!bend_flight(row, pull, dt, flight)) {
            broken.push_back(row);
            return;
        }
    }
    for (int bumps = 0; flight.left > 0.0F; ++bumps) {
        Bump bump;
        find_bump(row, flight, bump);
        if (boxes[1].size() > 0) {
            find_moving_bump(row, flight, dt, bump);
        }
        if (bump.body == kNoIndex) {
            flight.position += flight.way();
            flight.velocity = flight.end_velocity();
            break;
        }
        const bool carried = bodies.kind[bump.body] == BodyKind::kKinematic;
        const Vec3 from = flight.position;
        bounce(row, bump, flight);
        if (carried) {
            ride(row, bump, from, flight);
            break;
        }
        if (bumps + 1 == kMostBumps) {
            break;
        }
    }
    if (!fit_position(flight.position) || !fit_velocity(flight.velocity, Vec3::Zero())) {
        broken.push_back(row);
        return;
    }
    bodies.position[row] = flight.position;
    bodies.velocity[row] = flight.velocity;
    const bool slow =
        flight.velocity.squaredNorm() < settings.sleep_speed_mps * settings.sleep_speed_mps;
    bodies.still_s[row] = slow && flight.supported ? bodies.still_s[row] + dt : 0.0F;
}

/// Moves the particles through the coming step; the kinematic bodies have not moved yet.
void Scene::Impl::step_particles(float dt) {
    for (const std::uint32_t mover : bodies.mover_list) {
        if (resting.size() > 0) {
            disturbed.clear();
            resting.query(bodies.fat[mover], [&](std::uint32_t row) { disturbed.push_back(row); });
            for (const std::uint32_t row : disturbed) {
                wake(row);
            }
        }
    }
    bodies.compact_lists();
    broken.clear();
    for (const std::uint32_t row : bodies.particle_list) {
        step_particle(row, dt);
    }
    for (const std::uint32_t row : broken) {
        quarantine(row);
    }
    for (const std::uint32_t row : bodies.particle_list) {
        if (settings.sleep_after_s > 0.0F && bodies.still_s[row] >= settings.sleep_after_s) {
            rest_particle(row);
        }
    }
}

void Scene::Impl::rest_particle(std::uint32_t row) {
    if (bodies.awake[row] == 0) {
        return;
    }
    bodies.velocity[row].setZero();
    bodies.still_s[row] = 0.0F;
    bodies.mark_asleep(row);
    stopped.push_back(row);
    const Aabb box = box_about(bodies.position[row]);
    bodies.fat[row] = box;
    resting.insert(row, box);
}

void Scene::Impl::disturb_particles(std::uint32_t row) {
    if (resting.size() == 0 || bodies.inv_mass[row] > 0.0F) {
        return;
    }
    disturbed.clear();
    const bool plane = bodies.is_plane(row);
    const Aabb everywhere = Aabb{Vec3::Zero(), Vec3::Zero()}.grown(kMaxCoordinate);
    resting.query(plane ? everywhere : bodies.bounds[row].grown(kNearby),
                  [&](std::uint32_t particle) { disturbed.push_back(particle); });
    std::sort(disturbed.begin(), disturbed.end());
    for (const std::uint32_t particle : disturbed) {
        wake(particle);
    }
}

/// How deep a body lies in another one at its deepest point, m, and the direction out; zero: apart.
float Scene::Impl::deepest_overlap(std::uint32_t row, std::uint32_t other, Vec3& out) {
    float deepest = 0.0F;
    const auto look = [&](const Manifold& manifold) {
        for (int i = 0; i < manifold.count; ++i) {
            const float depth = -manifold.points[static_cast<std::size_t>(i)].separation;
            if (depth > deepest) {
                deepest = depth;
                out = -manifold.normal;
            }
        }
    };
    if (is_convex(bodies.shape[row].kind) && is_convex(bodies.shape[other].kind)) {
        Manifold manifold;
        collide(placed(row), placed(other), 0.0F, manifold);
        look(manifold);
    } else {
        parts.collide(placed(row), placed(other), {});
        for (const PartManifold& part : parts.manifolds()) {
            look(part.manifold);
        }
    }
    return deepest;
}

/// Pushes a body out of the unyielding bodies that it overlaps, the deepest overlap first.
void Scene::Impl::lift_out(std::uint32_t row) {
    constexpr int kMostPushes = 16;
    for (int push = 0; push < kMostPushes; ++push) {
        float deepest = 0.0F;
        Vec3 best = Vec3::Zero();
        const auto look = [&](std::uint32_t other) {
            Vec3 out = Vec3::Zero();
            const float depth =
                meets_particle(row, other) ? deepest_overlap(row, other, out) : 0.0F;
            if (depth > deepest) {
                deepest = depth;
                best = out;
            }
        };
        for (const std::uint32_t plane : planes) {
            look(plane);
        }
        // The box is copied: the body moves while the boxes are asked.
        const Aabb area = bodies.bounds[row];
        boxes[0].query(area, look);
        boxes[1].query(area, look);
        if (!(deepest > 1.0e-4F)) {
            return;
        }
        bodies.set_pose(row, bodies.position[row] + deepest * best, bodies.orientation[row]);
    }
}

/// Takes a body out, lets it change, and puts it back where it stands.
template <class Change>
void Scene::Impl::exchange(std::uint32_t row, Change&& change) {
    drop_contacts(row);
    leave_broadphase(row);
    bodies.mark_asleep(row);
    change();
    bodies.still_s[row] = 0.0F;
    make_room(bodies.kind[row]);
    bodies.set_pose(row, bodies.position[row], bodies.orientation[row]);
    if (bodies.is_dynamic(row)) {
        lift_out(row);
    }
    enter_broadphase(row);
    bodies.mark_awake(row);
}

core::Result<BodyState> Scene::set_representation(BodyId body, BodyRepresentation representation) {
    using Refused = core::Result<BodyState>;
    Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    if (row == kNoIndex || bodies.inv_mass[row] == 0.0F) {
        return Refused::failure("representation: no such body, or none that forces move");
    }
    if (bodies.sensor[row] != 0 || bodies.first_joint[row] != kNoIndex) {
        return Refused::failure("representation: a sensor or a body with joints stays as it is");
    }
    const BodyKind wanted =
        representation == BodyRepresentation::kParticle ? BodyKind::kParticle : BodyKind::kDynamic;
    if (wanted == bodies.kind[row]) {
        return state(body);
    }
    impl_->exchange(row, [&] { bodies.kind[row] = wanted; });
    return state(body);
}

core::Result<BodyState> Scene::set_shape(BodyId body, const Shape& shape) {
    using Refused = core::Result<BodyState>;
    Bodies& bodies = impl_->bodies;
    const std::uint32_t row = bodies.row_of(body);
    if (row == kNoIndex || !bodies.is_dynamic(row)) {
        return Refused::failure("shape: no such body, or none that forces move and that has one");
    }
    BodyDef def;
    def.shape = shape;
    def.mass = 1.0F / bodies.inv_mass[row];
    def.moments = bodies.inertia[row];
    if (std::string reason = why_unfit(def); !reason.empty()) {
        return Refused::failure("shape: " + reason);
    }
    impl_->exchange(row, [&] { bodies.set_shape(row, shape); });
    impl_->wake_joined(row);
    return state(body);
}

bool Scene::touches_bodies(BodyId body) const {
    const std::uint32_t row = impl_->bodies.row_of(body);
    bool touches = false;
    if (row != kNoIndex && !impl_->bodies.is_particle(row)) {
        impl_->graph.for_each_of(
            impl_->bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
                touches |= impl_->graph.pair(contact).touching &&
                           impl_->bodies.kind[other] != BodyKind::kStatic;
            });
    }
    return touches;
}

}  // namespace zoned::physics
