// Jointed things in worlds: spawned, driven, broken, and carried across a border between zones.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/scripting/script_rules.h"
#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/machine_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

namespace zoned::app {
namespace {

using scenario::bridge_text;
using scenario::kCartText;
using scenario::kCraneText;
using scenario::kRagdollText;
using scenario::machine_world;

config::Settings settings_of(const std::string& text) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::parse_settings(text, {}, settings, errors))
        << config::format_errors("test", errors);
    return settings;
}

/// The gap of a joint between two entities, or one and the world, from their columns, m.
float gap_of(const zone::ZoneState& state, const zone::EntityJoint& joint) {
    const world::Entities& e = state.entities;
    const physics::JointDef& def = joint.plan->def;
    const physics::Frame b{e.position[e.find(joint.b)], e.orientation[e.find(joint.b)]};
    physics::Frame a;
    physics::Frame a_then;
    physics::Frame b_then = joint.made_at;
    if (joint.a) {
        a = {e.position[e.find(joint.a)], e.orientation[e.find(joint.a)]};
        a_then = joint.made_at;
        b_then = {};
    }
    const Vec3 on_b = b.position + b.rotation * def.anchor;
    const Vec3 then = b_then.position + b_then.rotation * def.anchor;
    const Vec3 on_a =
        a.position + a.rotation * (a_then.rotation.conjugate() * (then - a_then.position));
    Vec3 gap = on_b - on_a;
    if (def.kind == physics::JointKind::kSlider) {
        const Vec3 axis = b.rotation * def.axis;
        gap -= axis * axis.dot(gap);
    }
    return gap.norm();
}

float widest_gap(World& world) {
    float widest = 0.0F;
    for (const auto& zone : world.zones()) {
        for (const zone::EntityJoint& joint : zone->state().assemblies.joints) {
            const bool two_points = joint.plan->def.kind == physics::JointKind::kDistance ||
                                    joint.plan->def.kind == physics::JointKind::kSpring;
            widest = std::max(widest, two_points ? 0.0F : gap_of(zone->state(), joint));
        }
    }
    return widest;
}

/// By type and, within one, by id: positions in world coordinates of all owned entities.
std::map<std::string, std::vector<Vec3d>> places(World& world) {
    std::vector<std::tuple<std::string, EntityId, Vec3d>> all;
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        const world::Entities& e = state.entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (!e.has(row, world::kGhost)) {
                all.emplace_back((*state.settings.types)[e.type[row]].name,
                                 e.id[row],
                                 state.settings.region().origin() + e.position[row].cast<double>());
            }
        }
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
        return std::tie(std::get<0>(a), std::get<1>(a)) < std::tie(std::get<0>(b), std::get<1>(b));
    });
    std::map<std::string, std::vector<Vec3d>> out;
    for (const auto& [type, id, at] : all) {
        out[type].push_back(at);
    }
    return out;
}

void run(World& world, int ticks, const std::function<void()>& each = {}) {
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < ticks; ++t) {
        out.clear();
        world.tick({}, out);
        if (each) {
            each();
        }
    }
}

/// Zone-local coordinates round to 2e-6 m; five seconds of impacts and rolling let that grow.
constexpr double kBorderError_m = 0.01;
/// The gap that a limb on the ground opens when its contacts begin anew in the other zone, m.
constexpr float kBorderGap_m = 0.01F;
constexpr float kClosed_m = 0.005F;

class Joints : public ::testing::Test {
  protected:
    Joints() { plain_log() = std::make_shared<scenario::PlainLog>(); }
};

