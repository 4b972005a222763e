// Motors of hinges and sliders at high speed and torque, against limits, reversed all the time.
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::stability {

namespace {

/// The longest substep, s. Joints hold at the middle of substeps: a body at a speed v is at most v
/// h / 2 beyond a limit when the step ends.
constexpr double kSubstep = 1.0 / 240.0;

Vec3d point_of(const BodyState& s, const Vec3d& local) {
    return s.position.cast<double>() + s.orientation.cast<double>().normalized() * local;
}

constexpr const char* kStrong =
    "a motor of 100 rad/s and more against a limit: the bar is 5 % too fast, at 1,000 rad/s its "
    "joint gapes";

/// False where the joint is gone.
bool drive(World& world, JointId joint, double speed, double most) {
    return world.scene.contains(joint) &&
           world.scene.set_motor(joint, static_cast<float>(speed), static_cast<float>(most));
}

JointDef motor_of(JointKind kind, BodyId a, BodyId b, const Vec3& anchor, const Vec3& axis) {
    JointDef def;
    def.kind = kind;
    def.a = a;
    def.b = b;
    def.anchor = anchor;
    def.axis = axis;
    def.motor = true;
    return def;
}

/// How far a straight move strays from a turn by `rate` per second about an arm, over a substep,
/// with a millimetre for rounding. This is the gap that a joint shows at the end of a step.
double gap_bound(double rate, double arm) {
    const double turn = std::min(rate * kSubstep, 2.0);
    return 0.5 * turn * turn * arm + 1.0e-3;
}

struct Bar {
    BodyId body;
    JointId hinge;
};

/// A bar of a metre, hinged to the world at one end, between limits on both sides, rad.
Bar hinged_bar(World& world, float limit, double most) {
    world.floor_y = -1.0F;
    BodyDef def = body_of(Shape::box(Vec3(0.5F, 0.1F, 0.1F)), 1.0F, Vec3(0.5F, 0.0F, 0.0F));
    def.filter.mask = 0;
    const BodyId id = world.add(def);
    JointDef joint = motor_of(JointKind::kHinge, BodyId(), id, Vec3::Zero(), Vec3::UnitZ());
    joint.limited = true;
    joint.lower = -limit;
    joint.upper = limit;
    joint.motor_max = static_cast<float>(most);
    return {id, world.join(joint)};
}

/// A bar on a hinge between limits of a radian on both sides, driven to and fro. A motor with
/// torque to spare turns at its speed and no faster; falling, the bar has sqrt(6 g / L) at most.
void bar(Run& run, double speed, double most, int every) {
    World world(run,
                "motor-hinge",
                whole(speed) + " rad/s, " + whole(most) + " N m, every " + std::to_string(every));
    const auto [id, hinge] = hinged_bar(world, 1.0F, most);
    double beyond = 0.0;
    double spin = 0.0;
    double gap = 0.0;
    const int steps = run.pick(300, 3000);
    for (int i = 0; i < steps; ++i) {
        const double way = i / every % 2 == 0 ? speed : -speed;
        if (!drive(world, hinge, way, most) || !world.step()) {
            break;
        }
        const BodyState s = world.watch(id);
        beyond = std::max(beyond, std::abs(world.joint_at(hinge)) - 1.0);
        spin = std::max(spin, static_cast<double>(s.angular_velocity.norm()));
        gap = std::max(gap, point_of(s, Vec3d(-0.5, 0.0, 0.0)).norm());
    }
    const double fastest = std::max(speed, std::sqrt(6.0 * kG));
    if (most * speed > 1.0e5) {
        world.row.know(kStrong, {{"speed_mps", 0.55 * fastest}, {"gap_m", 0.03 * fastest}});
    }
    world.limits.speed_mps = 0.51 * fastest + 0.1;
    world.row.check("joints_gone", world.joints_gone(), 0.0);
    world.row.check("beyond_rad", beyond, 0.5 * fastest * kSubstep + 0.005);
    world.row.check("spin_rps", spin, 1.01 * fastest + 0.1);
    world.row.check("gap_m", gap, gap_bound(fastest, 0.5));
    world.finish();
}

/// A weak motor swings a bar. The bar never has more energy than its initial energy and the motor's
/// work, the sum of torque times distance. The distance is taken from positions at the ends of
/// steps, between which the bar may turn. So 2 % of the work, and of the energy of a swing, are
/// allowed.
void work(Run& run, double most) {
    World world(run, "motor-work", whole(most) + " N m");
    const JointId hinge = hinged_bar(world, 2.0F, most).hinge;
    world.step();
    const double start = kG * 1.0;  // level, a metre above the floor
    double done = 0.0;
    double excess = 0.0;
    double at = 0.0;
    for (int i = 0; i < run.pick(600, 6000); ++i) {
        if (!drive(world, hinge, i / 20 % 2 == 0 ? 100.0 : -100.0, most) || !world.step()) {
            break;
        }
        const double now = world.joint_at(hinge);
        done += most * std::abs(now - at);
        at = now;
        excess = std::max(excess, (world.energy() - start - 1.02 * done) / (0.5 * kG));
    }
    world.row.check("excess_share", excess, 0.02);
    world.finish();
}

/// Five bars in a row, hinged to the world and to each other, whose motors all turn to and fro at
/// random. With torque to spare no hinge is faster than its motor: bar k spins k times as fast at
/// most. Its middle moves with the sum of the speeds of the bars before it.
void arm(Run& run, double speed, std::uint64_t seed) {
    constexpr int kBars = 5;
    World world(run, "motor-arm", whole(speed) + " rad/s, seed " + std::to_string(seed));
    world.floor_y = -6.0F;
    core::Rng rng(seed, 41);
    std::vector<BodyId> bars;
    std::vector<JointId> hinges;
    for (int i = 0; i < kBars; ++i) {
        const auto x = static_cast<float>(i);
        BodyDef def = body_of(Shape::box(Vec3(0.5F, 0.1F, 0.1F)), 1.0F, Vec3(x + 0.5F, 0, 0));
        def.filter.mask = 0;
        bars.push_back(world.add(def));
        JointDef joint = motor_of(JointKind::kHinge,
                                  i == 0 ? BodyId() : bars[static_cast<std::size_t>(i - 1)],
                                  bars.back(),
                                  Vec3(x, 0.0F, 0.0F),
                                  i % 2 == 0 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitY()));
        joint.limited = true;
        joint.lower = -0.8F;
        joint.upper = 0.8F;
        hinges.push_back(world.join(joint));
    }
    double beyond = 0.0;
    double spin = 0.0;
    double gap = 0.0;
    for (int step = 0; step < run.pick(300, 3000); ++step) {
        bool there = true;
        for (std::size_t k = 0; k < hinges.size() && step % 4 == 0; ++k) {
            const double way = rng.below(2) == 0 ? speed : -speed;
            there = drive(world, hinges[k], way, 1.0e7) && there;
        }
        if (!there || !world.step()) {
            break;
        }
        Vec3d end = Vec3d::Zero();
        for (std::size_t k = 0; k < bars.size(); ++k) {
            const BodyState s = world.watch(bars[k]);
            beyond = std::max(beyond, std::abs(world.joint_at(hinges[k])) - 0.8);
            spin = std::max(
                spin, static_cast<double>(s.angular_velocity.norm()) / static_cast<double>(k + 1));
            gap = std::max(gap, (point_of(s, Vec3d(-0.5, 0.0, 0.0)) - end).norm());
            end = point_of(s, Vec3d(0.5, 0.0, 0.0));
        }
    }
    // 1 + 2 + 3 + 4 of whole bars and 5 of half a one.
    world.limits.speed_mps = 1.05 * 12.5 * speed + 0.1;
    world.row.check("joints_gone", world.joints_gone(), 0.0);
    world.row.check("beyond_rad", beyond, 0.5 * speed * kSubstep + 0.01);
    world.row.check("spin_per_hinge_rps", spin, 1.05 * speed + 0.1);
    world.row.check("gap_m", gap, 2.0 * gap_bound(kBars * speed, 0.5));
    world.finish();
}

/// A block on a slider, half a metre in both directions. It keeps to its line, against gravity,
/// within the budget of a contact.
void block(Run& run, double speed, double most, int every) {
    World world(run,
                "motor-slider",
                whole(speed) + " m/s, " + whole(most) + " N, every " + std::to_string(every));
    world.floor_y = -1.0F;
    BodyDef def = body_of(Shape::box(Vec3::Constant(0.2F)), 1.0F, Vec3::Zero());
    def.filter.mask = 0;
    const BodyId id = world.add(def);
    JointDef joint = motor_of(JointKind::kSlider, BodyId(), id, Vec3::Zero(), Vec3::UnitX());
    joint.limited = true;
    joint.lower = -0.5F;
    joint.upper = 0.5F;
    const JointId slider = world.join(joint);
    double beyond = 0.0;
    double across = 0.0;
    double tilt = 0.0;
    for (int i = 0; i < run.pick(300, 3000); ++i) {
        const double way = i / every % 2 == 0 ? speed : -speed;
        if (!drive(world, slider, way, most) || !world.step()) {
            break;
        }
        const BodyState s = world.watch(id);
        beyond = std::max(beyond, std::abs(world.joint_at(slider)) - 0.5);
        across = std::max(across, static_cast<double>(std::hypot(s.position.y(), s.position.z())));
        tilt = std::max(tilt, static_cast<double>(2.0F * s.orientation.vec().norm()));
    }
    world.limits.speed_mps = 1.01 * speed + 0.1;
    world.row.check("joints_gone", world.joints_gone(), 0.0);
    world.row.check("beyond_m", beyond, 0.5 * speed * kSubstep + 0.005);
    world.row.check("across_m", across, 0.005);
    world.row.check("tilt_rad", tilt, 0.005);
    world.finish();
}

/// A plate on an upright slider throws a ball up and catches it. The plate gives its own speed, an
/// overlap 3 m/s more. The ball comes back as fast, and also falls by the travel of the plate.
void piston(Run& run, double speed) {
    World world(run, "motor-piston", whole(speed) + " m/s");
    world.room(3.0F, 40.0F);
    BodyDef def = body_of(Shape::box(Vec3(2.5F, 0.25F, 2.5F)), 50.0F, Vec3(0.0F, 1.0F, 0.0F));
    const BodyId plate = world.add(def);
    world.add(body_of(Shape::sphere(0.5F), 1.0F, Vec3(0.1F, 1.8F, 0.0F)));
    world.add(body_of(Shape::box(Vec3::Constant(0.4F)), 2.0F, Vec3(-1.2F, 1.7F, 0.4F)));
    JointDef joint =
        motor_of(JointKind::kSlider, BodyId(), plate, Vec3(0.0F, 1.0F, 0.0F), Vec3::UnitY());
    joint.limited = true;
    joint.lower = 0.0F;
    joint.upper = 1.0F;
    const JointId slider = world.join(joint);
    double beyond = 0.0;
    double tilt = 0.0;
    for (int i = 0; i < run.pick(300, 3000); ++i) {
        const double way = i / 25 % 2 == 0 ? speed : -speed;
        if (!drive(world, slider, way, 1.0e6) || !world.step()) {
            break;
        }
        const BodyState s = world.watch(plate);
        beyond = std::max(beyond, std::abs(world.joint_at(slider) - 0.5) - 0.5);
        tilt = std::max(tilt, static_cast<double>(2.0F * s.orientation.vec().norm()));
    }
    world.limits.speed_mps = speed + 3.0 + std::sqrt(2.0 * kG * 1.0);
    world.row.check("joints_gone", world.joints_gone(), 0.0);
    world.row.check("beyond_m", beyond, 0.5 * speed * kSubstep + 0.005);
    world.row.check("tilt_rad", tilt, 0.005);
    world.finish();
}

/// Two boxes that only a motor holds together: whatever it does, they keep their momentum.
void pair(Run& run, double speed) {
    World world(run, "motor-pair", whole(speed) + " rad/s", weightless());
    std::vector<BodyId> ids;
    for (const float side : {-1.0F, 1.0F}) {
        BodyDef def = body_of(
            Shape::box(Vec3(0.5F, 0.2F, 0.3F)), side > 0.0F ? 3.0F : 1.0F, Vec3(0.5F * side, 1, 0));
        def.filter.mask = 0;
        def.velocity = Vec3(2.0F, 0.0F, 0.0F);
        ids.push_back(world.add(def));
    }
    JointDef joint =
        motor_of(JointKind::kHinge, ids[0], ids[1], Vec3(0.0F, 1.0F, 0.0F), Vec3::UnitZ());
    joint.limited = true;
    joint.lower = -1.0F;
    joint.upper = 1.0F;
    const JointId hinge = world.join(joint);
    world.limits.momentum_share = 1.0e-3;
    double beyond = 0.0;
    for (int i = 0; i < run.pick(300, 3000); ++i) {
        const double way = i / 3 % 2 == 0 ? speed : -speed;
        if (!drive(world, hinge, way, 1.0e4) || !world.step()) {
            break;
        }
        beyond = std::max(beyond, std::abs(world.joint_at(hinge)) - 1.0);
    }
    // Each box has at most all of the rate, about a centre half a metre away.
    world.limits.speed_mps = 2.0 + 0.5 * speed * 1.01 + 0.1;
    world.row.check("joints_gone", world.joints_gone(), 0.0);
    world.row.check("beyond_rad", beyond, 0.5 * speed * kSubstep + 0.005);
    world.finish();
}

void motors(Run& run) {
    for (const double speed : run.pick<std::vector<double>>({100.0}, {1.0, 10.0, 100.0, 1000.0})) {
        for (const double most :
             run.pick<std::vector<double>>({50.0, 1.0e6}, {50.0, 1.0e3, 1.0e4, 1.0e6})) {
            bar(run, speed, most, 3);
            bar(run, speed, most, 1);
            block(run, speed, most, 3);
            block(run, speed, most, 1);
        }
    }
    for (const double most : run.pick<std::vector<double>>({2.0}, {1.0, 5.0, 20.0})) {
        work(run, most);
    }
    for (const double speed : run.pick<std::vector<double>>({5.0}, {1.0, 5.0, 20.0})) {
        for (std::uint64_t k = 0; k < run.pick(1U, 4U); ++k) {
            arm(run, speed, run.seed + k);
        }
        piston(run, speed);
        pair(run, 5.0 * speed);
    }
}

}  // namespace

std::vector<Case> motor_cases() {
    return {{"motor",
             "motors at high speed and torque against limits: no faster, farther or stronger than "
             "they are",
             motors}};
}

}  // namespace zoned::stability
