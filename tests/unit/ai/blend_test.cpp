// Blends: degrees, directions and speeds of states that are active together, worked out by hand.
#include "server/ai/agent/hot_reload_migration.h"
#include "server/ai/explain.h"
#include "server/ai/steering/path_following.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace zoned::ai::test {
namespace {

/// Walks home at half its speed. Runs away the faster, the nearer a player is: not at all from 15 m
/// on, at full degree within 5 m.
Brain shy(float response_s) {
    Brain brain;
    brain.name = "shy";
    BrainState state;
    state.name = "live";
    BlendChoice blend;
    blend.def.name = "shyness";
    blend.def.inputs = {{"player", 0.0F, 40.0F, {}}};
    fuzzy::Term near;
    near.name = "near";
    near.b = near.c = 5.0F;
    near.d = 15.0F;
    blend.def.inputs[0].terms = {near};
    blend.def.states = {{"home", {}}, {"flee", {}}};
    blend.def.transitions = {{0, 1, {{0, 0, false}}, false}, {1, 0, {{0, 0, true}}, false}};
    blend.def.response_s = response_s;
    blend.inputs = {kSensePlayerDistance};
    state.choice = blend;
    BrainState home;
    home.name = "home";
    home.action = ActionKind::kReturn;
    home.speed_factor = 0.5F;
    BrainState flee;
    flee.name = "flee";
    flee.action = ActionKind::kFlee;
    flee.stance = 2;
    state.actions = {home, flee};
    brain.states = {state};
    return brain;
}

/// An agent at the origin whose home is far along +x, with a player behind it along -z.
struct Shy {
    Field field;

    explicit Shy(float player_m, float response_s = 0.0F) {
        field.settings.brains = {shy(response_s)};
        field.add_npc(1, kGuard, 0, Vec3::Zero());
        Agent agent = field.agents.take(EntityId(1));
        agent.home = Vec3(1000.0F, 0.0F, 0.0F);
        field.agents.add(agent);
        field.add_player(2, Vec3(0.0F, 0.0F, -player_m));
    }

    /// Until the next decision is made and acted on.
    void decide() {
        const Tick due = field.agents.find(EntityId(1))->next_decision;
        field.wall = [](const Vec3&) {
            return true;
        };  // no agent moves
        do {
            field.step();
        } while (field.now <= due);
    }

    [[nodiscard]] float degree(std::size_t state) const {
        return field.agents.find(EntityId(1))->degrees[state];
    }
};

TEST(Blend, DoesWhatItsStatesWantTogether) {
    // A player at 10 m is near by a half: of the first state half stays, half goes over, and both
    // are scaled to 1. Home at a half along +x and flight at 1 along +z are (0.25, 0.5) together.
    Shy half(10.0F);
    half.decide();
    EXPECT_EQ(half.degree(0), 1.0F);
    EXPECT_EQ(half.degree(1), 1.0F);
    EXPECT_NEAR(half.field.command(1).move_x, 127.0F * 0.25F, 1.0F);
    EXPECT_NEAR(half.field.command(1).move_z, 127.0F * 0.5F, 1.0F);
    // atan2(1, 2) of a turn.
    EXPECT_NEAR(half.field.command(1).yaw, std::atan2(0.25F, 0.5F) / 6.2831853F * 65536.0F, 300.0F);

    Shy alone(20.0F);
    alone.decide();
    EXPECT_EQ(alone.degree(1), 0.0F);
    EXPECT_NEAR(alone.field.command(1).move_x, 127.0F * 0.5F, 1.0F);
    EXPECT_EQ(alone.field.command(1).move_z, 0);
    EXPECT_EQ(alone.field.entities.stance[0], 0);

    Shy close(4.0F);
    close.decide();
    EXPECT_EQ(close.degree(0), 0.0F);
    EXPECT_EQ(close.field.command(1).move_x, 0);
    EXPECT_EQ(close.field.command(1).move_z, 127);
    EXPECT_EQ(close.field.entities.stance[0], 2) << "the stance of the most active";
}

TEST(Blend, RespondsInTheTimeThatItSays) {
    // Decisions every 0.2 s and a response of 1 s: a degree moves by 0.2 at each.
    Shy shy(4.0F, 1.0F);
    for (int k = 1; k <= 5; ++k) {
        shy.decide();
        EXPECT_NEAR(shy.degree(0), 1.0F - 0.2F * static_cast<float>(k), 1e-5F);
        EXPECT_NEAR(shy.degree(1), 0.2F * static_cast<float>(k), 1e-5F);
        if (k == 2) {
            // (0.6 x 0.5, 0.4 x 1) over a sum of 1.
            EXPECT_NEAR(shy.field.command(1).move_x, 127.0F * 0.3F, 1.0F);
            EXPECT_NEAR(shy.field.command(1).move_z, 127.0F * 0.4F, 1.0F);
        }
    }
}

TEST(Blend, SprintsWhereItsStatesWantMoreThanAWalk) {
    Shy fast(4.0F);
    fast.field.settings.brains[0].states[0].actions[1].sprint = true;
    fast.decide();
    EXPECT_EQ(fast.field.command(1).buttons, motion::kButtonSprint);
    EXPECT_EQ(fast.field.command(1).move_z, 127);
}

TEST(Blend, WalksAroundWhatIsInItsWay) {
    Shy stuck(20.0F);
    stuck.decide();  // and no agent moves
    for (int t = 0; t < 90 && stuck.field.command(1).move_z == 0; ++t) {
        stuck.field.step();
    }
    EXPECT_NE(stuck.field.command(1).move_z, 0) << "across its way";
}

/// Roams, and would run from a player; rests now and then.
Brain roamer() {
    Brain brain = shy(1.0F);
    brain.states[0].actions[0].action = ActionKind::kWander;
    brain.states[0].actions[0].radius_m = 20.0F;
    brain.states[0].actions[0].speed_factor = 1.0F;
    brain.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 50.0F, 0.0F}};
    brain.states.emplace_back();
    brain.states[1].name = "rest";
    brain.states[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 10.0F, 0.0F}};
    return brain;
}

