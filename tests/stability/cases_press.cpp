// Bodies that cannot get away: presses, kinematic capsules, crossing movers.
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <cmath>

namespace zoned::stability {

namespace {

/// How fast a body may leave a press whose walls close at `closing` m/s, with friction mu. A wall
/// gives its own speed. From between two walls that form a wedge of half angle alpha a body slips
/// at closing / (2 tan alpha). It does not slip where tan alpha < mu (it locks itself). The speed
/// at which overlap is undone (3 m/s) and that of the fall are added.
double speed_from_press(double closing, double friction, double fall) {
    return closing + closing / (2.0 * friction) + 3.0 + std::sqrt(2.0 * 9.81 * fall);
}

/// The worst of twelve seeds is nine times the closing speed.
void know_pinched(Row& row, double closing, double fall) {
    row.know(
        "bodies pinched by several movers and neighbours at once leave at up to 10 times the speed "
        "at which those close",
        {{"speed_mps", 10.0 * closing + std::sqrt(2.0 * kG * fall)}});
}

BodyDef mover(const Shape& shape, const Vec3& position) {
    BodyDef def;
    def.kind = BodyKind::kKinematic;
    def.shape = shape;
    def.position = position;
    return def;
}

/// A plate comes down on one body on the ground, stops at half of its height, stays and goes up.
void press_one(Run& run, float speed, int form) {
    World world(run,
                "press-one",
                std::string(form == 0 ? "sphere" : (form == 1 ? "box" : "capsule")) + ", " +
                    std::to_string(static_cast<int>(speed)) + " m/s");
    world.ground();
    world.add(mixed_body(form, Vec3(0.03F, 0.5F, 0.02F)));
    const BodyId plate =
        world.add(mover(Shape::box(Vec3(3.0F, 0.5F, 3.0F)), Vec3(0.0F, 2.5F + speed * 0.2F, 0.0F)));
    world.limits.speed_mps = speed_from_press(static_cast<double>(speed), 0.5, 1.0);
    const auto travel = [&](float goal, float way) {
        for (int i = 0; i < 600 && (world.scene.state(plate).position.y() - goal) * way < 0.0F;
             ++i) {
            world.scene.set_velocity(plate, Vec3(0.0F, way * speed, 0.0F), Vec3::Zero());
            world.step();
        }
        world.scene.set_velocity(plate, Vec3::Zero(), Vec3::Zero());
    };
    travel(1.0F, -1.0F);
    world.run(1.0F);
    travel(3.0F, 1.0F);
    world.run(1.0F);
    world.finish();
}

/// A heap in a shaft, pressed to half of its volume and let go, three times.
void press_heap(Run& run, float speed, std::uint64_t seed) {
    World world(run,
                "press-heap",
                std::to_string(static_cast<int>(speed)) + " m/s, seed " + std::to_string(seed));
    world.room(2.5F, 30.0F);
    core::Rng rng(seed, 7);
    for (int i = 0; i < 64; ++i) {
        const float jitter = rng.range(-0.05F, 0.05F);
        world.add(mixed_body(i,
                             Vec3(static_cast<float>(i % 4) * 1.15F - 1.75F + jitter,
                                  0.7F + static_cast<float>(i / 16) * 1.2F,
                                  static_cast<float>(i / 4 % 4) * 1.15F - 1.75F - jitter)));
    }
    const BodyId plate =
        world.add(mover(Shape::box(Vec3(2.45F, 0.5F, 2.45F)), Vec3(0.0F, 9.0F, 0.0F)));
    world.run(1.0F);
    know_pinched(world.row, static_cast<double>(speed), 9.0);
    world.limits.inside.reset();  // the press itself may push bodies through a wall
    world.limits.speed_mps = speed_from_press(static_cast<double>(speed), 0.5, 9.0);
    for (int stroke = 0; stroke < run.pick(1, 3); ++stroke) {
        for (const auto& [way, goal] : {std::pair(-1.0F, 2.0F), std::pair(1.0F, 9.0F)}) {
            for (int i = 0; i < 600 && (world.scene.state(plate).position.y() - goal) * way < 0.0F;
                 ++i) {
                world.scene.set_velocity(plate, Vec3(0.0F, way * speed, 0.0F), Vec3::Zero());
                world.step();
            }
            world.scene.set_velocity(plate, Vec3::Zero(), Vec3::Zero());
            world.run(0.5F);
        }
    }
    world.finish();
}

/// Capsules that walk where they want, as players do, among capsules and boxes in a room, into its
/// corners and through each other.
void crowd(Run& run, float speed, std::uint64_t seed) {
    World world(run,
                "crowd-corner",
                std::to_string(static_cast<int>(speed)) + " m/s, seed " + std::to_string(seed));
    world.room(5.0F, 20.0F);
    core::Rng rng(seed, 8);
    for (int i = 0; i < 30; ++i) {
        const Vec3 at(static_cast<float>(i % 6) * 1.5F - 3.75F,
                      1.0F,
                      static_cast<float>(i / 6) * 1.8F - 3.6F);
        world.add(i % 2 == 0 ? body_of(Shape::capsule(0.4F, 0.5F), 80.0F, at)
                             : body_of(Shape::box(Vec3::Constant(0.4F)), 20.0F, at));
    }
    std::vector<BodyId> walkers;
    std::vector<Vec3> goals(6, Vec3::Zero());
    for (int i = 0; i < 6; ++i) {
        walkers.push_back(world.add(
            mover(Shape::capsule(0.4F, 0.5F), Vec3(static_cast<float>(i) - 2.5F, 0.9F, -4.6F))));
    }
    know_pinched(world.row, 2.0 * static_cast<double>(speed), 4.0);
    world.limits.inside.reset();
    // Two walkers that meet close at twice their speed. Bodies that climb may fall 4 m.
    world.limits.speed_mps = speed_from_press(2.0 * static_cast<double>(speed), 0.5, 4.0);
    const int steps = run.pick(600, 3600);
    for (int step = 0; step < steps; ++step) {
        for (std::size_t i = 0; i < walkers.size(); ++i) {
            if (step % 90 == static_cast<int>(i) * 15) {
                const float side_x = rng.below(2) == 0 ? -4.7F : 4.7F;
                const float side_z = rng.below(2) == 0 ? -4.7F : 4.7F;
                goals[i] = Vec3(side_x, 0.9F, side_z);
            }
            const Vec3 way = goals[i] - world.scene.state(walkers[i]).position;
            const float far = way.norm();
            world.scene.set_velocity(
                walkers[i],
                far > speed * kFrame ? Vec3(way * (speed / far)) : Vec3(Vec3::Zero()),
                Vec3::Zero());
        }
        if (!world.step()) {
            break;
        }
    }
    world.finish();
}

void presses(Run& run) {
    for (const float speed : run.pick<std::vector<float>>({6.0F}, {1.0F, 6.0F, 30.0F})) {
        for (int form = 0; form < 3; ++form) {
            press_one(run, speed, form);
        }
    }
    for (std::uint64_t k = 0; k < run.pick(1U, 12U); ++k) {
        press_heap(run, 6.0F, run.seed + k);
    }
    for (std::uint64_t k = 0; k < run.pick(2U, 12U); ++k) {
        crowd(run, 6.0F, run.seed + k);
    }
}

}  // namespace

std::vector<Case> press_cases() {
    return {{"press",
             "bodies between movers and walls: none leaves faster than a wedge can throw",
             presses}};
}

}  // namespace zoned::stability