TEST_F(Joints, OfAnAssemblyHoldItsPartsTogether) {
    World world(settings_of(machine_world(1) + kRagdollText +
                            "entity { type: \"ragdoll\" x_m: 3 z_m: 2 y_m: 3 yaw_deg: 30 }\n"),
                1);
    const zone::ZoneState& state = world.zones()[0]->state();
    EXPECT_EQ(state.entities.size(), 7U);
    EXPECT_EQ(state.assemblies.joints.size(), 6U);
    EXPECT_LT(widest_gap(world), 1e-5F) << "it is put together as written";
    float widest = 0.0F;
    run(world, 300, [&] { widest = std::max(widest, widest_gap(world)); });
    EXPECT_LT(widest, 0.01F) << "in its impacts, two metres down";
    EXPECT_LT(widest_gap(world), kClosed_m);
    EXPECT_LT(state.entities.position[0].y(), 1.0F) << "it fell";
    run(world, 300);
    EXPECT_EQ(state.scene.awake_count(), 0U) << "and sleeps";
}

TEST_F(Joints, AreInTheStateHashAndInReplays) {
    const std::string text = machine_world(2) + kCartText + kRagdollText +
                             "entity { type: \"cart\" x_m: -6 z_m: 2 yaw_deg: 90 }\n"
                             "entity { type: \"ragdoll\" x_m: 1 z_m: -5 y_m: 3 }\n";
    const auto hash_with = [&](unsigned threads) {
        World world(settings_of(text), threads);
        run(world, 200);
        return world.state_hash();
    };
    const std::uint64_t alone = hash_with(1);
    EXPECT_EQ(alone, hash_with(2));
    World other(settings_of(text), 1);
    for (const auto& zone : other.zones()) {
        zone::ZoneContext context(zone->state());
        for (const zone::EntityJoint& joint : zone->state().assemblies.joints) {
            if (joint.motor) {
                EXPECT_TRUE(context.set_motor_target(joint.id, 9.0F)) << "the target that it has";
                break;
            }
        }
    }
    run(other, 200);
    EXPECT_NE(alone, other.state_hash()) << "rules set it: that is another state";
}

/// The crate "a" hangs on the joint "hang"; another one beside it falls.
std::string hanging_and_free_crate() {
    return machine_world(1) +
           "entity { name: \"a\" type: \"crate\" x_m: 0 z_m: 0 y_m: 5 }\n"
           "entity { name: \"b\" type: \"crate\" x_m: 2 z_m: 0 y_m: 5 }\n"
           "joint { name: \"hang\" b: \"a\" fixed { } }\n";
}