constexpr std::uint32_t kRoamers = 24;

/// For each of some agents that roam for ten minutes: its path length, m, and its mean distance
/// from home, m.
struct Roamed {
    std::array<double, kRoamers> way{};
    std::array<double, kRoamers> off{};
    std::uint64_t active = 0;
    std::vector<std::uint16_t> states;
};

Roamed roamed(bool simulated, std::uint32_t first) {
    constexpr int kSeconds = 600;
    Field field;
    field.settings.brains = {roamer()};
    field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 50.0F;
    compile(field.settings, kDt);
    for (std::uint32_t k = 0; k < kRoamers; ++k) {
        field.add_npc(first + k, kGuard, 0, Vec3(100.0F * static_cast<float>(k), 0.9F, 0.0F));
        field.entities.set(field.entities.find(EntityId(first + k)), world::kGrounded, true);
    }
    Roamed out;
    std::array<Vec2, kRoamers> before{};
    for (int s = 0; s < kSeconds; ++s) {
        for (int t = 0; t < 30; ++t) {
            field.step();
            out.active += field.agents.active().size();
        }
        for (std::uint32_t k = 0; k < kRoamers; ++k) {
            const Agent& agent = *field.agents.find(EntityId(first + k));
            const Vec3& body = field.position(first + k);
            const Vec2 at = whereabouts(agent, {body.x(), body.z()}, field.now, kDt);
            out.way[k] += s > 0 ? (at - before[k]).norm() : 0.0F;
            out.off[k] += (at - Vec2(agent.home.x(), agent.home.z())).norm() / kSeconds;
            out.states.push_back(field.state(first + k));
            before[k] = at;
        }
    }
    return out;
}

double mean_of(const std::array<double, kRoamers>& samples) {
    return std::accumulate(samples.begin(), samples.end(), 0.0) / kRoamers;
}

/// Welch's t of two means.
double welch(const std::array<double, kRoamers>& a, const std::array<double, kRoamers>& b) {
    const auto square = [](const std::array<double, kRoamers>& samples) {
        double sum = 0.0;
        for (const double sample : samples) {
            sum += (sample - mean_of(samples)) * (sample - mean_of(samples));
        }
        return sum / (kRoamers - 1) / kRoamers;
    };
    return std::abs(mean_of(a) - mean_of(b)) / std::sqrt(square(a) + square(b));
}

/// With 46 degrees of freedom |t| exceeds 2.69 in one of a hundred cases in which nothing differs.
constexpr double kMostT = 2.69;

TEST(Blend, IsSkippedWhereItHasSettledAndNobodySees) {
    const Roamed seen = roamed(true, 1);
    const Roamed unseen = roamed(false, 1);
    const Roamed others = roamed(false, 100);
    EXPECT_EQ(seen.states, unseen.states) << "they rest by time alone";
    EXPECT_LT(unseen.active, seen.active / 20);
    for (const Roamed* const run : {&unseen, &others}) {
        EXPECT_LT(welch(seen.way, run->way), kMostT) << mean_of(seen.way) << mean_of(run->way);
        EXPECT_LT(welch(seen.off, run->off), kMostT) << mean_of(seen.off) << mean_of(run->off);
    }
    EXPECT_GT(mean_of(seen.way), 1000.0) << "they roam";
}

TEST(Blend, TellsItsDegrees) {
    Shy shy(10.0F);
    shy.decide();
    const Field& field = shy.field;
    const std::string text = explain(*field.agents.find(EntityId(1)),
                                     field.settings.brains[0],
                                     field.settings.compiled[0],
                                     Percept{},
                                     Vec2::Zero(),
                                     field.points_of_interest,
                                     field.now,
                                     kDt);
    EXPECT_NE(text.find("live:home 1\n"), std::string::npos) << text;
    EXPECT_NE(text.find("live:flee 1\n"), std::string::npos) << text;
}

TEST(Blend, GoesOnWhenBrainsAreReadAnew) {
    Shy shy_one(4.0F);
    shy_one.decide();
    Agent agent = shy_one.field.agents.take(EntityId(1));
    const CompiledBrain other = compile(shy(2.0F), kDt);
    migrate(agent, shy_one.field.settings.compiled[0], other, 0, shy_one.field.now, kDt);
    EXPECT_EQ(agent.degrees[0], 0.0F);
    EXPECT_EQ(agent.degrees[1], 1.0F);
    EXPECT_EQ(other.states[agent.current_action].name, "live:flee");
}

}  // namespace
}  // namespace zoned::ai::test
