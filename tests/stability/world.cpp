#include "tests/stability/world.h"

#include "server/physics/shapes/compound/inertia.h"
#include "tests/bench/cpu_clock.h"
#include "tests/scenario/overlaps.h"
#include "tests/stability/finite_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace zoned::stability {

namespace {

bool is_solid(const Shape& shape) {
    return shape.kind == physics::ShapeKind::kSphere || shape.kind == physics::ShapeKind::kBox ||
           shape.kind == physics::ShapeKind::kCapsule;
}

scenario::Solid solid_of(const Shape& shape) {
    switch (shape.kind) {
        case physics::ShapeKind::kSphere:
            return scenario::Solid::sphere(static_cast<double>(shape.radius));
        case physics::ShapeKind::kCapsule:
            return scenario::Solid::capsule(static_cast<double>(shape.radius),
                                            static_cast<double>(shape.half_segment));
        default:
            return scenario::Solid::box(2.0 * shape.half_extents.cast<double>());
    }
}

/// A body with one number changed by the fault.
void spoil(Fault fault, BodyState& s) {
    switch (fault) {
        case Fault::kNone:
            break;
        case Fault::kNan:
            s.position.y() = std::numeric_limits<float>::quiet_NaN();
            break;
        case Fault::kEnergy:
            s.velocity = 10.0F * s.velocity + Vec3(0.0F, 1000.0F, 0.0F);
            break;
        case Fault::kFloor:
            s.position.y() -= 1.0F;
            break;
        case Fault::kEscape:
            s.position.x() += 1.0e5F;
            break;
        case Fault::kDrift:
            s.position.z() += 5.0F;
            break;
        case Fault::kJoint:
        case Fault::kTime:
        case Fault::kHull:
        case Fault::kAwake:
            break;  // no value that is read of a body
        case Fault::kMomentum:
            s.velocity = 1.5F * s.velocity + Vec3(1.0F, 0.0F, 0.0F);
            break;
    }
}

}  // namespace

World::World(Run& run,
             std::string name,
             std::string parameter,
             const physics::PhysicsSettings& settings)
    : scene(settings),
      run_(run),
      gravity_(settings.gravity.cast<double>()) {
    row.name = std::move(name);
    row.parameter = std::move(parameter);
}

BodyId World::add(const BodyDef& def) {
    const auto id = scene.add(def);
    if (!id) {
        throw std::runtime_error("a body was refused: " + id.error());
    }
    Known known{*id, def, Vec3d::Zero(), is_solid(def.shape), def.position.cast<double>()};
    if (def.kind == BodyKind::kDynamic) {
        known.moments = def.moments.isZero(0.0F)
                            ? physics::principal_inertia(def.shape, def.mass).cast<double>()
                            : def.moments.cast<double>();
        Sums sums;
        take_motion(known, scene.state(*id), sums);
        energy_there_ += sums.energy;
        scale_ += sums.energy;
    }
    bodies_.push_back(known);
    return *id;
}

void World::remove(BodyId id) {
    std::erase_if(bodies_, [id](const Known& known) { return known.id == id; });
    scene.remove(id);
}

JointId World::join(const JointDef& def) {
    const auto id = scene.add_joint(def);
    if (!id) {
        throw std::runtime_error("a joint was refused: " + id.error());
    }
    joints_.push_back(*id);
    return *id;
}

BodyId World::wall(const Vec3& centre, const Vec3& half_extents, float friction) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::box(half_extents);
    def.material.friction = friction;
    def.position = centre;
    return add(def);
}

void World::ground(float half_width, float friction) {
    wall(Vec3(0.0F, -1.0F, 0.0F), Vec3(half_width, 1.0F, half_width), friction);
}

void World::room(float half, float height, float friction) {
    const float wide = half + 2.0F;
    const float middle = 0.5F * height;
    const float tall = middle + 2.0F;
    wall(Vec3(0.0F, -1.0F, 0.0F), Vec3(wide, 1.0F, wide), friction);
    wall(Vec3(0.0F, height + 1.0F, 0.0F), Vec3(wide, 1.0F, wide), friction);
    for (const float side : {-1.0F, 1.0F}) {
        wall(Vec3(side * (half + 1.0F), middle, 0.0F), Vec3(1.0F, tall, wide), friction);
        wall(Vec3(0.0F, middle, side * (half + 1.0F)), Vec3(wide, tall, 1.0F), friction);
    }
    limits.inside = Aabb{Vec3(-half, 0.0F, -half), Vec3(half, height, half)};
}

