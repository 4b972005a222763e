// Difficulty follows the players' success: it settles at the wanted success rate and never leaves
// its cap. Agents go on from one difficulty to the next.
#include "server/ai/agent/difficulty.h"

#include "server/ai/serialization/serialize_agents.h"
#include "tests/unit/ai/field.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <array>

namespace zoned::ai {
namespace {

using namespace test;

/// `levels` without brains, wanted share 0.6.
DifficultyLevels bare(std::size_t levels, float step, Tick between = 0) {
    DifficultyLevels settings;
    settings.levels.resize(levels);
    settings.staircase = {0.6F, step, 0.0F, static_cast<float>(levels - 1)};
    settings.between = between;
    return settings;
}

TEST(DifficultyState, SettlesWherePlayersSucceedAsOftenAsWanted) {
    // No level has exactly the wanted success rate: two levels have to take turns.
    constexpr std::array<float, 4> kChance = {0.95F, 0.7F, 0.5F, 0.1F};
    constexpr int kCount = 5000;
    constexpr float kStep = 0.05F;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const DifficultyLevels settings = bare(4, kStep);
        DifficultyState difficulty = first_of(settings);
        core::Rng rng(seed);
        int successes = 0;
        std::array<int, 4> visits{};
        for (int i = 0; i < kCount; ++i) {
            const bool success = rng.unit() < kChance[difficulty.level];
            successes += success ? 1 : 0;
            note_outcome(difficulty, settings, success);
            difficulty.level = level_due(difficulty, settings, i);
            ++visits[difficulty.level];
            ASSERT_LT(difficulty.position, 3.0F)
                << "the bound below holds where the cap is not met";
        }
        // The position is step (successes - wanted count) from the start, and nowhere above the
        // cap. At its foot, where it starts, it is cut off by at most a few outcomes.
        const double off = std::abs(static_cast<double>(successes) / kCount - 0.6);
        EXPECT_LE(off, 3.0 / static_cast<double>(kStep) / kCount + 10.0 / kCount);
        EXPECT_GT(visits[1], kCount / 5);
        EXPECT_GT(visits[2], kCount / 5);
        EXPECT_EQ(visits[3], 0);
    }
}

TEST(DifficultyState, NeverLeavesItsCapAndWaitsBetweenChanges) {
    DifficultyLevels settings = bare(5, 1.0F, 30);
    settings.staircase.least = 1.0F;
    settings.staircase.most = 3.0F;
    settings.start = 2;
    DifficultyState difficulty = first_of(settings);
    core::Rng rng(3);
    int changes = 0;
    for (Tick now = 0; now < 20000; ++now) {
        // Minutes of one kind of outcome, so that both ends are met.
        note_outcome(difficulty, settings, (now / 500) % 2 == 0 || rng.below(10) == 0);
        const std::uint16_t due = level_due(difficulty, settings, now);
        ASSERT_GE(due, 1);
        ASSERT_LE(due, 3);
        if (due != difficulty.level) {
            ASSERT_GE(now - difficulty.changed_at, 30);
            difficulty.level = due;
            difficulty.changed_at = now;
            ++changes;
        }
    }
    EXPECT_GT(changes, 20);
    DifficultyState none;
    note_outcome(none, {}, true);
    EXPECT_EQ(none.position, 0.0F);
    EXPECT_EQ(level_due(none, {}, 1000), 0);
}

/// Walks about, rests after a time that depends on the difficulty.
Brain walker(float rest_after_s, float pace = 0.5F) {
    Brain m;
    m.name = "walker";
    m.states.resize(2);
    m.states[0].name = "wander";
    m.states[0].action = ActionKind::kWander;
    m.states[0].speed_factor = pace;
    m.states[0].radius_m = 200.0F;
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, rest_after_s, 0.0F}};
    m.states[1].name = "rest";
    m.states[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 2.0F, 0.0F}};
    return m;
}

Brain idler() {
    Brain m;
    m.name = "idler";
    m.states.resize(1);
    m.states[0].name = "stand";
    return m;
}

/// Two difficulties; walkers have brain 0, which varies, idlers brain 1.
void fill_difficulty_levels(Field& field) {
    field.settings.brains = {walker(3.0F), idler()};
    field.settings.difficulty = bare(2, 0.5F);
    field.settings.difficulty.levels[0].name = "easy";
    field.settings.difficulty.levels[1].name = "hard";
    field.settings.difficulty.levels[1].brains = {walker(6.0F, 0.25F), idler()};
    field.settings.difficulty.varies = {true, false};
    compile(field.settings, kDt);
    for (std::uint32_t id = 1; id <= 20; ++id) {
        const auto brain = static_cast<std::uint16_t>(id % 4 == 0 ? 1 : 0);
        field.add_npc(id, kGuard, brain, Vec3(4.0F * static_cast<float>(id), 0.9F, 0.0F));
        begin(*field.agents.find(EntityId(id)), field.settings.compiled[brain], 0);
    }
    field.add_player(900, Vec3(20.0F, 0.9F, 5.0F));
}

std::uint64_t hash_of_all(Field& field) {
    core::StateHash hash;
    field.agents.hash(hash);
    for (std::uint32_t id = 1; id <= 20; ++id) {
        hash.add(field.position(id).x());
        hash.add(field.position(id).z());
    }
    return hash.value();
}

