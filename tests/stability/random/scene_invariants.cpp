#include "tests/stability/random/scene_invariants.h"

#include "server/physics/joints/joint_rows.h"
#include "tests/stability/finite_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::stability {

namespace {

using physics::BodyKind;
using physics::BodyState;
using physics::JointKind;
using physics::ShapeKind;

constexpr double kShare = 0.01;  ///< of a group's largest energy
constexpr double kMomentumShare = 1.0e-4;
constexpr double kRestSeconds = 10.0;
constexpr double kRestShift = 0.005;  ///< m
constexpr double kRestTurn = 0.01;    ///< rad
constexpr double kThrough = 0.02;     ///< m beyond a surface, as far as solids are thick
/// Speed below which energy is rounding where there is no gravity, m/s.
constexpr double kStill = 1.0e-3;
/// The engine's effort counts as given up for this long after it said so, s.
constexpr double kGaveUpSeconds = 1.0;

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
    return a.angularDistance(b);
}

/// Whether the segment meets the box of these half extents about the origin (slabs: Kay, Kajiya,
/// "Ray tracing complex scenes", SIGGRAPH 1986).
bool crosses_box(const Vec3d& from, const Vec3d& to, const Vec3d& half) {
    double first = 0.0;
    double last = 1.0;
    const Vec3d way = to - from;
    for (int i = 0; i < 3; ++i) {
        if (std::abs(way[i]) < 1.0e-12) {
            if (std::abs(from[i]) > half[i]) {
                return false;
            }
            continue;
        }
        const double s = (-half[i] - from[i]) / way[i];
        const double t = (half[i] - from[i]) / way[i];
        first = std::max(first, std::min(s, t));
        last = std::min(last, std::max(s, t));
    }
    return first <= last;
}

}  // namespace

const std::array<std::string, kInvariants>& invariant_names() {
    static const std::array<std::string, kInvariants> kNames{
        "finite", "energy", "momentum", "joint", "sleep", "tunnel"};
    return kNames;
}

SceneInvariants::SceneInvariants(const RandomScene& scene, const LiveScene& live)
    : scene_(scene),
      live_(live),
      gravity_(scene.gravity.cast<double>()) {
    Observation start;
    isolated_ = gravity_.isZero(0.0) && scene.ground.kind == GroundKind::kNone;
    Vec3d sum = Vec3d::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const RandomBody& body = scene.bodies[i];
        start.states.push_back(live.scene.state(live.bodies[i]));
        BodyWatch watch;
        watch.dynamic = body.kind == BodyKind::kDynamic;
        watch.mover = body.kind == BodyKind::kKinematic;
        watch.mass = watch.dynamic ? static_cast<double>(body.mass) : 0.0;
        bodies_.push_back(std::move(watch));
        isolated_ = isolated_ && bodies_.back().dynamic;
        sum += bodies_.back().mass * start.states.back().position.cast<double>();
        mass += bodies_.back().mass;
        parents_.push_back(i);
    }
    middle_ = mass > 0.0 ? Vec3d(sum / mass) : Vec3d::Zero();
    take_places(start);
    const double floor = scene.ground.kind == GroundKind::kNone
                             ? std::numeric_limits<double>::infinity()
                             : lowest_ground(scene.ground) + static_cast<double>(scene.offset.y());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        BodyWatch& watch = bodies_[i];
        watch.low = std::min(floor, places_[i].at.y());
        watch.rest_at = places_[i].at;
        watch.rest_turn = places_[i].turn;
        for (const Vec3d& c : live.centres[i]) {
            watch.centres.emplace_back(places_[i].at + places_[i].turn * c);
            watch.above.push_back(true);
        }
        groups_.push_back({energy_of(i), 0.0});
    }
    for (std::size_t i = 0; i < scene.joints.size(); ++i) {
        const RandomJoint& joint = scene.joints[i];
        const bool two_points =
            joint.def.kind == JointKind::kDistance || joint.def.kind == JointKind::kSpring;
        const Place a = place_of(joint.a);
        const Place b = place_of(joint.b);
        const Vec3d offset = scene.offset.cast<double>();
        const Vec3d on_a = joint.def.anchor.cast<double>() + offset;
        const Vec3d on_b = two_points ? Vec3d(joint.def.anchor_b.cast<double>() + offset) : on_a;
        JointWatch watch;
        watch.local_a = a.turn.conjugate() * (on_a - a.at);
        watch.local_b = b.turn.conjugate() * (on_b - b.at);
        watch.axis_a = a.turn.conjugate() * joint.def.axis.cast<double>().normalized();
        watch.turn = a.turn.conjugate() * b.turn;
        watch.length = joint.def.length_m >= 0.0F ? static_cast<double>(joint.def.length_m)
                                                  : (on_b - on_a).norm();
        double inverse = 0.0;
        double largest = 0.0;
        watch.arm = std::numeric_limits<double>::infinity();
        for (const int end : {joint.a, joint.b}) {
            const auto at = static_cast<std::size_t>(end);
            if (end >= 0) {
                inverse += bodies_[at].mass > 0.0 ? 1.0 / bodies_[at].mass : 0.0;
                largest = std::max(largest, 2.0 * live.radii[at]);
                watch.arm = std::min(watch.arm, live.radii[at]);
            }
        }
        watch.stiffness = physics::spring_constants(joint.def, inverse).k;
        watch.bound = std::max(0.01, 0.001 * largest);
        watch.motor = joint.def.motor &&
                      (joint.def.kind == JointKind::kHinge || joint.def.kind == JointKind::kSlider);
        watch.warned = !live.warnings[i].empty();
        joints_.push_back(watch);
        const bool b_moves = bodies_[static_cast<std::size_t>(joint.b)].dynamic;
        if (joint.a >= 0 && b_moves && bodies_[static_cast<std::size_t>(joint.a)].dynamic) {
            unite(static_cast<std::size_t>(joint.a), static_cast<std::size_t>(joint.b));
        }
        isolated_ = isolated_ && joint.a >= 0;
        joints_.back().speed = motor_speed(i);
        groups_[group_of(static_cast<std::size_t>(b_moves ? joint.b : joint.a))].allowance +=
            spring_energy(i);
    }
    before_ = places_;
    sum_momentum(linear_, angular_, momentum_size_, angular_size_);
}

