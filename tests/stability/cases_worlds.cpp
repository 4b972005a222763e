// Worlds of many kinds: far from the origin, for very long, on surfaces, of all sizes, teleported.
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::stability {

namespace {

/// Positions are floats: at 10^6 m they lie 0.0625 m apart, at 10^5 m 0.0078 m. A body moves in
/// such steps or not at all. A stack there may sink by two of them per contact, and shake by one
/// per step. It must neither fall nor fly.
void far_stack(Run& run, float far) {
    World world(run, "far", std::to_string(static_cast<int>(far)) + " m");
    const float spacing = std::nextafter(far, 2.0F * far) - far;
    world.wall(Vec3(far, -1.0F, far), Vec3(20.0F, 1.0F, 20.0F));
    for (int i = 0; i < 5; ++i) {
        world.add(body_of(
            Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(far, 0.5F + static_cast<float>(i), far)));
    }
    world.limits.depth_m = 0.01 + 2.0 * static_cast<double>(spacing);
    world.limits.drift_m = 0.05 + 10.0 * static_cast<double>(spacing);
    world.limits.speed_mps = 1.0 + static_cast<double>(spacing) * 60.0;
    world.limits.energy_share = 0.01;
    world.run(run.pick(5.0F, 20.0F));
    world.finish();
}

void far(Run& run) {
    for (const float at : {1.0e3F, 1.0e5F, 9.0e5F}) {
        far_stack(run, at);
    }
}

/// A ball without friction that bounces for ever, a pendulum, a top: energy may drift by rounding,
/// a millionth of a millionth per step at random, and by no law of its own.
void long_runs(Run& run) {
    const int steps = run.pick(20'000, 1'000'000);
    physics::PhysicsSettings awake;
    awake.sleep_after_s = 0.0F;
    const auto repeat = [&](World& world) {
        for (int i = 0; i < steps && world.step(); ++i) {
        }
        world.finish();
    };
    {
        World world(run, "long", "bouncing ball", awake);
        world.ground();
        BodyDef ball = body_of(Shape::sphere(0.5F), 1.0F, Vec3(0.0F, 10.5F, 0.0F));
        ball.material.restitution = 1.0F;
        ball.material.friction = 0.0F;
        world.add(ball);
        world.limits.energy_share = 0.01;
        world.limits.speed_mps = 14.2;
        repeat(world);
    }
    {
        World world(run, "long", "pendulum", awake);
        world.floor_y = -2.0F;
        JointDef joint;
        joint.b = world.add(body_of(Shape::sphere(0.2F), 1.0F, Vec3(1.0F, 0.0F, 0.0F)));
        world.join(joint);
        world.limits.energy_share = 0.01;
        world.limits.speed_mps = 4.6;  // sqrt(2 g 1) and 4 %
        repeat(world);
    }
    {
        physics::PhysicsSettings weightless = awake;
        weightless.gravity = Vec3::Zero();
        World world(run, "long", "spinning top", weightless);
        BodyDef top = body_of(Shape::box(Vec3(0.5F, 0.2F, 0.3F)), 1.0F, Vec3::Zero());
        top.angular_velocity = Vec3(0.1F, 3.0F, 0.2F);
        world.add(top);
        world.limits.energy_share = 0.01;
        world.limits.momentum_share = 0.01;
        repeat(world);
    }
    World world(run, "long", "resting pile", awake);
    world.room(2.5F, 10.0F);
    for (int i = 0; i < 27; ++i) {
        world.add(mixed_body(i,
                             Vec3(static_cast<float>(i % 3) * 1.2F - 1.2F,
                                  0.7F + static_cast<float>(i / 9) * 1.2F,
                                  static_cast<float>(i / 3 % 3) * 1.2F - 1.2F)));
    }
    world.limits.energy_share = 1.0e-3;
    world.limits.depth_m = 0.05;
    world.limits.speed_mps = 9.0;
    world.look_every = 50;
    for (int i = 0; i < run.pick(2'000, 60'000) && world.step(); ++i) {
    }
    world.row.check("speed_at_end_mps", world.speed(), 0.05);
    world.finish();
}

std::shared_ptr<const physics::ConvexHull> rock(core::Rng& rng) {
    std::vector<Vec3> points;
    for (int i = 0; i < 16; ++i) {
        const float x = rng.range(-0.5F, 0.5F);
        const float y = rng.range(-0.5F, 0.5F);
        const float z = rng.range(-0.5F, 0.5F);
        points.emplace_back(x, y, z);
    }
    return physics::build_hull(points)->hull;
}

std::shared_ptr<const physics::Compound> dumbbell() {
    std::vector<physics::CompoundPart> parts(3);
    parts[0].shape = Shape::sphere(0.3F);
    parts[0].frame.position = Vec3(-0.5F, 0.0F, 0.0F);
    parts[1].shape = Shape::box(Vec3(0.5F, 0.1F, 0.1F));
    parts[2].shape = Shape::sphere(0.3F);
    parts[2].frame.position = Vec3(0.5F, 0.0F, 0.0F);
    return physics::build_compound(parts)->compound;
}

/// Height of the hilly floor: all below 0.
float hill(int i, int k) {
    return -0.6F +
           0.5F * std::sin(0.7F * static_cast<float>(i)) * std::cos(0.9F * static_cast<float>(k));
}

constexpr int kSide = 25;

Shape field() {
    std::vector<float> heights;
    for (int k = 0; k < kSide; ++k) {
        for (int i = 0; i < kSide; ++i) {
            heights.push_back(hill(i, k));
        }
    }
    physics::FieldOptions options;
    options.columns = options.rows = kSide;
    return Shape::heightfield(*physics::build_heightfield(heights, options));
}

Shape mesh() {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> indices;
    const float middle = 0.5F * (kSide - 1);
    for (int k = 0; k < kSide; ++k) {
        for (int i = 0; i < kSide; ++i) {
            vertices.emplace_back(
                static_cast<float>(i) - middle, hill(i, k), static_cast<float>(k) - middle);
        }
    }
    for (std::uint32_t k = 0; k + 1 < kSide; ++k) {
        for (std::uint32_t i = 0; i + 1 < kSide; ++i) {
            const std::uint32_t at = k * kSide + i;
            for (const std::uint32_t corner :
                 {at, at + kSide, at + 1, at + 1, at + kSide, at + kSide + 1}) {
                indices.push_back(corner);
            }
        }
    }
    return Shape::mesh(physics::build_mesh(vertices, indices)->mesh);
}

/// Spheres, boxes, capsules, hulls and compounds rain onto a surface inside of walls. Nobody falls
/// through it: centres stay above its lowest point.
void rain(Run& run, const std::string& name, const Shape& floor) {
    World world(run, "surface", name);
    world.floor_y = -1.1F;
    core::Rng rng(run.seed, 20);
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = floor;
    if (floor.kind == physics::ShapeKind::kBox) {
        ground.position.y() = -floor.half_extents.y();  // its top is y = 0
    }
    world.add(ground);
    for (const float side : {-1.0F, 1.0F}) {
        world.wall(Vec3(side * 7.0F, 10.0F, 0.0F), Vec3(1.0F, 15.0F, 8.0F));
        world.wall(Vec3(0.0F, 10.0F, side * 7.0F), Vec3(8.0F, 15.0F, 1.0F));
    }
    for (int i = 0; i < run.pick(60, 250); ++i) {
        const Vec3 at(static_cast<float>(i % 5) * 1.6F - 3.2F + rng.range(-0.1F, 0.1F),
                      1.0F + static_cast<float>(i / 25) * 1.3F,
                      static_cast<float>(i / 5 % 5) * 1.6F - 3.2F);
        BodyDef def = mixed_body(i, at);
        if (i % 5 == 3) {
            def.shape = Shape::hull(rock(rng));
        } else if (i % 5 == 4) {
            def.shape = Shape::compound(dumbbell());
        }
        world.add(def);
    }
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = 20.0;  // a fall of 15 m gives 17 m/s
    world.limits.inside = Aabb{Vec3(-6.0F, -1.1F, -6.0F), Vec3(6.0F, 25.0F, 6.0F)};
    world.run(run.pick(4.0F, 15.0F));
    world.finish();
}

void surfaces(Run& run) {
    rain(run, "heightfield", field());
    rain(run, "mesh", mesh());
    rain(run, "box", Shape::box(Vec3(20.0F, 0.6F, 20.0F)));
}

/// Sizes of 1 cm to 100 m, of one density, dropped side by side and on each other.
void sizes(Run& run) {
    World world(run, "sizes", "1 cm to 100 m");
    world.ground(1000.0F);
    for (const float size : {0.01F, 0.03F, 0.1F, 0.3F, 1.0F, 3.0F, 10.0F, 30.0F, 100.0F}) {
        for (int k = 0; k < 6; ++k) {
            BodyDef def = mixed_body(k,
                                     Vec3(3.0F * size * static_cast<float>(k % 3),
                                          (0.6F + 1.2F * static_cast<float>(k / 3)) * size,
                                          -4.0F * size),
                                     size);
            def.mass *= 500.0F;  // a density of about 500 kg/m3
            world.add(def);
        }
    }
    world.limits.energy_share = 1.0e-3;
    // The largest fall by tens of metres.
    world.limits.speed_mps = 60.0;
    world.run(run.pick(5.0F, 20.0F));
    world.finish();
}

/// Bodies that are put into each other part at the speed at which overlap is undone (3 m/s each
/// contact; a body between several gets their sum at most, say three), and fall.
void overlaps(Run& run, int count, float spread) {
    World world(run,
                "teleport",
                std::to_string(count) + " bodies within " +
                    std::to_string(static_cast<int>(100.0F * spread)) + " cm");
    world.room(10.0F, 20.0F);
    core::Rng rng(run.seed, 21);
    std::vector<BodyId> ids;
    for (int i = 0; i < count; ++i) {
        ids.push_back(world.add(mixed_body(i,
                                           Vec3(static_cast<float>(i % 8) * 1.3F - 5.0F,
                                                0.6F,
                                                static_cast<float>(i / 8) * 1.3F - 5.0F))));
    }
    world.run(1.0F);
    for (const BodyId id : ids) {
        BodyState s;
        const float x = rng.range(-spread, spread);
        const float y = rng.range(-spread, spread);
        const float z = rng.range(-spread, spread);
        s.position = Vec3(x, 2.0F + y, z);
        world.scene.set_state(id, s);
    }
    world.run(run.pick(4.0F, 10.0F));
    world.limits.speed_mps = 9.0 + std::sqrt(2.0 * 9.81 * 4.0);
    world.finish();
}

/// Blasts in a pile: impulses add their own energy, and the pile adds none.
void blasts(Run& run) {
    World world(run, "blast", "impulses in a pile");
    world.room(8.0F, 30.0F);
    core::Rng rng(run.seed, 22);
    std::vector<BodyId> ids;
    for (int i = 0; i < 125; ++i) {
        ids.push_back(world.add(mixed_body(i,
                                           Vec3(static_cast<float>(i % 5) * 1.2F - 2.4F,
                                                0.6F + static_cast<float>(i / 25) * 1.1F,
                                                static_cast<float>(i / 5 % 5) * 1.2F - 2.4F))));
    }
    world.limits.energy_share = 1.0e-3;
    // 20 m/s are given; a light body that a heavier one hits may get twice that.
    world.limits.speed_mps = 60.0;
    for (int shot = 0; shot < run.pick(2, 8); ++shot) {
        world.run(1.0F);
        for (const World::Known& body : world.bodies()) {
            if (body.def.kind != BodyKind::kDynamic) {
                continue;
            }
            const BodyState s = world.scene.state(body.id);
            Vec3 away = s.position - Vec3(0.0F, 0.5F, 0.0F);
            away *= 20.0F / std::max(away.squaredNorm(), 1.0F);
            world.scene.apply_impulse(body.id, body.def.mass * away, s.position);
            world.supply(static_cast<double>(body.def.mass) *
                         static_cast<double>(away.dot(s.velocity) + 0.5F * away.squaredNorm()));
        }
    }
    world.run(3.0F);
    world.finish();
}

void teleports(Run& run) {
    overlaps(run, 2, 0.1F);
    overlaps(run, 20, 0.3F);
    overlaps(run, 60, 1.0F);
    blasts(run);
}

}  // namespace

std::vector<Case> world_cases() {
    return {{"far", "a stack far from the origin, where floats are coarse", far},
            {"long", "a million steps of cheap worlds, and a pile at rest", long_runs},
            {"surface", "all shapes rain onto heightfield, mesh and box", surfaces},
            {"sizes", "bodies of 1 cm to 100 m in one scene", sizes},
            {"overlap", "bodies put into each other, and blasts in a pile", teleports}};
}

}  // namespace zoned::stability
