#include "server/ai/steering/policy_steering.h"

#include "tests/unit/ai/field.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::ai::test {
namespace {

/// A policy that always answers (along, across, sprint).
learning::Policy constant_policy(float along, float across, float sprint) {
    learning::Policy policy;
    policy.name = "constant";
    policy.inputs = {{learning::Ego::kTargetDistance, "", 1.0F, 0.0F}};
    policy.network =
        learning::dense(std::array<std::size_t, 2>{1, 3}, learning::Activation::kLinear);
    policy.network.parameters[0] = along;
    policy.network.parameters[2] = across;
    policy.network.parameters[4] = sprint;
    return policy;
}

Brain by_policy(const learning::Policy& policy, const learning::Guard& guard) {
    Brain brain = single(ActionKind::kIdle);
    PolicyChoice choice;
    choice.policy = std::make_shared<const GuardedPolicy>(GuardedPolicy{policy, guard});
    choice.variable.assign(policy.inputs.size(), 0);
    brain.states[0].choice = choice;
    brain.decide_every_s = kDt;
    return brain;
}

TEST(PolicySteering, WalksWhereItsNetworkSaysInTheFrameOfItsPrey) {
    // Twice along for once across, half of full speed: the player stands at +x, so across is -z.
    const float share = 0.5F / std::sqrt(5.0F);
    for (const float sign : {1.0F, -1.0F}) {
        Field field;
        field.settings.brains = {by_policy(constant_policy(2.0F * share * sign, share, -1.0F),
                                           {1.0F, 1000.0F, 0.0F, false})};
        field.add_player(1, {30.0F, 0.0F, 0.0F});
        field.add_npc(2, kGuard, 0, Vec3::Zero());
        field.step();
        EXPECT_NEAR(field.command(2).move_x, 2.0F * share * sign * 127.0F, 1.0F);
        EXPECT_NEAR(field.command(2).move_z, -share * 127.0F, 1.0F);
        EXPECT_EQ(field.command(2).buttons, 0);
    }
}

TEST(PolicySteering, StaysInsideItsGuardWhateverTheWeights) {
    core::Rng rng(11);
    for (int trial = 0; trial < 20; ++trial) {
        learning::Policy policy = constant_policy(0.0F, 0.0F, 0.0F);
        policy.inputs = {{learning::Ego::kTargetDistance, "", 0.1F, -1.0F},
                         {learning::Ego::kHomeAcross, "", 0.1F, 0.0F}};
        policy.network =
            learning::dense(std::array<std::size_t, 3>{2, 6, 3}, learning::Activation::kLinear);
        for (float& parameter : policy.network.parameters) {
            parameter = rng.range(-4.0F, 4.0F);
        }
        const learning::Guard guard{0.7F, 3.0F, 12.0F, trial % 2 == 0};
        Field field;
        field.settings.brains = {by_policy(policy, guard)};
        field.add_player(1, {9.0F, 0.0F, 4.0F});
        field.add_npc(2, kGuard, 0, Vec3::Zero());
        for (int tick = 0; tick < 3000; ++tick) {
            if (tick % 200 == 0) {
                // Near, far (it then steers every fourth tick), and out of sight.
                const float reach = tick % 600 == 0 ? 300.0F : 25.0F;
                field.position(1) = {rng.range(-reach, reach), 0.0F, rng.range(-reach, reach)};
            }
            const std::uint16_t yaw = field.command(2).yaw;
            field.step();
            const motion::InputCommand& c = field.command(2);
            const float moves =
                std::hypot(static_cast<float>(c.move_x), static_cast<float>(c.move_z));
            EXPECT_LE(moves, 0.7F * 127.0F + 1e-3F);
            const int turned = std::abs(static_cast<std::int16_t>(c.yaw - yaw));
            EXPECT_LE(static_cast<float>(turned), 3.0F * kDt * 65536.0F / 6.2831853F);
            EXPECT_LE(field.position(2).norm(), 12.0F);
            EXPECT_TRUE(trial % 2 == 0 || c.buttons == 0);
        }
    }
}

TEST(PolicySteering, RepeatsACommandThatIsStillGood) {
    Field field;
    field.settings.brains = {
        by_policy(constant_policy(1.0F, 0.0F, -1.0F), {1.0F, 6.0F, 0.0F, false})};
    field.add_player(1, {20.0F, 0.0F, 30.0F});
    field.add_npc(2, kGuard, 0, Vec3::Zero());
    field.run(3.0F);
    int changes = 0;
    for (int tick = 0; tick < 90; ++tick) {
        const motion::InputCommand before = field.command(2);
        field.step();
        const motion::InputCommand& now = field.command(2);
        changes += before.move_x != now.move_x || before.move_z != now.move_z ? 1 : 0;
    }
    EXPECT_LE(changes, 1);
}

TEST(PolicySteering, SlowsDownWhoeverComesFasterOutOfAnotherState) {
    // A hundredth below full speed is less than rounding may hide.
    const learning::Guard guard{0.99F, 6.0F, 0.0F, false};
    Brain brain = by_policy(constant_policy(1.0F, 0.0F, -1.0F), guard);
    BrainState chase;
    chase.action = ActionKind::kChase;
    chase.transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 1.0F, 0.0F}};
    brain.states.insert(brain.states.begin(), chase);
    Field field;
    field.settings.brains = {brain};
    field.add_player(1, {30.0F, 0.0F, 0.0F});
    field.add_npc(2, kGuard, 0, Vec3::Zero());
    field.run(0.8F);
    EXPECT_EQ(field.command(2).move_x, 127);
    field.run(0.5F);
    EXPECT_EQ(field.state(2), 1);
    EXPECT_LE(field.command(2).move_x, 0.99F * 127.0F);
    EXPECT_GE(field.command(2).move_x, 0.95F * 127.0F);
}