void SceneInvariants::look(const Observation& now) {
    ++steps_;
    time_ = static_cast<double>(scene_.dt) * static_cast<double>(steps_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        if (!is_finite(now.states[i])) {
            report(Invariant::kFinite, 1.0, 0.0, i);
            return;  // nothing else can be said
        }
    }
    if (now.stats.quarantined > 0) {
        report(Invariant::kFinite, now.stats.quarantined, 0.0, 0);
    }
    if (now.stats.substep_limited > 0) {
        warned_at_ = time_;
    }
    before_ = places_;
    take_places(now);
    check_energy(now);
    check_momentum(now);
    check_joints(now);
    check_sleep(now);
    check_tunnel();
}

std::vector<Breach> SceneInvariants::breaches() const {
    std::vector<Breach> all;
    for (const auto& breach : breaches_) {
        if (breach) {
            all.push_back(*breach);
        }
    }
    return all;
}

bool SceneInvariants::broken(Invariant what) const {
    return breaches_[static_cast<std::size_t>(what)].has_value();
}

void SceneInvariants::report(Invariant what,
                             double figure,
                             double bound,
                             std::size_t item,
                             bool gave_up) {
    if (figure <= bound) {
        return;
    }
    auto& breach = breaches_[static_cast<std::size_t>(what)];
    // A joint that effort gave up does not hide one that it should have held.
    if (!breach || (breach->gave_up && !gave_up)) {
        breach = Breach{what, figure, bound, time_, item, gave_up};
    } else if (breach->gave_up == gave_up && figure - bound > breach->figure - breach->bound) {
        breach->figure = figure;
        breach->bound = bound;
        breach->item = item;
    }
}

void SceneInvariants::take_places(const Observation& now) {
    places_.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const BodyState& s = now.states[i];
        places_.push_back({s.position.cast<double>(),
                           s.velocity.cast<double>(),
                           s.angular_velocity.cast<double>(),
                           s.orientation.cast<double>().normalized(),
                           s.asleep});
        bodies_[i].low = std::min(bodies_[i].low, places_[i].at.y());
        if (bodies_[i].dynamic) {
            top_speed_ = std::max(top_speed_, places_[i].velocity.norm());
        }
    }
}

std::size_t SceneInvariants::group_of(std::size_t body) {
    while (parents_[body] != body) {
        parents_[body] = parents_[parents_[body]];
        body = parents_[body];
    }
    return body;
}

