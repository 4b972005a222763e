// Soft bodies against rigid ones and themselves.
#include "tests/unit/soft/soft_test.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics::soft {
namespace {

BodyId add_ball(Scene& scene,
                float radius,
                float mass,
                const Vec3& x,
                const Vec3& v = Vec3::Zero()) {
    BodyDef ball;
    ball.shape = Shape::sphere(radius);
    ball.mass = mass;
    ball.position = x;
    ball.velocity = v;
    const auto id = scene.add(ball);
    EXPECT_TRUE(id.ok());
    return *id;
}

void add_ground(Scene& scene, float y) {
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::plane();
    ground.position = Vec3(0, y, 0);
    ASSERT_TRUE(scene.add(ground).ok());
}

TEST(SoftContact, APinnedClothHoldsABall) {
    for (const float k : {1.0e3F, 1.0e5F}) {
        SoftDef def = cloth(21, k);
        for (SoftNode& n : def.nodes) {
            n.pinned = n.position.x() < 0.01F || n.position.x() > 1.99F || n.position.z() < 0.01F ||
                       n.position.z() > 1.99F;
        }
        def.material.drag = 1.0F;
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, def);
        Scene scene{PhysicsSettings()};
        const BodyId ball = add_ball(scene, 0.25F, 1.0F, Vec3(1, 1, 1));
        run(bodies, 600, &scene);
        const BodyState s = scene.state(ball);
        EXPECT_GT(s.position.y(), -0.6F) << k;
        EXPECT_LT(s.position.y(), 0.35F) << k;
        // The ball's own step gives it g dt, which the cloth takes back in its next one.
        EXPECT_LT(s.velocity.norm(), kGravity * kFrame) << k;
        EXPECT_GT(bodies.stats().contacts, 0U);
        (void)id;
    }
}

TEST(SoftContact, AJellyHitByABallKeepsTheSumOfMomentum) {
    SoftDef def = jelly();
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, def);
    PhysicsSettings settings;
    settings.gravity.setZero();
    Scene scene(settings);
    // The shape of the ball enters by its inertia: 2/5 m r^2.
    const float radius = 0.3F;
    const BodyId ball = add_ball(scene, radius, 2.0F, Vec3(-2, 2.1F, 0.1F), Vec3(5, 0, 0));
    const auto sum = [&] {
        Momenta m = momenta(bodies, id);
        const BodyState s = scene.state(ball);
        const Vec3d p = 2.0 * s.velocity.cast<double>();
        m.linear += p;
        m.angular += s.position.cast<double>().cross(p) + 0.4 * 2.0 *
                                                              static_cast<double>(radius * radius) *
                                                              s.angular_velocity.cast<double>();
        m.size += p.norm();
        return m;
    };
    const Momenta before = sum();
    run(bodies, 90, &scene);
    const Momenta after = sum();
    EXPECT_LT(scene.state(ball).velocity.x(), 4.0F);  // it did hit
    EXPECT_LT((after.linear - before.linear).norm(), 1e-5 * before.size * 10.0);
    // The ball moves after the cloth did, so that its arm is that of a step before. The impulse of
    // some 8 N s acts over a few steps of up to 8 cm.
    EXPECT_LT((after.angular - before.angular).norm(), 0.05 * before.size);
}

TEST(SoftContact, FastNodesDoNotTunnel) {
    SoftDef def = jelly();
    for (SoftNode& n : def.nodes) {
        n.velocity = Vec3(0, -50, 0);
    }
    SoftBodies bodies(awake_soft());
    const SoftId id = put(bodies, def);
    Scene scene{PhysicsSettings()};
    BodyDef slab;
    slab.kind = BodyKind::kStatic;
    slab.shape = Shape::box(Vec3(5, 0.02F, 5));
    ASSERT_TRUE(scene.add(slab).ok());
    run(bodies, 60, &scene);
    for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
        EXPECT_GT(bodies.position(id, i).y(), 0.0F) << i;
    }
}

/// Whatever the method and its default substeps, a fall from 2 m gives no more than m g 2 m, and
/// nothing comes up again higher than it fell from.
TEST(SoftContact, AFallOntoTheGroundGivesNoEnergy) {
    for (const SoftMethod method :
         {SoftMethod::kXpbd, SoftMethod::kImplicitEuler, SoftMethod::kSemiImplicitEuler}) {
        for (const auto& [stiffness, bulk_modulus] :
             {std::pair(3.0e2F, 0.0F), std::pair(3.0e4F, 0.0F), std::pair(3.0e4F, 1.0e5F)}) {
            JellyDef of;
            of.centre = Vec3(0, 2, 0);
            of.nodes = {7, 7, 7};
            of.mass = 5.0F;
            of.stiffness = stiffness;
            of.bulk_modulus = bulk_modulus;
            SoftDef def = *build_jelly(of);
            def.solver.method = method;
            SoftSettings settings = awake_soft();
            settings.step_s = kFrame;
            SoftBodies bodies(settings);
            const SoftId id = put(bodies, def);
            Scene scene{PhysicsSettings()};
            add_ground(scene, 0.0F);
            const double given = double{of.mass} * double{kGravity} * 2.0;
            double most = 0.0;
            float highest = 0.0F;
            for (int step = 0; step < 120; ++step) {
                run(bodies, 1, &scene);
                double kinetic = 0.0;
                Vec3 centre = Vec3::Zero();
                for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
                    const auto m = static_cast<double>(bodies.mass(id, i));
                    kinetic += 0.5 * m * bodies.velocity(id, i).cast<double>().squaredNorm();
                    centre += bodies.mass(id, i) / of.mass * bodies.position(id, i);
                }
                most = std::max(most, kinetic);
                highest = step < 60 ? highest : std::max(highest, centre.y());
            }
            EXPECT_LE(most, given) << name_of(method) << ' ' << stiffness;
            EXPECT_LE(highest, 2.0F) << name_of(method) << ' ' << stiffness;
        }
    }
}