TEST(PolicySteering, ReadsVariablesOfTheAgent) {
    learning::Policy policy = constant_policy(0.0F, 0.0F, -1.0F);
    policy.inputs[0].variable = "courage";
    policy.network.parameters[1] = 1.0F;  // along = courage
    Brain brain = by_policy(policy, {1.0F, 1000.0F, 0.0F, false});
    brain.variables = {{"hunger", 0.0F, 0.0F, 0.0F, 1.0F}, {"courage", 0.25F, 0.0F, -1.0F, 1.0F}};
    std::get<PolicyChoice>(brain.states[0].choice).variable = {1};
    Field field;
    field.settings.brains = {brain};
    field.add_player(1, {30.0F, 0.0F, 0.0F});
    field.add_npc(2, kGuard, 0, Vec3::Zero());
    compile(field.settings, kDt);
    Agent agent = field.agents.take(EntityId(2));
    begin(agent, field.settings.compiled[0], 0);
    field.agents.add(agent);
    field.step();
    EXPECT_NEAR(field.command(2).move_x, 0.25F * 127.0F, 1.0F);
}

TEST(PolicySteering, AllocatesNothing) {
    Field field;
    field.settings.brains = {
        by_policy(constant_policy(1.0F, 0.3F, 1.0F), {1.0F, 6.0F, 20.0F, true})};
    field.add_player(1, {30.0F, 0.0F, 40.0F});
    for (std::uint32_t id = 2; id < 20; ++id) {
        field.add_npc(id, kGuard, 0, Vec3(static_cast<float>(id), 0.0F, 0.0F));
    }
    field.run(1.0F);
    const std::uint64_t allocated = allocation_count();
    field.run(1.0F);
    EXPECT_EQ(allocation_count(), allocated);
}

/// Distance after a minute behind a player that walks away at `speed`.
float gap_behind(const Brain& brain, float speed) {
    Field field;
    field.settings.brains = {brain};
    field.add_player(1, {10.0F, 0.0F, 0.0F});
    field.add_npc(2, kGuard, 0, Vec3::Zero());
    for (int tick = 0; tick < 60 * 30; ++tick) {
        field.position(1).x() += speed * kDt;
        field.step();
    }
    return field.distance(1, 2);
}

TEST(RubberBand, KeepsAChaseCloseWithinItsCap) {
    // A guard that runs at 0.8 of 4 m/s: 3.2 m/s, with the band between 2.56 and 3.84.
    Brain plain = single(ActionKind::kChase);
    plain.perception_m = 500.0F;
    plain.states[0].speed_factor = 0.8F;
    Brain banded = plain;
    banded.states[0].rubber_band = learning::RubberBand{10.0F, 0.5F, 0.8F, 1.2F, 0.2F};
    // From a player at 3.6 m/s the plain one falls back by 0.4 m/s.
    EXPECT_NEAR(gap_behind(plain, 3.6F), 10.0F + 60.0F * 0.4F, 1.5F);
    // In balance the factor is 3.6 / 3.2, at a gap of 10 (1 + 0.125 / 0.5). Others receive speeds
    // in steps of a twentieth of 4 m/s, which is 0.0625 of the factor and 1.25 m.
    EXPECT_NEAR(gap_behind(banded, 3.6F), 12.5F, 1.5F);
    // Slower players are not caught at once.
    EXPECT_LT(gap_behind(plain, 2.8F), 2.0F);
    EXPECT_NEAR(gap_behind(banded, 2.8F), 10.0F * (1.0F - 0.125F / 0.5F), 1.5F);
    // Beyond the cap it falls back: 4.2 m/s are more than 3.84.
    EXPECT_GT(gap_behind(banded, 4.2F), 25.0F);
}

TEST(RubberBand, LetsWhoeverFleesBeFollowed) {
    // A hare of 0.8 of 4 m/s before a player of 2.8 m/s: with the band it waits for the player.
    Brain brain = single(ActionKind::kFlee);
    brain.perception_m = 500.0F;
    brain.states[0].speed_factor = 0.8F;
    const auto lead = [](const Brain& hare) {
        Field field;
        field.settings.brains = {hare};
        field.add_player(1, Vec3::Zero());
        field.add_npc(2, kGuard, 0, Vec3(10.0F, 0.0F, 0.0F));
        for (int tick = 0; tick < 60 * 30; ++tick) {
            field.position(1).x() += 2.8F * kDt;
            field.step();
        }
        return field.distance(1, 2);
    };
    EXPECT_NEAR(lead(brain), 10.0F + 60.0F * 0.4F, 1.0F);
    brain.states[0].rubber_band = learning::RubberBand{10.0F, 0.5F, 0.8F, 1.2F, 0.2F};
    // The factor is 2.8 / 3.2 where the lead is 10 (1 + 0.125 / 0.5), within a step of speed.
    EXPECT_NEAR(lead(brain), 12.5F, 1.5F);
}

TEST(RubberBand, EndsWithItsState) {
    Brain brain = single(ActionKind::kChase);
    brain.states[0].speed_factor = 0.8F;
    brain.states[0].rubber_band = learning::RubberBand{};
    brain.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 5.0F, 0.0F}};
    brain.states.push_back(BrainState{});
    Field field;
    field.settings.brains = {brain};
    field.add_player(1, {30.0F, 0.0F, 0.0F});
    field.add_npc(2, kGuard, 0, Vec3::Zero());
    field.run(4.0F);
    EXPECT_GT(field.agents.find(EntityId(2))->band, 1.0F);
    field.run(3.0F);
    EXPECT_EQ(field.agents.find(EntityId(2))->band, 1.0F);
}

}  // namespace
}  // namespace zoned::ai::test