void SceneInvariants::unite(std::size_t a, std::size_t b) {
    a = group_of(a);
    b = group_of(b);
    if (a != b) {
        groups_[a].allowance += groups_[b].allowance;
        groups_[a].largest += groups_[b].largest;
        parents_[b] = a;
    }
}

/// Whether the bodies may have touched in the last step: spheres about their paths overlap. After
/// a bounce a body has gone farther than from its first place to its last.
bool SceneInvariants::near(std::size_t a, std::size_t b) const {
    const auto path = [this](std::size_t i) {
        const double speed = std::max(places_[i].velocity.norm(), before_[i].velocity.norm());
        return std::max((places_[i].at - before_[i].at).norm(),
                        speed * static_cast<double>(scene_.dt));
    };
    const double travel = 0.5 * (path(a) + path(b));
    const double reach = live_.radii[a] + live_.radii[b] + travel + 0.05;
    const Vec3d middles = 0.5 * (places_[a].at + before_[a].at - places_[b].at - before_[b].at);
    return middles.squaredNorm() <= reach * reach;
}

void SceneInvariants::unite_near() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            if (bodies_[i].dynamic && bodies_[k].dynamic && near(i, k)) {
                unite(i, k);
            }
        }
    }
}

double SceneInvariants::energy_of(std::size_t body) const {
    if (!bodies_[body].dynamic) {
        return 0.0;
    }
    const Place& p = places_[body];
    const Vec3d local = p.turn.conjugate() * p.spin;
    const Vec3d from = p.at - scene_.offset.cast<double>();
    return 0.5 * bodies_[body].mass * p.velocity.squaredNorm() +
           0.5 * local.dot(live_.moments[body].cwiseProduct(local)) -
           bodies_[body].mass * gravity_.dot(from);
}

SceneInvariants::Place SceneInvariants::place_of(int body) const {
    if (body < 0) {
        return {Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero(), Eigen::Quaterniond::Identity(), false};
    }
    return places_[static_cast<std::size_t>(body)];
}

Vec3d SceneInvariants::anchor_of(const RandomJoint& joint,
                                 const JointWatch& watch,
                                 bool of_b) const {
    const Place p = place_of(of_b ? joint.b : joint.a);
    return p.at + p.turn * (of_b ? watch.local_b : watch.local_a);
}

double SceneInvariants::spring_energy(std::size_t i) const {
    if (scene_.joints[i].def.kind != JointKind::kSpring) {
        return 0.0;
    }
    const JointWatch& watch = joints_[i];
    const double length =
        (anchor_of(scene_.joints[i], watch, true) - anchor_of(scene_.joints[i], watch, false))
            .norm();
    return 0.5 * watch.stiffness * (length - watch.length) * (length - watch.length);
}

/// Along the joint's axis: rad/s of a hinge, m/s of a slider.
double SceneInvariants::motor_speed(std::size_t i) const {
    const RandomJoint& joint = scene_.joints[i];
    const Place a = place_of(joint.a);
    const Place b = place_of(joint.b);
    const Vec3d axis = a.turn * joints_[i].axis_a;
    if (joint.def.kind == JointKind::kHinge) {
        return axis.dot(b.spin - a.spin);
    }
    const Vec3d at = anchor_of(joint, joints_[i], true);
    return axis.dot(b.velocity + b.spin.cross(at - b.at) - a.velocity - a.spin.cross(at - a.at));
}

void SceneInvariants::add_motor_work(const Observation& now) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        JointWatch& watch = joints_[i];
        if (!watch.motor) {
            continue;
        }
        const RandomJoint& joint = scene_.joints[i];
        const double speed = motor_speed(i);
        const auto target = std::abs(static_cast<double>(joint.def.motor_speed));
        const double most =
            std::min(target, std::max(std::abs(speed), std::abs(watch.speed)) + 0.02 * target);
        watch.speed = speed;
        const auto moving = static_cast<std::size_t>(
            bodies_[static_cast<std::size_t>(joint.b)].dynamic ? joint.b : joint.a);
        // A joint that broke in this step pushed up to its end.
        groups_[group_of(moving)].allowance +=
            static_cast<double>(joint.def.motor_max) * most * static_cast<double>(scene_.dt);
        watch.motor = now.held[i];
    }
}

