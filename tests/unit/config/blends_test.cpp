// Blends and perceptions in a config: they take effect as written, and mistakes are found at their
// places.
#include "server/config/npc/blends.h"

#include "tests/unit/config/config_helpers.h"

#include <cmath>

namespace zoned::config::test {
namespace {

const std::string kBlended = with("state { name: \"chase\" action: CHASE }\n}",
                                  R"(state { name: "chase" blend: "wary" }
  variable { name: "vigour" start: 1 }
  perception {
    target: "crate"
    players: false
    half_angle_deg: 60
    line_of_sight: true
    memory_s: 5
  }
}
blend {
  name: "wary"
  input { name: "foe" sensor: PLAYER_DISTANCE high: 40
    term { name: "near" b: 5 d: 15 }
    term { name: "far" a: 5 b: 15 }
  }
  input { name: "vigour" sense: "vigour"
    term { name: "tired" b: 0.2 d: 0.6 }
    term { name: "fresh" a: 0.2 b: 0.6 }
  }
  state { name: "hold" do { action: GUARD radius_m: 6 } }
  state { name: "back" do { action: FLEE stance: RUNNING change { variable: "vigour" per_s: -0.1 } } }
  transition { from: "hold" to: "back" when { input: "foe" is: "near" } when { input: "vigour" is: "tired" } }
  transition { from: "back" to: "hold" when { input: "foe" is: "far" } when { input: "vigour" is: "fresh" } any: true }
  response_s: 2
})");

TEST(BlendsInConfigs, AreBuiltAsWritten) {
    const Outcome out = parse(kBlended);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& guard = out.settings.ai.compiled[0];
    ASSERT_EQ(guard.states.size(), 4U);
    EXPECT_EQ(guard.states[2].name, "chase:hold");
    EXPECT_EQ(guard.states[2].action, ai::ActionKind::kGuard);
    EXPECT_EQ(guard.states[2].radius_m, 6.0F);
    EXPECT_EQ(guard.states[2].leash_m, 9.0F) << "one and a half of the radius";
    EXPECT_EQ(guard.states[3].stance, 2);
    ASSERT_EQ(guard.blends.size(), 1U);
    EXPECT_EQ(guard.blends[0].inputs,
              (std::vector<ai::SenseIndex>{ai::kSensePlayerDistance, ai::kOwnSenses}));
    EXPECT_EQ(guard.choices[1].blend, 0);
    EXPECT_EQ(guard.choices[0].blend, -1);
}

TEST(PerceptionInConfigs, IsBuiltAsWritten) {
    const Outcome out = parse(kBlended);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::Perception& perception = out.settings.ai.compiled[0].perception;
    EXPECT_TRUE(perception.given);
    EXPECT_FALSE(perception.players);
    EXPECT_EQ(perception.targets, (std::vector<TypeIndex>{1}));
    EXPECT_NEAR(perception.cos_half_angle, 0.5F, 1e-6F);
    EXPECT_TRUE(perception.line_of_sight);
    EXPECT_EQ(perception.memory_s, 5.0F);
    EXPECT_EQ(perception.hearing_m, 0.0F);
    const Outcome plain = parse(kValid);
    EXPECT_FALSE(plain.settings.ai.compiled[0].perception.given);
}

TEST(PerceptionInConfigs, OfATypeStandsInPlaceOfItsBrains) {
    const Outcome out = parse(with("  brain: \"guard\"\n",
                                   "  brain: \"guard\"\n  perception { half_angle_deg: 90 }\n",
                                   kBlended));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& agent = out.settings.ai.compiled.at(out.settings.types[2].brain - 1U);
    EXPECT_EQ(agent.name, "guard.brain");
    EXPECT_TRUE(agent.perception.players);
    EXPECT_NEAR(agent.perception.cos_half_angle, 0.0F, 1e-6F);
    EXPECT_EQ(agent.perception.memory_s, 0.0F);
}

TEST(MistakesInBlends, AreFoundWhereTheyAre) {
    const auto one = [](const std::string& from,
                        const std::string& to,
                        const std::string& needle,
                        const std::string& words) {
        expect_single(with(from, to, kBlended), needle, words);
    };
    one("blend: \"wary\"", "blend: \"warier\"", "blend: \"warier\"", "no blend named 'warier'");
    one("from: \"back\" to: \"hold\"",
        "from: \"back\" to: \"held\"",
        "to: \"held\"",
        "no state named 'held'");
    one("input: \"foe\" is: \"far\"",
        "input: \"foe\" is: \"afar\"",
        "is: \"afar\"",
        "no term named 'afar'");
    one("a: 5 b: 15", "a: 16 b: 17", "input { name: \"foe\"", "belong");
    one("sense: \"vigour\"", "sense: \"vigor\"", "sense: \"vigor\"", "do not sense 'vigor'");
    one("variable: \"vigour\" per_s",
        "variable: \"vigor\" per_s",
        "variable: \"vigor\"",
        "no variable named");
    one("do { action: GUARD",
        "do { action: FLOCK",
        "do { action: FLOCK",
        "FLOCK cannot be blended");
    one("do { action: GUARD radius_m: 6",
        "do { action: FLEE radius_m: 6",
        "do { action: FLEE stance",
        "another state of the blend");
}

TEST(MistakesInPerception, AreFoundWhereTheyAre) {
    expect_single(with("target: \"crate\"", "target: \"crates\"", kBlended),
                  "target: \"crates\"",
                  "no type named 'crates'");
    expect_single(
        with("    target: \"crate\"\n", "", kBlended), "perception {", "looks for nobody");
    expect_single(with("action: GUARD radius_m: 6", "action: ESCORT radius_m: 6", kBlended),
                  "brain {\n  name: \"guard\"",
                  "has no `ward`");
    expect_single(with("action: CHASE", "action: GUARD radius_m: 9 leash_m: 8"),
                  "leash_m",
                  "shorter than radius_m");
}

}  // namespace
}  // namespace zoned::config::test