void World::take_motion(const Known& body, const BodyState& s, Sums& sums) const {
    const double mass = static_cast<double>(body.def.mass);
    const Vec3d x = s.position.cast<double>() - Vec3d(0.0, static_cast<double>(floor_y), 0.0);
    const Vec3d v = s.velocity.cast<double>();
    const Vec3d w = s.angular_velocity.cast<double>();
    const Eigen::Quaterniond q = s.orientation.cast<double>().normalized();
    const Vec3d spin = q * body.moments.cwiseProduct(q.conjugate() * w);
    sums.energy += 0.5 * mass * v.squaredNorm() + 0.5 * w.dot(spin) - mass * gravity_.dot(x);
    sums.linear += mass * v;
    sums.angular += x.cross(mass * v) + spin;
    sums.size += mass * v.norm();
    sums.angular_size += x.norm() * mass * v.norm() + spin.norm();
}

BodyState World::read(const Known& body, bool& spoilt) const {
    BodyState s = scene.state(body.id);
    if (!spoilt && faulty() && body.def.kind == BodyKind::kDynamic) {
        spoil(run_.fault, s);
        spoilt = true;
    }
    return s;
}

bool World::step(float dt) {
    if (!start_) {
        start_ = Sums();
        for (const Known& body : bodies_) {
            if (body.def.kind == BodyKind::kDynamic) {
                take_motion(body, scene.state(body.id), *start_);
            }
        }
    }
    const std::int64_t before = bench::thread_cpu_ns();
    const physics::StepStats stats = scene.step(dt);
    step_ms_ = static_cast<double>(bench::thread_cpu_ns() - before) * 1.0e-6;
    step_ms_ += run_.fault == Fault::kTime && faulty() ? 1.0e5 : 0.0;
    cpu_ms_ += step_ms_;
    pairs_ = stats.pairs;
    row.quarantined += stats.quarantined;
    ++row.steps;
    look();
    const std::int64_t now = bench::wall_ns();
    if (now - told_ns_ > 5'000'000'000) {
        if (told_ns_ != 0) {
            run_.progress("      " + row.name + " " + row.parameter + ": step " +
                          std::to_string(row.steps));
        }
        told_ns_ = now;
    }
    return not_finite_ == 0;
}

void World::look() {
    Sums sums;
    bool spoilt = run_.fault == Fault::kNone;
    std::vector<BodyState> states;
    states.reserve(bodies_.size());
    std::uint64_t outside = 0;
    speed_ = 0.0;
    for (const Known& body : bodies_) {
        states.push_back(read(body, spoilt));
        const BodyState& s = states.back();
        if (!is_finite(s)) {
            ++not_finite_;
            continue;
        }
        if (body.def.kind != BodyKind::kDynamic) {
            continue;
        }
        take_motion(body, s, sums);
        speed_ = std::max(speed_, static_cast<double>(s.velocity.norm()));
        const double drift = (s.position.cast<double>() - body.start).norm();
        row.drift_m = limits.drift_m ? std::max(row.drift_m, drift) : 0.0;
        if (limits.inside) {
            outside += (s.position.array() >= limits.inside->lower.array()).all() &&
                               (s.position.array() <= limits.inside->upper.array()).all()
                           ? 0
                           : 1;
        }
    }
    escaped_ = std::max(escaped_, outside);
    if (row.steps > speed_from) {
        row.max_speed_mps = std::max(row.max_speed_mps, speed_);
    }
    energy_ = sums.energy;
    if (scale_ > 0.0 && limits.energy_share) {
        row.energy_share = std::max(row.energy_share, (sums.energy - energy_there_) / scale_);
    }
    if (limits.momentum_share) {
        momentum_share_ = std::max(
            {momentum_share_,
             (sums.linear - start_->linear).norm() / std::max(start_->size, 1.0e-30),
             (sums.angular - start_->angular).norm() / std::max(start_->angular_size, 1.0e-30)});
    }
    const auto pause = static_cast<std::uint64_t>(
        look_every > 0 ? look_every : (bodies_.size() < 60 ? 1 : (bodies_.size() < 500 ? 4 : 15)));
    if (limits.depth_m && row.steps % pause == 0) {
        row.depth_m = std::max(row.depth_m, deepest(states));
    }
}