void SceneInvariants::add_mover_work(const Observation& now) {
    const auto speed_at = [&](std::size_t mover, const Vec3d& point) {
        const Place& p = places_[mover];
        return (p.velocity + p.spin.cross(point - p.at)).norm();
    };
    for (const physics::ContactEvent& contact : now.contacts) {
        for (const auto& [mover, other] : {std::pair(contact.user_a, contact.user_b),
                                           std::pair(contact.user_b, contact.user_a)}) {
            if (mover == 0 || other == 0 || !bodies_[mover - 1].mover) {
                continue;
            }
            const auto friction = static_cast<double>(
                std::sqrt(scene_.bodies[mover - 1].friction * scene_.bodies[other - 1].friction));
            groups_[group_of(other - 1)].allowance +=
                1.02 * static_cast<double>(contact.impulse) * (1.0 + friction) *
                speed_at(mover - 1, contact.point.cast<double>());
        }
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        const RandomJoint& joint = scene_.joints[i];
        for (const auto& [mover, other] :
             {std::pair(joint.a, joint.b), std::pair(joint.b, joint.a)}) {
            if (mover >= 0 && other >= 0 && bodies_[static_cast<std::size_t>(mover)].mover) {
                groups_[group_of(static_cast<std::size_t>(other))].allowance +=
                    1.02 * static_cast<double>(now.forces[i]) * static_cast<double>(scene_.dt) *
                    speed_at(static_cast<std::size_t>(mover),
                             anchor_of(joint, joints_[i], mover == joint.b));
            }
        }
    }
}

void SceneInvariants::check_energy(const Observation& now) {
    unite_near();
    add_motor_work(now);
    add_mover_work(now);

    struct Sums {
        double energy = 0.0;
        double lowest = 0.0;  ///< at rest, J
        double budget = 0.0;
        std::size_t body = 0;
        bool any = false;
    };

    std::vector<Sums> sums(groups_.size());
    const double g = gravity_.norm();
    const double give = static_cast<double>(physics::PhysicsSettings().error_budget_m);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        if (!bodies_[i].dynamic) {
            continue;
        }
        Sums& sum = sums[group_of(i)];
        const double m = bodies_[i].mass;
        sum.energy += energy_of(i);
        const double low = bodies_[i].low - static_cast<double>(scene_.offset.y());
        sum.lowest -= m * gravity_.y() * low;
        sum.budget += m * (g * give + 0.5 * kStill * kStill);
        sum.body = sum.any ? sum.body : i;
        sum.any = true;
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        if (now.held[i]) {
            const int b = scene_.joints[i].b;
            const bool b_moves = bodies_[static_cast<std::size_t>(b)].dynamic;
            sums[group_of(static_cast<std::size_t>(b_moves ? b : scene_.joints[i].a))].energy +=
                spring_energy(i);
        }
    }
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        if (!sums[i].any) {
            continue;
        }
        EnergyGroup& group = groups_[i];
        // Energy from nowhere does not enlarge its own bound.
        const double over = sums[i].energy - group.allowance;
        const double scale = std::max(group.largest, group.allowance - sums[i].lowest);
        report(Invariant::kEnergy, over, kShare * scale + sums[i].budget, sums[i].body);
        group.largest =
            std::max(group.largest, std::min(sums[i].energy, group.allowance) - sums[i].lowest);
    }
}

void SceneInvariants::sum_momentum(Vec3d& linear,
                                   Vec3d& angular,
                                   double& size,
                                   double& angular_size) const {
    linear = angular = Vec3d::Zero();
    size = angular_size = 0.0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Place& p = places_[i];
        const Vec3d push = bodies_[i].mass * p.velocity;
        const Vec3d arm = p.at - middle_;
        const Vec3d spin =
            p.turn * live_.moments[i].cwiseProduct(Vec3d(p.turn.conjugate() * p.spin));
        linear += push;
        angular += arm.cross(push) + spin;
        size += push.norm();
        angular_size += arm.norm() * push.norm() + spin.norm();
    }
}

