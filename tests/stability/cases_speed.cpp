// Speed and spin: bullets of several shapes, and bodies that spin.
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <array>
#include <cmath>
#include <numbers>

namespace zoned::stability {

namespace {

Quat any_orientation(core::Rng& rng) {
    // Four normal-like numbers: sums of uniform ones.
    const auto number = [&rng] {
        return rng.unit() + rng.unit() + rng.unit() - 1.5F;
    };
    const float w = number();
    const float x = number();
    const float y = number();
    const float z = number();
    return Quat(w, x, y, z).normalized();
}

Shape bullet_shape(int i) {
    constexpr float kSize = 0.1F;
    switch (i % 4) {
        case 0:
            return Shape::sphere(kSize);
        case 1:
            return Shape::box(Vec3::Constant(kSize));
        case 2:
            return Shape::capsule(kSize, 2.0F * kSize);
        default:
            return Shape::box(Vec3(3.0F * kSize, 0.5F * kSize, kSize));
    }
}

std::string speed_name(float speed) {
    return std::to_string(static_cast<int>(speed)) + " m/s";
}

/// Bullets of all shapes, turned and spinning in all directions, towards a wall 0.1 m thick at x =
/// 0 that none can get around. None comes through; the static wall adds no energy.
void walls(Run& run, float speed) {
    World world(run, "bullets-walls", speed_name(speed), weightless());
    core::Rng rng(run.seed, 1);
    const int count = run.pick(40, 200);
    world.wall(Vec3(0.05F, 0.0F, 0.0F), Vec3(0.05F, 1.0e4F, 1.0e4F));
    for (int i = 0; i < count; ++i) {
        const auto z = static_cast<float>(i) * 4.0F;
        BodyDef def = body_of(
            bullet_shape(i), 1.0F, Vec3(-1.0F - speed * kFrame * rng.range(0.0F, 2.0F), 0.0F, z));
        def.velocity = Vec3(speed, 0.0F, 0.0F);
        def.orientation = any_orientation(rng);
        if (i >= count / 2) {
            const float wx = rng.range(-30.0F, 30.0F);
            const float wy = rng.range(-30.0F, 30.0F);
            def.angular_velocity = Vec3(wx, wy, 0.0F);
        }
        world.add(def);
    }
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = 1.01 * static_cast<double>(speed);
    std::uint64_t passed = 0;
    world.run(0.5F);
    for (const World::Known& body : world.bodies()) {
        const BodyState s = world.scene.state(body.id);
        passed += body.def.kind == BodyKind::kDynamic && s.position.x() > 0.05F ? 1 : 0;
    }
    world.row.check("passed_through", static_cast<double>(passed), 0.0);
    world.finish();
}

/// Two clouds that fly at each other in free space: momentum stays, energy only falls.
void clouds(Run& run, float speed) {
    World world(run, "bullets-meet", speed_name(speed), weightless());
    core::Rng rng(run.seed, 2);
    const int count = run.pick(40, 200);
    for (int i = 0; i < count; ++i) {
        const float side = i % 2 == 0 ? -1.0F : 1.0F;
        const float back = speed * kFrame * rng.range(0.5F, 1.5F);
        const float y = static_cast<float>(i / 2 % 10) + rng.range(-0.05F, 0.05F);
        const float z = static_cast<float>(i / 20) + rng.range(-0.05F, 0.05F);
        BodyDef def = body_of(bullet_shape(i / 2), 1.0F, Vec3(side * (1.0F + back), y, z));
        def.velocity = Vec3(-side * speed, 0.0F, 0.0F);
        def.orientation = any_orientation(rng);
        def.material.restitution = i % 3 == 0 ? 0.8F : 0.0F;
        world.add(def);
    }
    world.limits.energy_share = 1.0e-3;
    // A light end of a body may be flicked: its centre is at most twice as fast as the other body.
    world.limits.speed_mps = 2.0 * static_cast<double>(speed);
    // Rounding of floats, 6e-8, per collision; some hundred collisions of each body.
    world.limits.momentum_share = 1.0e-4;
    world.run(0.5F);
    world.finish();
}

/// Bullets into a pile in a closed room: the pile takes the energy, and no body leaves.
void into_pile(Run& run, float speed) {
    World world(run, "bullets-pile", speed_name(speed));
    world.room(5.0F, 10.0F);
    core::Rng rng(run.seed, 3);
    for (int i = 0; i < 64; ++i) {
        world.add(mixed_body(i,
                             Vec3(static_cast<float>(i % 4) * 1.1F - 1.7F,
                                  0.6F + static_cast<float>(i / 16) * 1.1F,
                                  static_cast<float>(i / 4 % 4) * 1.1F - 1.7F)));
    }
    world.run(1.0F);
    for (int i = 0; i < run.pick(4, 20); ++i) {
        const float y = rng.range(0.5F, 4.0F);
        const float z = rng.range(-2.0F, 2.0F);
        BodyDef def = body_of(bullet_shape(i), 1.0F, Vec3(-4.5F, y, z));
        def.velocity = Vec3(speed, 0.0F, 0.0F);
        world.add(def);
        world.run(0.2F);
    }
    world.run(1.0F);
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = 2.0 * static_cast<double>(speed);
    world.finish();
}

void bullets(Run& run) {
    const auto speeds =
        run.pick<std::vector<float>>({100.0F, 1.0e4F}, {30.0F, 100.0F, 1.0e3F, 1.0e4F});
    for (const float speed : speeds) {
        walls(run, speed);
        clouds(run, speed);
        into_pile(run, speed);
    }
}

/// Free rotation keeps energy and angular momentum, however fast (rad/s) and uneven.
void free_spin(Run& run, float rate) {
    World world(run, "spin-free", std::to_string(static_cast<int>(rate)) + " rad/s", weightless());
    core::Rng rng(run.seed, 4);
    for (int i = 0; i < 30; ++i) {
        const Vec3 half(0.5F, 0.1F + 0.3F * rng.unit(), 0.05F + 0.1F * rng.unit());
        BodyDef def =
            body_of(Shape::box(half), 1.0F, Vec3(0.0F, 0.0F, 3.0F * static_cast<float>(i)));
        def.orientation = any_orientation(rng);
        const Vec3 axis = any_orientation(rng) * Vec3::UnitX();
        def.angular_velocity = rate * axis;
        world.add(def);
    }
    // The rotation is solved so that both are kept to rounding; 600 steps of some hundred
    // roundings of 6e-8 that add up at worst.
    world.limits.energy_share = 4.0e-3;
    world.limits.momentum_share = 4.0e-3;
    world.run(run.pick(2.0F, 10.0F));
    world.finish();
}

/// Bodies that spin fall on the ground: friction turns spin into speed, and no body may have more
/// energy than there was, nor leave the room.
void spin_in_contact(Run& run, float rate) {
    World world(run, "spin-contact", std::to_string(static_cast<int>(rate)) + " rad/s");
    world.room(30.0F, 60.0F);
    core::Rng rng(run.seed, 5);
    for (int i = 0; i < 36; ++i) {
        BodyDef def = mixed_body(i,
                                 Vec3(static_cast<float>(i % 6) * 3.0F - 7.5F,
                                      1.0F,
                                      static_cast<float>(i / 6) * 3.0F - 7.5F));
        const Vec3 axis = any_orientation(rng) * Vec3::UnitX();
        def.angular_velocity = rate * axis;
        world.add(def);
    }
    world.limits.energy_share = 1.0e-3;
    // A corner of a box is 0.9 m out: it hits no faster than 0.9 m times the rate.
    world.limits.speed_mps = 10.0 + 0.9 * static_cast<double>(rate);
    world.run(run.pick(2.0F, 10.0F));
    world.finish();
}

void spins(Run& run) {
    for (const float rate : {10.0F, 100.0F, 1000.0F}) {
        free_spin(run, rate);
        spin_in_contact(run, rate);
    }
}

}  // namespace

std::vector<Case> speed_cases() {
    return {{"bullets", "bodies at up to 10 km/s: into thin walls, each other, a pile", bullets},
            {"spin", "bodies at up to 1000 rad/s: free, and on the ground", spins}};
}

}  // namespace zoned::stability
