// Kinematic anchors: joints and stacks on bodies that are teleported and accelerated.
#include "tests/stability/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::stability {

namespace {

BodyDef anchor_at(const Shape& shape, const Vec3& position) {
    BodyDef def;
    def.kind = BodyKind::kKinematic;
    def.shape = shape;
    def.position = position;
    return def;
}

/// Bars of a kilogram on ball joints below a kinematic anchor.
struct Chain {
    static constexpr int kBars = 5;

    World& world;
    BodyId anchor;
    std::vector<BodyId> bars;
    std::vector<JointId> joints;

    explicit Chain(World& w, float damping = 0.0F) : world(w) {
        anchor = world.add(anchor_at(Shape::sphere(0.1F), Vec3::Zero()));
        BodyId last = anchor;
        for (int i = 0; i < kBars; ++i) {
            const auto y = -static_cast<float>(i);
            BodyDef def = body_of(Shape::box(Vec3(0.1F, 0.5F, 0.1F)), 1.0F, Vec3(0, y - 0.5F, 0));
            def.filter.mask = 0;
            def.damping = {damping, damping};
            bars.push_back(world.add(def));
            JointDef joint;
            joint.a = last;
            joint.b = bars.back();
            joint.anchor = Vec3(0.0F, y, 0.0F);
            joints.push_back(world.join(joint));
            last = bars.back();
        }
    }

    [[nodiscard]] double gap() const {
        double widest = 0.0;
        for (const JointId joint : joints) {
            widest = std::max(widest, world.joint_at(joint));
        }
        return widest;
    }