void SceneInvariants::check_momentum(const Observation& now) {
    isolated_ = isolated_ && std::none_of(places_.begin(), places_.end(), [](const Place& p) {
                    return p.asleep;
                });
    if (!isolated_ || bodies_.empty()) {
        return;
    }
    Vec3d linear, angular;
    double size = 0.0;
    double angular_size = 0.0;
    sum_momentum(linear, angular, size, angular_size);
    // Impulses cancel but for the rounding of their sizes.
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        const physics::JointDef& def = scene_.joints[i].def;
        const auto dt = static_cast<double>(scene_.dt);
        const double push = static_cast<double>(now.forces[i]) * dt;
        const double drive = def.motor ? static_cast<double>(def.motor_max) * dt : 0.0;
        const double arm = (anchor_of(scene_.joints[i], joints_[i], true) - middle_).norm();
        size += push + drive;
        angular_size += arm * (push + drive) + drive;
    }
    momentum_size_ = std::max(momentum_size_, size);
    angular_size_ = std::max(angular_size_, angular_size);
    // Each of up to 64 substeps rounds coordinates: half a unit of the last place, at random. Where
    // a body flies by itself each step rounds the same shift, and may do so the same way.
    const double steps = static_cast<double>(steps_);
    const double rounding = 1.0e-7 * (scene_.offset.cast<double>().norm() + 1.0) *
                            std::max(std::sqrt(64.0 * steps), steps) * momentum_size_;
    report(Invariant::kMomentum,
           (linear - linear_).norm(),
           kMomentumShare * momentum_size_ + 1.0e-9,
           0);
    report(Invariant::kMomentum,
           (angular - angular_).norm(),
           kMomentumShare * angular_size_ + rounding + 1.0e-9,
           0);
}

double SceneInvariants::gap_of(std::size_t i) const {
    const RandomJoint& joint = scene_.joints[i];
    const JointWatch& watch = joints_[i];
    const Vec3d gap = anchor_of(joint, watch, true) - anchor_of(joint, watch, false);
    switch (joint.def.kind) {
        case JointKind::kSpring:
            return 0.0;
        case JointKind::kDistance:
            return std::abs(gap.norm() - watch.length);
        case JointKind::kSlider: {
            const Vec3d axis = place_of(joint.a).turn * watch.axis_a;
            return (gap - axis * axis.dot(gap)).norm();
        }
        default:
            return gap.norm();
    }
}

/// How far the bodies are turned against each other where the joint forbids it, rad.
double SceneInvariants::misturn_of(std::size_t i) const {
    const RandomJoint& joint = scene_.joints[i];
    const JointWatch& watch = joints_[i];
    const Eigen::Quaterniond turn = place_of(joint.a).turn.conjugate() * place_of(joint.b).turn;
    switch (joint.def.kind) {
        case JointKind::kSlider:
        case JointKind::kFixed:
            return angle_between(turn, watch.turn);
        case JointKind::kHinge: {
            const Vec3d axis = turn * (watch.turn.conjugate() * watch.axis_a);
            return std::atan2(axis.cross(watch.axis_a).norm(), axis.dot(watch.axis_a));
        }
        default:
            return 0.0;
    }
}

void SceneInvariants::check_joints(const Observation& now) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        if (now.held[i]) {
            const double gap = gap_of(i) + misturn_of(i) * joints_[i].arm;
            const bool gave_up = joints_[i].warned || time_ - warned_at_ < kGaveUpSeconds;
            report(Invariant::kJoint, gap, joints_[i].bound, i, gave_up);
        }
    }
}

void SceneInvariants::check_sleep(const Observation& now) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        BodyWatch& watch = bodies_[i];
        const Place& p = places_[i];
        if ((p.at - watch.rest_at).norm() > kRestShift ||
            angle_between(p.turn, watch.rest_turn) > kRestTurn) {
            watch.rest_at = p.at;
            watch.rest_turn = p.turn;
            watch.rest_since = time_;
        }
    }
    // The look at all neighbours is dear: once in half a second.
    const auto every = std::max<std::uint64_t>(
        static_cast<std::uint64_t>(0.5 / static_cast<double>(scene_.dt)), 1);
    if (time_ < kRestSeconds || steps_ % every != 0) {
        return;
    }
    // Bodies that may touch rest together or not at all.
    std::vector<std::size_t> parent(bodies_.size());
    for (std::size_t i = 0; i < parent.size(); ++i) {
        parent[i] = i;
    }
    const auto root = [&parent](std::size_t i) {
        while (parent[i] != i) {
            i = parent[i] = parent[parent[i]];
        }
        return i;
    };
    std::vector<bool> restless(bodies_.size(), false);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            const bool tied = (bodies_[i].dynamic && (bodies_[k].dynamic || bodies_[k].mover)) ||
                              (bodies_[k].dynamic && bodies_[i].mover);
            if (tied && near(i, k)) {
                parent[root(i)] = root(k);
            }
        }
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        const RandomJoint& joint = scene_.joints[i];
        if (!now.held[i]) {
            continue;
        }
        const auto b = static_cast<std::size_t>(joint.b);
        if (joint.a >= 0) {
            parent[root(static_cast<std::size_t>(joint.a))] = root(b);
        }
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const bool at_rest = !bodies_[i].mover && time_ - bodies_[i].rest_since >= kRestSeconds;
        if (!at_rest && (bodies_[i].dynamic || bodies_[i].mover)) {
            restless[root(i)] = true;
        }
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        if (joints_[i].motor && now.held[i]) {
            restless[root(static_cast<std::size_t>(scene_.joints[i].b))] = true;
        }
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        if (bodies_[i].dynamic && !restless[root(i)] && !places_[i].asleep) {
            report(Invariant::kSleep, time_ - bodies_[i].rest_since, kRestSeconds - 1.0e-6, i);
        }
    }
}