TEST(SoftContact, FrictionHoldsOnASlopeThatItMayHold) {
    for (const float friction : {0.8F, 0.1F}) {
        SoftDef def = *build_jelly({.centre = Vec3(0, 0.7F, 0), .mass = 5.0F, .stiffness = 5e3F});
        def.material.friction = friction;
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, def);
        Scene scene{PhysicsSettings()};
        BodyDef slope;
        slope.kind = BodyKind::kStatic;
        slope.shape = Shape::box(Vec3(10, 0.1F, 10));
        slope.orientation = Quat(Eigen::AngleAxisf(0.3F, Vec3::UnitZ()));  // tan 0.3 = 0.31
        ASSERT_TRUE(scene.add(slope).ok());
        run(bodies, 60, &scene);
        const Vec3 from = bodies.rigid_hull(id).position;
        run(bodies, 60, &scene);
        const float way = (bodies.rigid_hull(id).position - from).norm();
        EXPECT_EQ(way > 0.3F, friction < 0.31F) << way;
    }
}

TEST(SoftContact, AKinematicBodyCarriesACloth) {
    SoftDef def = cloth(8);
    for (SoftNode& n : def.nodes) {
        n.pinned = false;
        n.position += Vec3(-1, 0.15F, -1);
    }
    SoftBodies bodies(awake_soft());
    const SoftId id = put(bodies, def);
    Scene scene{PhysicsSettings()};
    BodyDef lift;
    lift.kind = BodyKind::kKinematic;
    lift.shape = Shape::box(Vec3(2, 0.1F, 2));
    lift.velocity = Vec3(0, 0.5F, 0);
    const auto body = scene.add(lift);
    ASSERT_TRUE(body.ok());
    run(bodies, 120, &scene);
    for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
        EXPECT_NEAR(bodies.position(id, i).y(), scene.state(*body).position.y() + 0.11F, 0.02F);
    }
}

TEST(SoftSleep, EndsWhenABallComes) {
    SoftDef def = cloth(10);
    for (SoftNode& n : def.nodes) {
        n.pinned = false;
    }
    def.material.drag = 2.0F;
    SoftBodies bodies;
    const SoftId id = put(bodies, def);
    Scene scene{PhysicsSettings()};
    add_ground(scene, -0.1F);
    run(bodies, 400, &scene);
    ASSERT_TRUE(bodies.asleep(id));
    add_ball(scene, 0.2F, 1.0F, Vec3(1, 1, 1));
    bool woke = false;
    for (int i = 0; i < 60; ++i) {
        run(bodies, 1, &scene);
        woke = woke || !bodies.asleep(id);
    }
    EXPECT_TRUE(woke);
}

TEST(SelfCollision, KeepsNodesApartWhereItIsOn) {
    for (const bool on : {false, true}) {
        // Two strips that are not linked, one falls on the other.
        ClothDef strip;
        strip.nx = strip.nz = 4;
        strip.size_x = strip.size_z = 0.3F;
        strip.pins = {{0, 0}, {3, 0}, {0, 3}, {3, 3}};
        SoftDef def = *build_cloth(strip);
        strip.origin = Vec3(0.001F, 0.2F, 0);
        strip.pins.clear();
        const SoftDef upper = *build_cloth(strip);
        for (SoftSpring s : upper.springs) {
            s.a += 16;
            s.b += 16;
            def.springs.push_back(s);
        }
        def.nodes.insert(def.nodes.end(), upper.nodes.begin(), upper.nodes.end());
        def.material.thickness = 0.02F;
        def.material.drag = 2.0F;
        def.material.self_collision = on;
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, def);
        float nearest = INFINITY;
        for (int i = 0; i < 30; ++i) {
            bodies.step(kFrame, nullptr);
            for (std::size_t a = 0; a < 16; ++a) {
                for (std::size_t b = 16; b < 32; ++b) {
                    nearest =
                        std::min(nearest, (bodies.position(id, a) - bodies.position(id, b)).norm());
                }
            }
        }
        EXPECT_EQ(nearest > 0.03F, on) << nearest;
    }
}

}  // namespace
}  // namespace zoned::physics::soft