double World::deepest(const std::vector<BodyState>& states) const {
    std::vector<scenario::Body> solids;
    std::vector<scenario::Pose> poses;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Known& known = bodies_[i];
        if (!known.solid || known.def.sensor) {
            continue;
        }
        scenario::Body body;
        body.solid = solid_of(known.def.shape);
        body.mass = known.def.kind == BodyKind::kDynamic ? 1.0 : 0.0;
        solids.push_back(body);
        poses.push_back(
            {states[i].position.cast<double>(), states[i].orientation.cast<double>().normalized()});
    }
    const scenario::Overlaps found = scenario::find_overlaps(solids, poses);
    double most = 0.0;
    for (const auto* list : {&found.pairs, &found.fixed}) {
        for (const double depth : *list) {
            most = std::max(most, depth);
        }
    }
    return most;
}

double World::depth_now() const {
    bool spoilt = run_.fault == Fault::kNone;
    std::vector<BodyState> states;
    states.reserve(bodies_.size());
    for (const Known& body : bodies_) {
        states.push_back(read(body, spoilt));
    }
    return deepest(states);
}

BodyState World::watch(BodyId id) const {
    bool spoilt = run_.fault == Fault::kNone;
    for (const Known& body : bodies_) {
        const BodyState s = read(body, spoilt);
        if (body.id == id) {
            return s;
        }
    }
    throw std::runtime_error("watched a body that is not in the world");
}

double World::joints_gone() const {
    const auto gone = std::count_if(
        joints_.begin(), joints_.end(), [this](JointId id) { return !scene.contains(id); });
    return static_cast<double>(gone) + (run_.fault == Fault::kJoint && faulty() ? 1.0 : 0.0);
}

double World::joint_at(JointId id) const {
    if (!scene.contains(id)) {
        return std::numeric_limits<double>::infinity();
    }
    const bool spoilt = run_.fault == Fault::kJoint && faulty() && id == joints_.front();
    return static_cast<double>(scene.joint_position(id)) + (spoilt ? 10.0 : 0.0);
}

void World::run(float seconds, float dt) {
    const auto steps = static_cast<int>(std::lround(seconds / dt));
    for (int i = 0; i < steps && step(dt); ++i) {
    }
}

void World::finish() {
    row.ms_per_step = row.steps > 0 ? cpu_ms_ / static_cast<double>(row.steps) : 0.0;
    row.check("not_finite", static_cast<double>(not_finite_), 0.0);
    row.check("quarantined", static_cast<double>(row.quarantined), limits.quarantined);
    const auto check = [this](const char* what, double value, const std::optional<double>& bound) {
        if (bound) {
            row.check(what, value, *bound);
        }
    };
    check("speed_mps", row.max_speed_mps, limits.speed_mps);
    check("energy_share", row.energy_share, limits.energy_share);
    check("depth_m", row.depth_m, limits.depth_m);
    check("drift_m", row.drift_m, limits.drift_m);
    check("momentum_share", momentum_share_, limits.momentum_share);
    if (limits.inside) {
        row.check("escaped", static_cast<double>(escaped_), 0.0);
    }
    run_.add(row);
}

physics::PhysicsSettings weightless() {
    physics::PhysicsSettings settings;
    settings.gravity = Vec3::Zero();
    return settings;
}

std::string whole(double x) {
    return std::to_string(static_cast<long>(x));
}

BodyDef body_of(const Shape& shape, float mass, const Vec3& position) {
    BodyDef def;
    def.shape = shape;
    def.mass = mass;
    def.position = position;
    return def;
}

BodyDef mixed_body(int i, const Vec3& position, float scale) {
    const float volume = scale * scale * scale;
    switch (i % 3) {
        case 0:
            return body_of(Shape::sphere(0.5F * scale), 0.52F * volume, position);
        case 1:
            return body_of(Shape::box(Vec3::Constant(0.5F * scale)), volume, position);
        default:
            return body_of(Shape::capsule(0.4F * scale, 0.2F * scale), 0.47F * volume, position);
    }
}

}  // namespace zoned::stability