    /// Of the bar that spins fastest, rad/s.
    [[nodiscard]] double spin() const {
        double fastest = 0.0;
        for (const BodyId bar : bars) {
            fastest = std::max(fastest,
                               static_cast<double>(world.scene.state(bar).angular_velocity.norm()));
        }
        return fastest;
    }
};

/// Highest speed of a bar of a chain at rest whose anchor is pulled at `pull` m/s and stopped
/// again. As seen from an anchor of constant speed, joints do no work. Let |v| be the root of the
/// sum of m v^2 over the bars, of mass m each and M together. Starting and stopping change |v| by
/// pull sqrt(M) each. All of it may end up in one bar, together with the energy of the chain's
/// height.
double whip(double pull) {
    const double speed = 2.0 * pull;
    return std::sqrt(Chain::kBars * (speed * speed + 2.0 * kG * 2.0 * Chain::kBars));
}

/// The anchor of a chain at rest jumps. Separated joints close at 20 m/s. The bars' turning opens a
/// quarter of the gap again. So the gap is closed after the distance over that speed, and a quarter
/// of a second for the bars to follow one another.
void jumping_chain(Run& run, float distance, const Vec3& way, const std::string& name) {
    World world(run,
                "anchor-jumps",
                "chain, " + whole(100.0 * static_cast<double>(distance)) + " cm " + name);
    world.floor_y = -6.0F;
    Chain chain(world);
    world.run(0.5F);
    BodyState s = world.scene.state(chain.anchor);
    s.position += distance * way;
    world.scene.set_state(chain.anchor, s);
    world.run(distance / static_cast<float>(kUndo) + 0.25F);
    const double gap = chain.gap();
    world.run(run.pick(1.0F, 5.0F));
    world.limits.speed_mps = whip(1.25 * kUndo);
    world.row.check("gap_after_m", gap, 0.05);
    world.finish();
}

/// The anchor is carried by teleports alone, step by step, at `speed` m/s. The joints see jumps of
/// speed x step and undo each within 50 ms, so that they lag by speed x 50 ms and one jump.
void carried_chain(Run& run, float speed) {
    World world(run, "anchor-jumps", "carried at " + whole(speed) + " m/s");
    world.floor_y = -6.0F;
    Chain chain(world, 2.0F);
    double gap = 0.0;
    for (int i = 0; i < run.pick(120, 600); ++i) {
        BodyState s = world.scene.state(chain.anchor);
        s.position.x() += speed * kFrame;
        world.scene.set_state(chain.anchor, s);
        if (!world.step()) {
            break;
        }
        gap = std::max(gap, chain.gap());
    }
    world.limits.speed_mps = whip(1.25 * kUndo);
    world.row.check("gap_m", gap, static_cast<double>(speed * (kUndoTime_s + kFrame)) + 0.01);
    world.finish();
}

/// The anchor shakes with up to `most` m/s2, and the bars lose c = 2 of their speed per second. As
/// seen from the anchor (see `whip`), |v| grows by (a + g) sqrt(M) per second. The damping adds c u
/// sqrt(M), where u is the anchor's speed, and takes c |v|. So |v| stays below the ratio of gain
/// and loss, and all of it may be in one bar. Joints hold to a hundredth of a bar, plus the gap
/// that acceleration and the bars' turning open in a substep.
void shaken_chain(Run& run, double most) {
    constexpr double kDamping = 2.0;
    constexpr double kSubstep = 1.0 / 240.0;
    World world(run, "anchor-shakes", "chain, " + whole(most) + " m/s2");
    world.floor_y = -6.0F;
    Chain chain(world, static_cast<float>(kDamping));
    const double turn = 2.0 * std::numbers::pi * 2.0;  // twice a second
    const double speed = most / turn;
    double gap = 0.0;
    double spin = 0.0;
    for (int i = 0; i < run.pick(180, 1200); ++i) {
        const double t = (i + 0.5) * static_cast<double>(kFrame);
        const Vec3d v(speed * std::cos(turn * t), 0.0, 0.3 * speed * std::sin(0.7 * turn * t));
        world.scene.set_velocity(chain.anchor, v.cast<float>(), Vec3::Zero());
        if (!world.step()) {
            break;
        }
        gap = std::max(gap, chain.gap());
        spin = std::max(spin, chain.spin());
    }
    const double anchor = 1.05 * speed;  // both directions of the shaking
    const double share = std::sqrt(1.0 * Chain::kBars);
    world.limits.speed_mps = share * (1.05 * most + kG + kDamping * anchor) / kDamping + anchor;
    const double turned = std::min(spin * kSubstep, 2.0);
    world.row.check(
        "gap_m", gap, 0.01 + 0.5 * most * kSubstep * kSubstep + 0.5 * turned * turned * 0.5);
    world.finish();
}

/// A ball hangs a metre below an anchor that begins to accelerate. In the anchor's frame gravity
/// leans by atan(a / g), and the ball swings to twice that angle. Anchor speeds change once a step,
/// by 1/60 of a swing or so: 2 % of the angle are granted for it.
void pendulum(Run& run, double a) {
    World world(run, "anchor-pulls", "pendulum, " + whole(a) + " m/s2");
    const BodyId anchor = world.add(anchor_at(Shape::sphere(0.1F), Vec3::Zero()));
    BodyDef def = body_of(Shape::sphere(0.05F), 1.0F, Vec3(0.0F, -1.0F, 0.0F));
    def.filter.mask = 0;
    const BodyId ball = world.add(def);
    JointDef joint;
    joint.a = anchor;
    joint.b = ball;
    const JointId held = world.join(joint);
    double widest = 0.0;
    double gap = 0.0;
    const int steps = 120;
    for (int i = 0; i < steps; ++i) {
        const double v = a * (i + 0.5) * static_cast<double>(kFrame);
        world.scene.set_velocity(anchor, Vec3(static_cast<float>(v), 0, 0), Vec3::Zero());
        if (!world.step()) {
            break;
        }
        const Vec3d hangs = world.watch(ball).position.cast<double>() -
                            world.scene.state(anchor).position.cast<double>();
        widest = std::max(widest, std::atan2(-hangs.x(), -hangs.y()));
        gap = std::max(gap, world.joint_at(held));
    }
    const double exact = 2.0 * std::atan(a / kG);
    world.limits.speed_mps = a * steps * static_cast<double>(kFrame) + std::sqrt(4.0 * (a + kG));
    world.row.check("swing_error_share", std::abs(widest - exact) / exact, 0.02);
    world.row.check("gap_m", gap, 0.01);
    world.finish();
}

/// A platform with boxes on it, one upon the other.
struct Platform {
    World& world;
    BodyId id;
    std::vector<BodyId> boxes;

