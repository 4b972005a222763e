// Invalid input, and graphs of joints that no user would build.
#include "server/physics/shapes/ranges.h"
#include "tests/stability/finite_state.h"
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <array>
#include <cmath>
#include <limits>

namespace zoned::stability {

namespace {

/// Mostly sane numbers, and now and then one that is not.
float any_number(core::Rng& rng) {
    constexpr float kInf = std::numeric_limits<float>::infinity();
    constexpr std::array kOdd{0.0F,
                              -0.0F,
                              1.0e-42F,
                              -1.0F,
                              1.0e6F,
                              -1.0e9F,
                              3.0e38F,
                              -3.0e38F,
                              kInf,
                              -kInf,
                              std::numeric_limits<float>::quiet_NaN(),
                              1.0e-9F};
    return rng.below(8) == 0 ? kOdd[rng.below(kOdd.size())] : rng.range(-3.0F, 3.0F);
}

Vec3 any_vector(core::Rng& rng) {
    const float x = any_number(rng);
    const float y = any_number(rng);
    const float z = any_number(rng);
    return {x, y, z};
}

BodyDef any_body(core::Rng& rng) {
    BodyDef def;
    def.kind = rng.below(4) == 0 ? static_cast<BodyKind>(rng.below(3)) : BodyKind::kDynamic;
    def.shape.kind = static_cast<physics::ShapeKind>(rng.below(8));
    def.shape.radius = std::abs(any_number(rng));
    def.shape.half_segment = std::abs(any_number(rng));
    def.shape.half_extents = any_vector(rng).cwiseAbs();
    def.mass = any_number(rng);
    def.material.friction = std::abs(any_number(rng));
    def.sensor = rng.below(8) == 0;
    def.filter.mask = rng.below(8) == 0 ? rng.next() : 0xFFFFFFFFU;
    def.position = any_vector(rng);
    if (rng.below(8) == 0) {
        def.orientation.coeffs()[0] = any_number(rng);
    }
    def.velocity = any_vector(rng);
    def.angular_velocity = any_vector(rng);
    if (rng.below(16) == 0) {
        def.moments = any_vector(rng);
    }
    return def;
}

JointDef any_joint(core::Rng& rng, BodyId a, BodyId b) {
    JointDef def;
    def.kind = static_cast<JointKind>(rng.below(7));
    def.a = a;
    def.b = b;
    def.anchor = any_vector(rng);
    def.anchor_b = any_vector(rng);
    def.axis = any_vector(rng);
    if (def.kind == JointKind::kBall) {
        def.cone_axis = rng.below(2) == 0 ? any_vector(rng) : Vec3(Vec3::Zero());
        def.cone_rad = rng.below(2) == 0 ? any_number(rng) : rng.range(0.0F, 3.2F);
    }
    def.length_m = any_number(rng);
    def.spring_hz = any_number(rng);
    def.spring_damping_ratio = any_number(rng);
    def.limited = rng.below(2) == 0;
    def.lower = any_number(rng);
    def.upper = any_number(rng);
    def.motor = rng.below(2) == 0;
    def.motor_speed = any_number(rng);
    def.motor_max = any_number(rng);
    def.break_force_n = rng.below(2) == 0 ? any_number(rng) : def.break_force_n;
    return def;
}

/// One call with random arguments.
void poke(physics::Scene& scene,
          core::Rng& rng,
          std::vector<BodyId>& bodies,
          std::vector<JointId>& joints) {
    const BodyId id =
        bodies.empty() ? BodyId(7) : bodies[rng.below(static_cast<std::uint32_t>(bodies.size()))];
    const BodyId other =
        rng.below(8) == 0
            ? BodyId(rng.next())
            : (bodies.empty() ? BodyId()
                              : bodies[rng.below(static_cast<std::uint32_t>(bodies.size()))]);
    const bool there = scene.contains(id);
    switch (rng.below(12)) {
        case 0:
        case 1:
            if (const auto added = scene.add(any_body(rng))) {
                bodies.push_back(*added);
            }
            break;
        case 2:
            if (const auto joined = scene.add_joint(any_joint(rng, other, id))) {
                joints.push_back(*joined);
            }
            break;
        case 3:
            if (there) {
                BodyState s;
                s.position = any_vector(rng);
                s.velocity = any_vector(rng);
                s.angular_velocity = any_vector(rng);
                s.asleep = rng.below(4) == 0;
                scene.set_state(id, s);
            }
            break;
        case 4:
            if (there) {
                scene.apply_force(id, any_vector(rng), any_vector(rng));
                scene.apply_torque(id, any_vector(rng));
            }
            break;
        case 5:
            if (there) {
                scene.apply_impulse(id, any_vector(rng), any_vector(rng));
            }
            break;
        case 6:
            if (there) {
                scene.set_velocity(id, any_vector(rng), any_vector(rng));
            }
            break;
        case 7:
            if (!joints.empty()) {
                const JointId joint = joints[rng.below(static_cast<std::uint32_t>(joints.size()))];
                if (scene.contains(joint)) {
                    (void)scene.set_motor(joint, any_number(rng), any_number(rng));
                }
            }
            break;
        case 8:
            scene.remove(rng.below(4) == 0 ? id : BodyId(rng.next()));
            scene.wake(other);
            break;
        case 9: {
            physics::RayHit hit;
            (void)scene.ray_cast(any_vector(rng), any_vector(rng), any_number(rng), 0, hit);
            break;
        }
        case 10: {
            const BodyDef asker = any_body(rng);
            physics::QueryHit hit;
            const physics::ShapeAt at{asker.shape, asker.position, asker.orientation};
            (void)scene.query().closest(at, any_number(rng), {}, hit);
            (void)scene.query().overlap_any(at, {});
            (void)scene.query().cast({at, any_vector(rng), any_number(rng)}, {}, hit);
            break;
        }
        default:
            if (!joints.empty()) {
                scene.remove_joint(rng.below(4) == 0 ? joints.back() : JointId(rng.next()));
            }
            break;
    }
}

/// Whatever calls are made, states stay finite and within the promised range of bodies.
void garbage(Run& run) {
    for (std::uint64_t k = 0; k < run.pick(3U, 30U); ++k) {
        World world(run, "garbage", "seed " + std::to_string(run.seed + k));
        core::Rng rng(run.seed + k, 30);
        std::vector<BodyId> bodies;
        std::vector<JointId> joints;
        double worst = 0.0;
        for (int step = 0; step < run.pick(200, 1000); ++step) {
            for (int i = 0; i < 10; ++i) {
                poke(world.scene, rng, bodies, joints);
            }
            std::erase_if(bodies, [&](BodyId id) { return !world.scene.contains(id); });
            while (bodies.size() > 200) {
                world.scene.remove(bodies.back());
                bodies.pop_back();
            }
            world.step();
            for (const BodyId id : bodies) {
                const BodyState s = world.scene.state(id);
                const bool good = is_finite(s) && std::abs(s.orientation.norm() - 1.0F) < 0.02F;
                worst = std::max(worst, good ? static_cast<double>(s.velocity.norm()) : 1.0e30);
            }
        }
        world.limits.quarantined = 1.0e9;  // being stopped is the right answer to such input
        world.row.check("fastest_mps", worst, 1.001e4);
        world.finish();
    }
}

/// Many bodies in one place: time and memory stay bounded (Settings::max_pairs).
void one_place(Run& run) {
    const int count = run.pick(3000, 20'000);
    World world(run, "one-place", std::to_string(count) + " bodies");
    world.ground();
    for (int i = 0; i < count; ++i) {
        world.add(mixed_body(i, Vec3(0.0F, 2.0F, 0.0F)));
    }
    std::uint32_t pairs = 0;
    for (int i = 0; i < run.pick(3, 10); ++i) {
        pairs = std::max(pairs, world.scene.step(kFrame).pairs);
    }
    world.step();
    world.row.check("pairs", pairs, 3.0 * (1U << 18));
    world.limits.quarantined = 0.0;
    world.finish();
}

struct Graph {
    std::string name;
    float heaviest = 10.0F;  ///< kg; masses are from 1 kg to this
    int extra = 0;           ///< joints besides a tree's: each closes a loop
    bool endless = false;    ///< sliders without an end too
};

/// Trees and loops of all kinds of joints. Joints may add the energy that would raise the whole
/// graph by 5 cm.
void joint_graph(Run& run, const Graph& graph, std::uint64_t seed) {
    World world(run, "joint-graph", graph.name + ", seed " + std::to_string(seed));
    world.floor_y = -10.0F;
    core::Rng rng(seed, 31);
    const auto near = [&rng](float size) {
        const float x = rng.range(-size, size);
        const float y = rng.range(-size, size);
        const float z = rng.range(-size, size);
        return Vec3(x, y, z);
    };
    std::vector<BodyId> ids;
    for (int i = 0; i < 12; ++i) {
        BodyDef def = body_of(Shape::box(Vec3::Constant(0.2F) + 0.5F * near(0.3F).cwiseAbs()),
                              std::pow(graph.heaviest, rng.unit()),
                              near(2.0F));
        def.filter.mask = 0;
        ids.push_back(world.add(def));
    }
    const auto join = [&](BodyId a, BodyId b) {
        JointDef def;
        def.kind = static_cast<JointKind>(rng.below(6));
        def.a = a;
        def.b = b;
        const Vec3 at_b = world.scene.state(b).position;
        const Vec3 at_a = a == BodyId() ? Vec3(at_b + near(1.0F)) : world.scene.state(a).position;
        def.anchor = 0.5F * (at_a + at_b) + near(0.2F);
        def.anchor_b = at_b + near(0.2F);
        def.axis = near(1.0F);
        def.limited = rng.below(2) == 0 && def.kind != JointKind::kBall;  // no twist without a cone
        def.limited |= def.kind == JointKind::kSlider && !graph.endless;
        def.lower = rng.range(-0.5F, 0.0F);
        def.upper = rng.range(0.0F, 0.5F);
        def.break_force_n = rng.below(8) == 0 ? 50.0F : def.break_force_n;
        world.join(def);
    };
    join(BodyId(), ids[0]);
    for (std::uint32_t i = 1; i < ids.size(); ++i) {
        join(ids[rng.below(i)], ids[i]);
    }
    for (int k = 0; k < graph.extra; ++k) {
        const std::uint32_t a = rng.below(12);
        join(ids[a], ids[(a + 1 + rng.below(11)) % 12]);
    }
    world.limits.energy_share = 0.005;  // 5 cm of the 10 m
    if (graph.endless) {
        // Twelve bodies, which the engine cuts to its highest speed or stops.
        const auto fastest = static_cast<double>(physics::kMaxSpeed);
        world.row.know(
            "a slider that slid a hundred sizes of its bodies off couples them through arms that "
            "floats do not resolve",
            {{"speed_mps", fastest},
             {"energy_share", 0.5 * fastest * fastest / (kG * 10.0)},
             {"quarantined", 12.0}});
    }
    // Parts that broke off fall freely; hanging ones may whip at 60 m/s.
    const float seconds = run.pick(3.0F, 10.0F);
    world.limits.speed_mps = 60.0 + 9.81 * static_cast<double>(seconds);
    world.run(seconds);
    world.finish();
}

void joint_graphs(Run& run) {
    for (std::uint64_t k = 0; k < run.pick(3U, 10U); ++k) {
        joint_graph(run, {.name = "tree"}, run.seed + k);
        joint_graph(run, {.name = "loops", .extra = 3}, run.seed + k);
        joint_graph(run, {.name = "uneven", .heaviest = 1000.0F}, run.seed + k);
        joint_graph(run, {.name = "endless sliders", .endless = true}, run.seed + k);
    }
}

}  // namespace

std::vector<Case> input_cases() {
    return {{"garbage", "calls with what is not finite, too large, gone or absurd", garbage},
            {"one-place", "thousands of bodies in one place: bounded time and memory", one_place},
            {"joint-graph", "random graphs of all kinds of joints", joint_graphs}};
}

}  // namespace zoned::stability