/// How far a part's path within the last step may lie from the straight line between its ends, m:
/// the ellipse of all paths of that length. A body that bounced went around corners.
double SceneInvariants::stray_of(std::size_t body, const Vec3d& from, const Vec3d& to) const {
    const auto speed = [&](const Place& place) {
        return place.velocity.norm() + place.spin.norm() * live_.radii[body];
    };
    const double length =
        static_cast<double>(scene_.dt) * std::max(speed(places_[body]), speed(before_[body]));
    return 0.5 * std::sqrt(std::max(length * length - (to - from).squaredNorm(), 0.0));
}

bool SceneInvariants::passed_static(std::size_t wall,
                                    const Vec3d& from,
                                    const Vec3d& to,
                                    double stray) const {
    const RandomBody& body = scene_.bodies[wall];
    const Eigen::Quaterniond body_turn = body.turn.cast<double>();
    for (const RandomPart& part : body.parts) {
        const Eigen::Quaterniond turn = body_turn * part.turn.cast<double>();
        const Vec3d at = scene_.offset.cast<double>() + body.at.cast<double>() +
                         body_turn * part.at.cast<double>();
        const Vec3d u = turn.conjugate() * (from - at);
        const Vec3d v = turn.conjugate() * (to - at);
        if (part.kind == ShapeKind::kBox) {
            const Vec3d half = part.half.cast<double>();
            Vec3d inner = half - half.cwiseMin(2.0 * kThrough) * 0.5;
            Eigen::Index thin = 0;
            half.minCoeff(&thin);
            for (Eigen::Index k = 0; k < 3; ++k) {
                inner[k] -= k == thin ? 0.0 : stray;
            }
            if (inner.minCoeff() > 0.0 && crosses_box(u, v, inner)) {
                return true;
            }
        } else if (part.kind == ShapeKind::kSphere) {
            const Vec3d way = v - u;
            const double size = way.squaredNorm();
            const double t = size > 0.0 ? std::clamp(-u.dot(way) / size, 0.0, 1.0) : 0.0;
            if ((u + t * way).norm() < 0.5 * static_cast<double>(part.radius) - stray) {
                return true;
            }
        }
    }
    return false;
}

void SceneInvariants::check_tunnel() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        BodyWatch& watch = bodies_[i];
        if (!watch.dynamic) {
            continue;
        }
        for (std::size_t c = 0; c < watch.centres.size(); ++c) {
            const Vec3d from = watch.centres[c];
            const Vec3d to = places_[i].at + places_[i].turn * live_.centres[i][c];
            watch.centres[c] = to;
            const Vec3d over = to - scene_.offset.cast<double>();
            const double ground = ground_height(scene_.ground, over.x(), over.z());
            if (std::isfinite(ground) && watch.above[c]) {
                const double below = ground - over.y();
                // A body that rolls off the rim may be below once it is beside it.
                report(Invariant::kTunnel, below, 2.5 * kThrough, i);
            } else {
                watch.above[c] = std::isfinite(ground) && over.y() >= ground;
            }
            for (std::size_t wall = 0; wall < bodies_.size(); ++wall) {
                if (scene_.bodies[wall].kind == BodyKind::kStatic && (bodies_[i].mass > 0.0) &&
                    passed_static(wall, from, to, stray_of(i, from, to))) {
                    report(Invariant::kTunnel, 1.0, 0.0, i);
                }
            }
        }
    }
}

}  // namespace zoned::stability