TEST_F(Joints, AreMadeReadAndRemovedByRules) {
    World world(settings_of(hanging_and_free_crate()), 1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    const zone::EntityJointId hang = context.joint_named(EntityId(), "hang");
    ASSERT_TRUE(hang);
    const EntityId a = context.joint(hang)->b;
    const EntityId b = state.entities.id[0] == a ? state.entities.id[1] : state.entities.id[0];
    zone::JointPlan rope;
    rope.def.kind = physics::JointKind::kDistance;
    const zone::EntityJointId tied = context.add_joint(a, b, rope);
    ASSERT_TRUE(tied);
    EXPECT_TRUE(context.has_joints(b));
    run(world, 240);
    const auto reading = context.joint(tied);
    ASSERT_TRUE(reading);
    EXPECT_NEAR(reading->position, 2.0F, 0.005F) << "the length of the rope";
    EXPECT_GT(context.joint(hang)->force_n, 30.0F * 9.81F) << "it carries both";
    context.remove_joint(tied);
    EXPECT_FALSE(context.joint(tied));
    EXPECT_FALSE(context.has_joints(b));
    run(world, 240);
    EXPECT_NEAR(state.entities.position[state.entities.find(b)].y(), 0.3F, 0.01F) << "it fell";
    EXPECT_NEAR(state.entities.position[state.entities.find(a)].y(), 5.0F, 0.005F);
    EXPECT_FALSE(context.add_joint(a, a, rope));
    EXPECT_FALSE(context.add_joint(a, EntityId(999), rope));
}

TEST_F(Joints, AreMadeByAScript) {
    World world(settings_of(hanging_and_free_crate()), 1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    const EntityId a = context.joint(context.joint_named(EntityId(), "hang"))->b;
    scripting::ScriptSettings settings;
    settings.source = R"(function on_tick()
        local _, _, _, a = joint(joint_named(nil, 'hang'))
        local x, y, z = position(a)
        local b
        for _, id in ipairs(near(x, y, z, 10, 'crate')) do if id ~= a then b = id end end
        add_joint(a, b, 'distance', { name = 'rope', anchor = { 0, -0.25, 0 } })
        print(add_joint(a, a, 'fixed'))
    end)";
    std::string log;
    scripting::ScriptRules rules(
        settings,
        {},
        *state.settings.types,
        [&log](scripting::ScriptLine, const std::string& line) { log += line; });
    run(world, 1);
    rules.on_tick(context);
    EXPECT_EQ(log, "nil") << "a body is not joined to itself";
    ASSERT_EQ(state.assemblies.joints.size(), 2u);
    const zone::EntityJointId rope = state.assemblies.joints.back().id;
    ASSERT_EQ(context.joint(rope)->a, a);
    run(world, 240);
    EXPECT_NEAR(context.joint(rope)->position, std::hypot(2.0F, 0.25F), 0.005F);
    EXPECT_GT(context.joint(context.joint_named(EntityId(), "hang"))->force_n, 30.0F * 9.81F);
}

TEST_F(Joints, ThatPullTooHardBreakAndRulesHearOfIt) {
    plain_log()->busy = true;
    World world(settings_of(machine_world(1) +
                            "entity { name: \"a\" type: \"crate\" x_m: 0 z_m: 0 y_m: 5 }\n"
                            "joint { name: \"thread\" b: \"a\" fixed { } break_force_n: 300 }\n"),
                1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    run(world, 60);
    EXPECT_TRUE(plain_log()->broken.empty()) << "20 kg are 196 N";
    const EntityId crate = state.entities.id[0];
    plain_log()->each_tick = [crate](zone::RulesContext& rules) {
        rules.apply_force(crate, Vec3(0.0F, -250.0F, 0.0F), rules.entities().position[0]);
    };
    run(world, 30);
    ASSERT_EQ(plain_log()->broken.size(), 1U);
    EXPECT_EQ(plain_log()->broken[0].name, "thread");
    EXPECT_EQ(plain_log()->broken[0].b, crate);
    EXPECT_GT(plain_log()->broken[0].force_n, 300.0F);
    EXPECT_TRUE(state.assemblies.joints.empty());
    EXPECT_FALSE(context.joint_named(EntityId(), "thread"));
    run(world, 120);
    EXPECT_LT(state.entities.position[0].y(), 0.5F);
}

TEST_F(Joints, OfACraneFollowTime) {
    World world(
        settings_of(machine_world(1) + kCraneText + "entity { type: \"crane\" x_m: 0 z_m: 0 }\n"),
        1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    const EntityId root = state.entities.id[0];
    const zone::EntityJointId swing = context.joint_named(root, "swing");
    const zone::EntityJointId cable = context.joint_named(root, "cable");
    ASSERT_TRUE(swing && cable);
    constexpr float kRadian = std::numbers::pi_v<float> / 180.0F;
    run(world, 50);
    EXPECT_NEAR(context.joint(swing)->position, 0.0F, 0.002F);
    run(world, 130);  // at 3 s: half of the way; it lags four ticks behind
    EXPECT_NEAR(context.joint(swing)->position, 30.0F * kRadian, 0.03F);
    run(world, 360);
    EXPECT_NEAR(context.joint(swing)->position, 60.0F * kRadian, 0.002F);
    EXPECT_NEAR(context.joint(cable)->position, 2.7F, 0.005F);
    EXPECT_EQ(world.zones()[0]->report().census.moving_motors, 0U) << "it has arrived";
    EXPECT_TRUE(context.set_motor_target(swing, 0.0F));
    run(world, 600);
    EXPECT_NEAR(context.joint(swing)->position, 0.0F, 0.002F);
}

/// Kills that clients confirm make ragdolls whenever the message comes.
TEST_F(Joints, OfWhatIsSpawnedIntoAFrozenWorldRestUntilItGoesOn) {
    World world(settings_of(machine_world(1) + kRagdollText), 1);
    zone::ZoneState& state = world.zones()[0]->state();
    std::vector<mailbox::OutboxItem> out;
    const mailbox::InboxItem freeze = mailbox::Freeze{true};
    world.tick({&freeze, 1}, out);
    zone::ZoneContext context(state);
    zone::SpawnDef def;
    def.type = context.type_named("ragdoll");
    def.position = Vec3(0.0F, 3.0F, 0.0F);
    def.velocity = Vec3(5.0F, 0.0F, 0.0F);
    context.spawn(def);
    world.tick({&freeze, 1}, out);
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        EXPECT_TRUE(state.entities.has(row, world::kAtRest));
        EXPECT_EQ(state.entities.velocity[row], Vec3(Vec3::Zero()));
    }
    const mailbox::InboxItem go_on = mailbox::Freeze{false};
    world.tick({&go_on, 1}, out);
    EXPECT_NEAR(state.entities.velocity[0].x(), 5.0F, 0.1F);
}

TEST_F(Joints, GoWithTheirAssembly) {
    World world(settings_of(machine_world(1) + kCartText), 1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    zone::SpawnDef def;
    def.type = context.type_named("cart");
    def.position = Vec3(0.0F, 0.62F, 0.0F);
    const EntityId root = context.spawn(def);
    std::vector<EntityId> parts;
    context.parts_of(root, parts);
    ASSERT_EQ(parts.size(), 5U);
    EXPECT_EQ(parts.front(), root);
    EXPECT_EQ(context.assembly_root(parts[3]), root);
    EXPECT_EQ(context.seats_of(root), 2U);
    run(world, 30);
    const float before = state.entities.position[state.entities.find(parts[2])].z();
    context.teleport(root, Vec3(10.0F, 0.7F, 10.0F));
    EXPECT_GT(state.entities.position[state.entities.find(parts[2])].z(), before + 8.0F)
        << "all of it comes along";
    EXPECT_LT(widest_gap(world), 0.005F);
    context.hide(parts[1]);
    EXPECT_EQ(state.assemblies.joints.size(), 3U);
    run(world, 10);
    context.despawn(root);
    EXPECT_EQ(state.entities.size(), 0U);
    EXPECT_TRUE(state.assemblies.joints.empty());
    EXPECT_TRUE(state.assemblies.motors.empty());
    run(world, 2);
}

/// One of two worlds, that has one zone, against that with a border at x = 0.
struct Compared {
    World one;
    World two;

    explicit Compared(const std::string& things, int zones_of_two = 2)
        : one(settings_of(machine_world(1) + things), 1),
          two(settings_of(machine_world(zones_of_two) + things), 1) {}

    /// The largest distance between the same entities of both.
    double apart() {
        double most = 0.0;
        const auto a = places(one);
        const auto b = places(two);
        EXPECT_EQ(a.size(), b.size());
        for (const auto& [type, at] : a) {
            const auto other = b.find(type);
            if (other == b.end() || other->second.size() != at.size()) {
                ADD_FAILURE() << type << " is missing";
                continue;
            }
            for (std::size_t i = 0; i < at.size(); ++i) {
                most = std::max(most, (at[i] - other->second[i]).norm());
            }
        }
        return most;
    }
};

/// The driver pushes its stick along +x in the coming tick, whichever zone it is in.
void push_stick(World& world, EntityId driver) {
    for (const auto& zone : world.zones()) {
        world::Entities& e = zone->state().entities;
        const world::Row row = e.find(driver);
        if (row != world::kNoRow) {
            e.command[row].move_x = 127;
        }
    }
}

TEST_F(Joints, OfACartCrossABorderWithIt) {
    Compared worlds(kCartText + "entity { type: \"cart\" x_m: -5 z_m: 2 yaw_deg: 90 }\n");
    EntityId driver;
    for (World* world : {&worlds.one, &worlds.two}) {
        zone::ZoneState& state = world->zones()[0]->state();
        zone::ZoneContext context(state);
        const EntityId root = state.entities.id[0];
        for (std::size_t seat = 0; seat < 2; ++seat) {
            zone::SpawnDef def;
            def.type = context.type_named("player");
            def.position = state.entities.position[0] + Vec3(0.0F, 3.0F, 0.0F);
            const EntityId rider = context.spawn(def);
            ASSERT_TRUE(context.mount(rider, root, seat));
            driver = seat == 0 ? rider : driver;
        }
        if (world == &worlds.one) {
            run(worlds.one, 300, [&] { push_stick(worlds.one, driver); });
        }
    }
    float widest = 0.0F;
    run(worlds.two, 300, [&] {
        push_stick(worlds.two, driver);
        widest = std::max(widest, widest_gap(worlds.two));
    });
    EXPECT_EQ(worlds.two.zones()[0]->state().assemblies.joints.size(), 0U);
    EXPECT_EQ(worlds.two.zones()[1]->state().assemblies.joints.size(), 4U) << "it went over";
    EXPECT_EQ(worlds.two.zones()[1]->state().assemblies.riders.size(), 2U);
    EXPECT_GT(places(worlds.two)["cart"][0].x(), 2.0);
    EXPECT_LT(worlds.apart(), kBorderError_m);
    EXPECT_LT(widest, kClosed_m);
}

/// A ragdoll that is thrown along +x.
struct Throw {
    Vec3 position, velocity, spin;
    float pitch_rad = 0.0F;

    void into(World& world) const {
        zone::ZoneContext context(world.zones()[0]->state());
        zone::SpawnDef def;
        def.type = context.type_named("ragdoll");
        def.position = position;
        def.orientation = Quat(Eigen::AngleAxisf(pitch_rad, Vec3::UnitX()));
        def.velocity = velocity;
        def.angular_velocity = spin;
        context.spawn(def);
    }

    /// How far apart it and one that is pushed by 1 cm/s more end, m: the most of six pushes.
    [[nodiscard]] double sensitivity() const {
        constexpr float kPush_mps = 0.01F;
        double most = 0.0;
        for (int side = 0; side < 6; ++side) {
            Compared worlds(kRagdollText, 1);
            Throw pushed = *this;
            pushed.velocity[side / 2] += side % 2 == 0 ? kPush_mps : -kPush_mps;
            into(worlds.one);
            pushed.into(worlds.two);
            run(worlds.one, 300);
            run(worlds.two, 300);
            most = std::max(most, worlds.apart());
        }
        return most;
    }
};

/// Limbs that hit each other make ten times as much of any difference, so that the place where a
/// ragdoll comes to rest is a matter of chance. The border's part in it is small: contacts begin
/// anew, which is less than a push of 1 cm/s.
TEST_F(Joints, OfARagdollCrossABorderWithIt) {
    const Throw throws[] = {
        {{28.6F, 0.61F, 2.0F}, {4.0F, 1.6F, 0.0F}, Vec3::Zero(), -0.86F},
        {{28.6F, 0.5F, 2.0F}, {4.0F, 2.7F, 0.5F}, {0.5F, 1.0F, -2.0F}, -1.2F},
        {{27.8F, 0.66F, 2.0F}, {6.0F, 2.8F, 0.0F}, Vec3::Zero(), -1.0F},
        {{28.2F, 0.14F, 2.0F}, {7.5F, 0.0F, 0.0F}, Vec3::Zero(), -1.57F},
    };
    for (const Throw& thrown : throws) {
        Compared worlds(kRagdollText);
        thrown.into(worlds.one);
        thrown.into(worlds.two);
        float widest = 0.0F;
        for (int t = 0; t < 300; ++t) {
            run(worlds.one, 1);
            run(worlds.two, 1);
            widest = std::max(widest, widest_gap(worlds.two));
        }
        EXPECT_EQ(worlds.two.zones()[1]->state().assemblies.joints.size(), 6U) << "it went over";
        EXPECT_LT(worlds.apart(), std::max(kBorderError_m, thrown.sensitivity()));
        EXPECT_LT(widest, kBorderGap_m);
        EXPECT_EQ(worlds.two.zones()[1]->state().scene.awake_count(), 0U);
    }
}

TEST_F(Joints, OfABridgeAcrossABorderCarryWhatFallsOnIt) {
    Compared worlds(bridge_text(12) +
                    "entity { type: \"bridge\" x_m: -2.6 z_m: 2 y_m: 4 }\n"
                    "entity { type: \"crate\" x_m: 1.2 z_m: 2.1 y_m: 4.8 }\n");
    float widest = 0.0F;
    for (int t = 0; t < 300; ++t) {
        run(worlds.one, 1);
        run(worlds.two, 1);
        widest = std::max(widest, widest_gap(worlds.two));
    }
    EXPECT_GT(places(worlds.two)["crate"][0].y(), 1.0) << "it lies on the bridge";
    EXPECT_EQ(worlds.two.zones()[0]->state().assemblies.joints.size() +
                  worlds.two.zones()[1]->state().assemblies.joints.size(),
              13U);
    EXPECT_TRUE(worlds.two.zones()[0]->state().assemblies.joints.empty() ||
                worlds.two.zones()[1]->state().assemblies.joints.empty())
        << "one zone owns all of it";
    EXPECT_LT(worlds.apart(), kBorderError_m);
    EXPECT_LT(widest, kClosed_m);
}

TEST_F(Joints, LetADriverSteerWithItsStick) {
    World world(settings_of(machine_world(1) + kCartText +
                            "entity { type: \"cart\" x_m: -5 z_m: 2 yaw_deg: 90 }\n"),
                1);
    zone::ZoneState& state = world.zones()[0]->state();
    zone::ZoneContext context(state);
    const EntityId root = state.entities.id[0];
    zone::SpawnDef def;
    def.type = context.type_named("player");
    def.position = Vec3(-5.0F, 3.0F, 2.0F);
    const EntityId rider = context.spawn(def);
    ASSERT_TRUE(context.mount(rider, root, 0));
    EXPECT_FALSE(context.mount(rider, root, 1)) << "it rides already";
    const auto rides_at = [&] {
        const world::Row seat = state.entities.find(root);
        const Vec3 place = state.entities.position[seat] +
                           state.entities.orientation[seat] * Vec3(0.0F, 1.1F, 0.0F);
        return (state.entities.position[state.entities.find(rider)] - place).norm();
    };
    run(world, 60);
    EXPECT_LT(rides_at(), 1e-4F);
    EXPECT_NEAR(state.entities.velocity[state.entities.find(root)].x(), 0.0F, 0.05F)
        << "nobody touches the stick";
    state.entities.command[state.entities.find(rider)].move_x = 127;
    run(world, 180, [&] {
        state.entities.command[state.entities.find(rider)].move_x = 127;
        ASSERT_LT(rides_at(), 1e-4F);
    });
    EXPECT_GT(state.entities.velocity[state.entities.find(root)].x(), 2.0F);
    EXPECT_LT(widest_gap(world), 0.005F);
    context.dismount(rider, Vec3(20.0F, 0.95F, -10.0F));
    EXPECT_FALSE(context.carrier_of(rider));
    run(world, 240);
    EXPECT_NEAR(state.entities.velocity[state.entities.find(root)].x(), 0.0F, 0.1F)
        << "without a driver it brakes";
}

}  // namespace
}  // namespace zoned::app