    Platform(World& w, int count, float half_width) : world(w) {
        id = world.add(anchor_at(Shape::box(Vec3(half_width, 0.5F, half_width)), Vec3::Zero()));
        for (int i = 0; i < count; ++i) {
            boxes.push_back(world.add(body_of(Shape::box(Vec3::Constant(0.5F)),
                                              1.0F,
                                              Vec3(0.0F, 1.0F + static_cast<float>(i), 0.0F))));
        }
    }

    /// Furthest that a box has shifted on the platform, m.
    [[nodiscard]] double shift() const {
        const auto x = world.scene.state(id).position.x();
        double most = 0.0;
        for (const BodyId box : boxes) {
            most = std::max(most, std::abs(static_cast<double>(world.watch(box).position.x() - x)));
        }
        return most;
    }

    /// How far the lowest box's centre is below where it would lie, m.
    [[nodiscard]] double sunk() const {
        const auto top = world.scene.state(id).position.y() + 0.5F;
        double most = 0.0;
        for (const BodyId box : boxes) {
            most = std::max(most, static_cast<double>(top + 0.5F - world.watch(box).position.y()));
        }
        return most;
    }

    void jump(const Vec3& way) {
        BodyState s = world.scene.state(id);
        s.position += way;
        world.scene.set_state(id, s);
    }
};

/// The platform starts and stops with 0.2 g. Friction (0.5) carries three boxes along, and they
/// would tip only at a third of g. Each contact may shear by its budget, twice when it starts and
/// stops.
void followed(Run& run) {
    World world(run, "anchor-pulls", "three boxes follow at 0.2 g");
    Platform platform(world, 3, 5.0F);
    world.run(1.0F);
    double shift = 0.0;
    float v = 0.0F;
    for (int i = 0; i < 300; ++i) {
        v += (i < 120 ? 0.2F : (i < 180 ? 0.0F : -0.2F)) * 9.81F * kFrame;
        world.scene.set_velocity(platform.id, Vec3(v, 0.0F, 0.0F), Vec3::Zero());
        if (!world.step()) {
            break;
        }
        shift = std::max(shift, platform.shift());
    }
    world.limits.depth_m = 2.0 * kGive;
    world.limits.speed_mps = 0.2 * kG * 2.0 + 0.2;
    world.row.check("shift_m", shift, 2.0 * 3.0 * 2.0 * kGive);
    world.finish();
}

/// The platform leaves with 2 g: friction of 0.5 gives the box g / 2 and no more, so it moves by mu
/// g t^2 / 2. A step's worth of that and 2 % are granted.
void slid(Run& run) {
    World world(run, "anchor-pulls", "a box slides at 2 g");
    Platform platform(world, 1, 12.0F);
    world.run(1.0F);
    double worst = 0.0;
    for (int i = 0; i < 45; ++i) {
        const float v = 2.0F * 9.81F * static_cast<float>(i + 1) * kFrame;
        world.scene.set_velocity(platform.id, Vec3(v, 0.0F, 0.0F), Vec3::Zero());
        if (!world.step()) {
            break;
        }
        const double t = (i + 1) * static_cast<double>(kFrame);
        const double exact = 0.25 * kG * t * t;
        const auto x = static_cast<double>(world.watch(platform.boxes[0]).position.x());
        const double step = 0.5 * kG * t * static_cast<double>(kFrame);
        worst = std::max(worst, std::abs(x - exact) - 0.02 * exact - step);
    }
    world.limits.depth_m = 2.0 * kGive;
    world.limits.speed_mps = 0.5 * kG * 0.75 + 0.3;
    world.row.check("slide_error_m", worst, 1.0e-3);
    world.finish();
}

/// The platform, as wide as its room, shakes up and down with accelerations beyond g. A thrown box
/// comes back as fast and is thrown again. An elastic hit would add twice the platform's speed;
/// this one adds the platform's own, and 3 m/s for overlap. Nothing comes through the platform.
void shaken_stack(Run& run, double speed) {
    World world(run, "anchor-shakes", "stack, " + whole(speed) + " m/s");
    world.floor_y = -3.0F;
    Platform platform(world, 3, 4.0F);
    for (const float side : {-1.0F, 1.0F}) {
        world.wall(Vec3(side * 5.05F, 5.0F, 0.0F), Vec3(1.0F, 12.0F, 8.0F));
        world.wall(Vec3(0.0F, 5.0F, side * 5.05F), Vec3(8.0F, 12.0F, 1.0F));
    }
    const double turn = 2.0 * std::numbers::pi * 3.0;  // three times a second
    double sunk = 0.0;
    for (int i = 0; i < run.pick(300, 1800); ++i) {
        const double t = (i + 0.5) * static_cast<double>(kFrame);
        world.scene.set_velocity(
            platform.id, Vec3(0, static_cast<float>(speed * std::cos(turn * t)), 0), Vec3::Zero());
        if (!world.step()) {
            break;
        }
        sunk = std::max(sunk, platform.sunk());
    }
    world.limits.speed_mps = 2.0 * speed + kPush + std::sqrt(2.0 * kG * 3.0);
    // A box that lies on an edge or a corner is not lower than one that lies flat. It sinks by the
    // distance that an impact at that speed closes in a substep.
    world.row.check("sunk_m", sunk, 4.0 * kGive + 2.0 * speed / 240.0);
    world.finish();
}

/// The platform is taken away from under boxes that sleep: they wake and fall freely. It is put
/// back, into them: they are pushed out at 3 m/s, which may lift them by another 9 / 2 g m.
void jumping_stack(Run& run) {
    World world(run, "anchor-jumps", "stack");
    Platform platform(world, 3, 5.0F);
    world.fault_at = 125;  // in the fall
    world.run(2.0F);
    const auto awake = std::count_if(platform.boxes.begin(), platform.boxes.end(), [&](BodyId id) {
        return !world.scene.state(id).asleep;
    });
    std::vector<double> from;
    for (const BodyId id : platform.boxes) {
        from.push_back(static_cast<double>(world.watch(id).position.y()));
    }
    platform.jump(Vec3(0.0F, -5.0F, 0.0F));
    double worst = 0.0;
    for (int i = 1; i <= 30 && world.step(); ++i) {
        const double t = i * static_cast<double>(kFrame);
        for (std::size_t k = 0; k < platform.boxes.size(); ++k) {
            const auto y = static_cast<double>(world.watch(platform.boxes[k]).position.y());
            worst = std::max(worst, std::abs(y - from[k] + 0.5 * kG * t * t));
        }
    }
    world.run(3.0F);
    double sunk = 0.0;
    for (const float lift : {0.1F, 0.3F, 0.45F}) {
        platform.jump(Vec3(0.0F, lift, 0.0F));
        world.run(2.0F);
        sunk = std::max(sunk, platform.sunk());
    }
    world.limits.speed_mps = kPush + std::sqrt(2.0 * kG * 5.0);
    world.row.check("awake_bodies", static_cast<double>(awake), 0.0);
    // The three are one column: they fall together, and the contacts between them may give way
    // again.
    world.row.check("fall_error_m", worst, 3.0 * kGive);
    world.row.check("sunk_m", sunk, 2.0 * kGive);
    world.finish();
}

void anchors(Run& run) {
    for (const float distance : run.pick<std::vector<float>>({1.0F}, {0.1F, 1.0F, 10.0F, 100.0F})) {
        jumping_chain(run, distance, Vec3::UnitX(), "aside");
        jumping_chain(run, distance, Vec3::UnitY(), "up");
        jumping_chain(run, distance, -Vec3::UnitY(), "down");
    }
    for (const float speed : run.pick<std::vector<float>>({5.0F}, {1.0F, 5.0F, 15.0F})) {
        carried_chain(run, speed);
    }
    for (const double most : run.pick<std::vector<double>>({50.0}, {10.0, 50.0, 200.0, 1000.0})) {
        shaken_chain(run, most);
    }
    for (const double a : run.pick<std::vector<double>>({10.0}, {1.0, 10.0, 50.0})) {
        pendulum(run, a);
    }
    followed(run);
    slid(run);
    for (const double speed : run.pick<std::vector<double>>({3.0}, {1.0, 3.0, 10.0})) {
        shaken_stack(run, speed);
    }
    jumping_stack(run);
}

}  // namespace

std::vector<Case> anchor_cases() {
    return {{"anchor",
             "joints and stacks on kinematic bodies that are teleported and accelerated",
             anchors}};
}

}  // namespace zoned::stability
