// Ratios of masses: a heavy top, a heavy ball, a chain with a heavy end.
#include "tests/stability/world.h"

#include <algorithm>
#include <cmath>

namespace zoned::stability {

namespace {

std::string ratio_name(double ratio) {
    return "1:" + std::to_string(static_cast<long>(ratio));
}

/// The column stands when it sinks by no more than the budget per contact, and as much again while
/// loads are not known yet.
void heavy_top(Run& run, float ratio) {
    World world(run, "heavy-top", ratio_name(static_cast<double>(ratio)));
    world.ground();
    for (int i = 0; i < 5; ++i) {
        BodyDef def = body_of(Shape::box(Vec3::Constant(0.5F)),
                              i == 4 ? ratio : 1.0F,
                              Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
        def.material.friction = 0.6F;
        world.add(def);
    }
    world.limits.drift_m = 0.1;
    world.limits.depth_m = 0.05;
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = 1.5;
    world.run(10.0F);
    world.finish();
}

/// A ball falls 2 m onto boxes and comes to rest. It may sink into them while it brakes. It must
/// not go through them or throw them about faster than it came, sqrt(2 g 2) = 6.3 m/s. A box that
/// is pinched away from under it may get twice that, as a light body does in an elastic impact.
void heavy_ball(Run& run, float ratio) {
    World world(run, "heavy-ball", ratio_name(static_cast<double>(ratio)));
    world.room(6.0F, 12.0F);
    for (int i = 0; i < 16; ++i) {
        world.add(body_of(
            Shape::box(Vec3::Constant(0.5F)),
            1.0F,
            Vec3(static_cast<float>(i % 4) - 1.5F, 0.5F, static_cast<float>(i / 4) - 1.5F)));
    }
    world.add(body_of(Shape::sphere(1.0F), ratio, Vec3(0.1F, 4.0F, 0.05F)));
    world.limits.depth_m = 0.25;
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = 12.6;
    world.run(10.0F);
    world.finish();
}

/// Boxes on ball joints, level at first, with a sphere at the end. The gap of a joint is bounded by
/// a link's length over a hundred; energy by that of the first swing.
void heavy_chain(Run& run, float ratio) {
    constexpr int kLinks = 10;
    World world(run, "heavy-chain", ratio_name(static_cast<double>(ratio)));
    world.floor_y = -15.0F;
    std::vector<JointId> joints;
    BodyId last;
    for (int i = 0; i <= kLinks; ++i) {
        const bool end = i == kLinks;
        const auto x = static_cast<float>(i);
        BodyDef def =
            end ? body_of(Shape::sphere(0.5F), ratio, Vec3(x + 0.5F, 0.0F, 0.0F))
                : body_of(Shape::box(Vec3(0.5F, 0.1F, 0.1F)), 1.0F, Vec3(x + 0.5F, 0.0F, 0.0F));
        def.filter.mask = 0;
        const BodyId id = world.add(def);
        JointDef joint;
        joint.a = last;
        joint.b = id;
        joint.anchor = Vec3(x, 0.0F, 0.0F);
        joints.push_back(world.join(joint));
        last = id;
    }
    world.limits.energy_share = 0.01;
    // The end swings down by 11 m: 15 m/s; light links between may whip three times as fast.
    world.limits.speed_mps = 45.0;
    double gap = 0.0;
    for (int i = 0; i < 600 && world.step(); ++i) {
        for (const JointId joint : joints) {
            gap = std::max(gap, static_cast<double>(world.scene.joint_position(joint)));
        }
    }
    world.row.check("joint_gap_m", gap, 0.05);
    world.finish();
}

void mass_ratios(Run& run) {
    const auto ratios = run.pick<std::vector<float>>({100.0F, 1.0e4F},
                                                     {1.0F, 10.0F, 100.0F, 1.0e3F, 1.0e4F, 1.0e5F});
    for (const float ratio : ratios) {
        heavy_top(run, ratio);
        heavy_ball(run, ratio);
        heavy_chain(run, ratio);
    }
}

}  // namespace

std::vector<Case> mass_cases() {
    return {{"mass-ratio", "masses of 1 to 100,000: column, ball on boxes, chain", mass_ratios}};
}

}  // namespace zoned::stability