void go_to(Field& field, std::uint16_t level) {
    change_level(field.agents, field.settings, field.steps.difficulty(), level, field.now, kDt);
}

TEST(DifficultyState, AgentsGoOnWithTheBrainsOfTheNextLevel) {
    Field field;
    fill_difficulty_levels(field);
    field.run(2.0F);
    const Tick since = field.agents.find(EntityId(1))->state_machine.since[0];
    note_outcome(field.steps.difficulty(), field.settings.difficulty, true);
    const LevelChange change =
        change_level(field.agents, field.settings, field.steps.difficulty(), 1, field.now, kDt);
    EXPECT_EQ(change.from, 0);
    EXPECT_EQ(change.to, 1);
    EXPECT_EQ(change.successes, 1U);
    EXPECT_EQ(field.steps.difficulty().successes, 0U);
    EXPECT_EQ(field.settings.difficulty.active, 1);
    EXPECT_EQ(field.settings.brains[0].states[0].transitions[0].threshold, 6.0F);
    EXPECT_EQ(brain_at_level(field.settings, 0, 0).name, "walker") << "what was left is kept";
    EXPECT_EQ(field.agents.find(EntityId(1))->state_machine.since[0], since) << "time goes on";
    EXPECT_TRUE(field.agents.find(EntityId(1))->fresh);
    EXPECT_FALSE(field.agents.find(EntityId(4))->fresh) << "its brain is the same everywhere";
    const Vec3 from = field.position(1);
    field.run(3.5F);
    // Halfway along its first segment: 0.98 of a quarter of 4 m/s, by commands of 1/127.
    EXPECT_NEAR((field.position(1) - from).norm(), 3.5F * 0.98F, 0.1F) << "another pace at once";
    EXPECT_EQ(field.state(1), 0) << "after 5.5 s: it would rest on the other level";
    field.run(1.0F);
    EXPECT_EQ(field.state(1), 1);
    go_to(field, 0);
    EXPECT_EQ(field.settings.brains[0].states[0].transitions[0].threshold, 3.0F);
}

TEST(DifficultyState, BytesGoOnBitForBitOnTheSameLevel) {
    Field field;
    fill_difficulty_levels(field);
    field.run(5.0F);
    go_to(field, 1);
    note_outcome(field.steps.difficulty(), field.settings.difficulty, false);
    field.run(4.0F);
    std::vector<std::uint8_t> bytes;
    save_agents(field.agents, field.steps, field.points_of_interest, bytes);
    Field other;
    fill_difficulty_levels(other);
    other.now = field.now;
    other.entities = field.entities;
    other.agents = AgentStore();
    ASSERT_EQ(
        load_agents(bytes, other.settings, other.agents, other.steps, other.points_of_interest),
        "");
    EXPECT_EQ(other.settings.difficulty.active, 1);
    EXPECT_EQ(other.steps.difficulty().failures, 1U);
    EXPECT_EQ(other.steps.difficulty().position, field.steps.difficulty().position);
    for (int tick = 0; tick < 900; ++tick) {
        field.step();
        other.step();
        ASSERT_EQ(hash_of_all(field), hash_of_all(other)) << "tick " << tick;
    }
    // On the wrong level the two would not agree.
    go_to(other, 0);
    other.run(20.0F);
    field.run(20.0F);
    EXPECT_NE(hash_of_all(field), hash_of_all(other));

    bytes[4] = 7;  // the level
    AgentStore agents;
    EXPECT_EQ(load_agents(bytes, other.settings, agents, other.steps, other.points_of_interest),
              "the difficulty is cut short, or none of the settings");
    EXPECT_EQ(agents.size(), 0U);
}

TEST(DifficultyState, SettingsThatAreReadAnewGoOnByName) {
    Field field;
    fill_difficulty_levels(field);
    DifficultyState difficulty{1, 0.75F, 3, 4, 10};
    const DifficultyLevels before = field.settings.difficulty;
    AiSettings fresh;
    fresh.brains = {walker(1.0F), idler()};
    fresh.difficulty = bare(3, 0.5F);
    fresh.difficulty.levels[1].name = "easy";
    fresh.difficulty.levels[2].name = "hard";
    fresh.difficulty.levels[2].brains = {walker(9.0F), idler()};
    compile(fresh, kDt);
    go_on_with(difficulty, before, fresh, 50);
    EXPECT_EQ(difficulty.level, 2);
    EXPECT_EQ(difficulty.position, 1.75F);
    EXPECT_EQ(difficulty.successes, 3U);
    EXPECT_EQ(fresh.brains[0].states[0].transitions[0].threshold, 9.0F);

    AiSettings other;
    other.brains = {walker(1.0F), idler()};
    other.difficulty = bare(2, 0.5F);
    other.difficulty.levels[0].name = "plain";
    compile(other, kDt);
    go_on_with(difficulty, fresh.difficulty, other, 60);
    EXPECT_EQ(difficulty.level, 0) << "there is none of that name";
    EXPECT_EQ(difficulty.position, 0.0F);
    EXPECT_EQ(difficulty.changed_at, 60);
}

}  // namespace
}  // namespace zoned::ai
