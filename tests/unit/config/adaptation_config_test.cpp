// Difficulty that follows players: all difficulties of the list become brains, and each mistake
// is found at its line and column.
#include "server/config/npc/adaptation_config.h"

#include "server/config/npc/parameters.h"
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

/// Bandits notice players from a distance set by the difficulty; guards are the same at all of
/// them.
const std::string kAdapting = with("type {\n  name: \"guard\"",
                                   R"(brain {
  name: "ambush"
  perception_m_from: "sight_m"
  state { name: "lurk" action: IDLE transition { to: "rush" sensor: PLAYER_DISTANCE compare: BELOW threshold_from: "notice_m" } }
  state { name: "rush" action: CHASE }
}
behaviour {
  name: "robbery"
  brain: "ambush"
  parameter { name: "notice_m" value: 10 low: 1 high: 25 }
  parameter { name: "sight_m" value: 30 low: 25 high: 90 }
}
difficulty { name: "easy" set { name: "notice_m" value: 5 } }
difficulty { name: "usual" set { name: "notice_m" factor: 1 } }
difficulty { name: "same" set { name: "sight_m" factor: 1 } }
difficulty { name: "hard" set { name: "notice_m" value: 20 } set { name: "sight_m" value: 80 } }
ai {
  adaptation {
    difficulty: "easy"
    difficulty: "usual"
    difficulty: "hard"
    success: 0.7
    step: 0.5
    start: "usual"
    least: "easy"
    most: "hard"
    least_between_s: 2
  }
}
type {
  name: "bandit"
  kind: CHARACTER
  capsule { radius_m: 0.4 length_m: 1 }
  aura_m { normal: 40 }
  behaviour { name: "robbery" }
}
type {
  name: "guard")");

std::string adapting_with(const std::string& from, const std::string& to) {
    return with(from, to, kAdapting);
}

float notice_m(const ai::CompiledBrain& brain) {
    for (const ai::WatchedCondition& watch : brain.watches) {
        if (watch.sense == ai::kSensePlayerDistance) {
            return watch.threshold;
        }
    }
    return 0.0F;
}

TEST(Adaptation, MakesBrainsOfAllDifficulties) {
    const Outcome out = parse(adapting_with("success", "success"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::DifficultyLevels& difficulty = out.settings.ai.difficulty;
    ASSERT_EQ(difficulty.levels.size(), 3U);
    EXPECT_EQ(difficulty.levels[2].name, "hard");
    EXPECT_EQ(difficulty.start, 1);
    EXPECT_EQ(difficulty.active, 1);
    EXPECT_EQ(difficulty.between, 60) << "2 s at 30 ticks a second";
    EXPECT_EQ(difficulty.staircase.success, 0.7F);
    EXPECT_EQ(difficulty.staircase.most, 2.0F);
    std::size_t bandit = 0;
    std::size_t guard = 0;
    for (const world::EntityType& type : out.settings.types) {
        bandit = type.name == "bandit" ? type.brain - 1U : bandit;
        guard = type.name == "guard" ? type.brain - 1U : guard;
    }
    EXPECT_EQ(notice_m(out.settings.ai.compiled[bandit]), 10.0F);
    EXPECT_EQ(notice_m(brain_at_level(out.settings.ai, 0, bandit)), 5.0F);
    EXPECT_EQ(notice_m(brain_at_level(out.settings.ai, 1, bandit)), 10.0F);
    EXPECT_EQ(notice_m(brain_at_level(out.settings.ai, 2, bandit)), 20.0F);
    EXPECT_TRUE(difficulty.varies[bandit]);
    EXPECT_FALSE(difficulty.varies[guard]);
    EXPECT_GE(out.settings.ai.viewer_range_m, 80.0F)
        << "nobody sleeps who would notice on any difficulty";
    EXPECT_NE(parameters_text(out.settings).find("difficulty: usual, to begin with"),
              std::string::npos);
    EXPECT_TRUE(parse(kValid).settings.ai.difficulty.levels.empty());
    // The capped one still lists all; an unset value is the first permitted one.
    const Outcome capped = parse(
        adapting_with("    start: \"usual\"\n    least: \"easy\"\n", "    least: \"usual\"\n"));
    ASSERT_TRUE(capped.ok) << format_errors("test", capped.errors);
    EXPECT_EQ(capped.settings.ai.difficulty.start, 1);
    EXPECT_EQ(capped.settings.ai.difficulty.staircase.least, 1.0F);
}

TEST(Adaptation, ReportsEachMistakeAtItsPlace) {
    const auto single = [](const std::string& from, const std::string& to, const char* words) {
        expect_single(adapting_with(from, to), to, words);
    };
    single("difficulty: \"usual\"", "difficulty: \"brutal\"", "no difficulty named 'brutal'");
    single("least: \"easy\"", "least: \"none\"", "'none' is not in the list");
    single("most: \"hard\"", "most: \"same\"", "'same' is not in the list");
    single("start: \"usual\"", "start: \"other\"", "'other' is not in the list");
    single("least: \"easy\"\n    most: \"hard\"",
           "least: \"hard\"\n    most: \"easy\"",
           "the least must come before the most");
    single("least: \"easy\"", "least: \"hard\"", "or it would never change");
    single("start: \"usual\"\n    least: \"easy\"\n    most: \"hard\"",
           "start: \"hard\"\n    least: \"easy\"\n    most: \"usual\"",
           "lies outside of least and most");
    single("success: 0.7", "success: 1", "[0.05..0.95]");
    single("step: 0.5", "step: 0", "[0.001..1]");
    expect_single(adapting_with("  adaptation {", "  difficulty: \"hard\" adaptation {"),
                  "difficulty: \"hard\" adaptation",
                  "chosen by ai.adaptation");
    const std::string twice =
        adapting_with("difficulty: \"hard\"\n    success", "difficulty: \"easy\"\n    success");
    expect_single(twice, "difficulty: \"easy\"\n    success", "'easy' is in the list already");
}

TEST(Adaptation, ReportsDifficultiesThatNoTypeWouldNotice) {
    const std::string text = adapting_with("    difficulty: \"hard\"\n",
                                           "    difficulty: \"same\"\n    difficulty: \"hard\"\n");
    expect_single(text, "difficulty: \"same\"\n", "is the same as 'usual' for all types");
}

TEST(Adaptation, ChecksTheBrainsOfAllDifficulties) {
    // Noticed from farther than it perceives: on the hardest alone.
    const std::string text =
        adapting_with("set { name: \"notice_m\" value: 20 } set { name: \"sight_m\" value: 80 }",
                      "set { name: \"notice_m\" value: 25 } set { name: \"sight_m\" value: 25 }");
    const Outcome good = parse(text, {"difficulty[hard].set[1].value=26"});
    EXPECT_TRUE(good.ok) << format_errors("test", good.errors);
    const std::string wide = with("low: 25 high: 90", "low: 1 high: 90", text);
    const Outcome bad = parse(wide, {"difficulty[hard].set[1].value=10"});
    EXPECT_FALSE(bad.ok);
    const std::string errors = format_errors("test", bad.errors);
    EXPECT_NE(errors.find("25 m is beyond perception_m, 10"), std::string::npos) << errors;
    EXPECT_NE(errors.find("by 'hard' brains get mistakes"), std::string::npos) << errors;
}

}  // namespace
}  // namespace zoned::config::test
