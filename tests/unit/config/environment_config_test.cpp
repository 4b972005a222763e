// Clocks and shared variables, cones and concealed bursts: the settings that a config may have.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

#include <numbers>

namespace zoned::config::test {
namespace {

const std::string kEnvironment = R"(environment {
  clock { name: "time_of_day" start: 8 rate_per_s: 0.02 period: 24 }
  variable {
    name: "rain"
    seed: 3
    blend_s: 20
    phase { name: "clear" weight: 3 min_s: 120 max_s: 600 }
    phase { name: "storm" value: 1 min_s: 30 }
  }
  sync_every_s: 30
}
)";

TEST(SharedEnvironmentInConfigs, IsExpandedAndToldAtLogin) {
    const Outcome out = parse(kEnvironment + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const clock::EnvironmentDefs& environment = out.settings.environment;
    ASSERT_EQ(environment.clocks.size(), 1U);
    EXPECT_EQ(environment.clocks[0].first, (clock::ClockCourse{0, 8.0, 0.02}));
    EXPECT_EQ(environment.clocks[0].period, 24.0);
    ASSERT_EQ(environment.variables.size(), 1U);
    ASSERT_EQ(environment.variables[0].phases.size(), 2U);
    EXPECT_EQ(environment.variables[0].phases[1].max_s, 30.0) << "not set: as min_s";
    EXPECT_EQ(environment.sync_ticks, 900);
    EXPECT_TRUE(parse(kValid).settings.environment.empty());
    EXPECT_NE(parse(with("seed: 3", "seed: 4", kEnvironment + kValid)).settings.digest,
              out.settings.digest);
}

TEST(SharedEnvironmentInConfigs, IsRefusedWhereItMakesNoSense) {
    expect_single(with("name: \"rain\"", "name: \"time_of_day\"", kEnvironment + kValid),
                  "name: \"time_of_day\"\n    seed",
                  "the name of another");
    expect_single(
        with("max_s: 600", "max_s: 60", kEnvironment + kValid), "max_s: 60", "less than min_s");
}

TEST(ConesInConfigs, BelongToTheNimbusOfCharacters) {
    const std::string stance = "stance: \"zoomed\"\n";
    const std::string cone =
        "named { stance: \"zoomed\" radius_m: 20 cone { length_m: 52 half_angle_deg: 30 } }";
    const Outcome out = parse(
        with("nimbus_m { normal: 50 }", "nimbus_m { normal: 50 " + cone + " }", stance + kValid));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& types = out.settings.types;
    EXPECT_EQ(types[0].nimbus_cone[4].length_m, 52.0F);
    EXPECT_NEAR(types[0].nimbus_cone[4].half_angle_rad, std::numbers::pi / 6.0, 1e-6);
    EXPECT_EQ(types[0].nimbus_cone[5].length_m, 0.0F);
    EXPECT_EQ(types[0].nimbus_m[4], 20.0F);
    expect_single(
        with("aura_m { normal: 50 }", "aura_m { normal: 50 " + cone + " }", stance + kValid),
        "cone {",
        "only the nimbus of characters");
}

TEST(StancesInConfigs, AreAtMostFour) {
    std::string text = kValid;
    for (const char* name : {"flying", "driving", "zoomed", "crawling"}) {
        text = "stance: \"" + std::string(name) + "\"\n" + text;
    }
    EXPECT_TRUE(parse(text).ok) << format_errors("test", parse(text).errors);
    expect_single("stance: \"one\"\n" + text, "stance: \"flying\"", "at most 4");
}

TEST(ConesInConfigs, ReachNoFartherThanTheGhosts) {
    const std::string text = with("nimbus_m { normal: 50 }",
                                  "nimbus_m { normal: 50 named { stance: \"zoomed\" radius_m: "
                                  "20 cone { length_m: 900 } } }",
                                  "stance: \"zoomed\"\n" + kValid);
    const Outcome out = parse(text);
    EXPECT_FALSE(out.ok);
    ASSERT_FALSE(out.errors.empty());
    EXPECT_NE(format_errors("test", out.errors).find("nimbus of 900 m"), std::string::npos)
        << format_errors("test", out.errors);
}

TEST(BurstsInConfigs, AreFilteredByLineOfSightAlone) {
    const std::string sparks =
        "particles { name: \"sparks\" burst { visibility_filter: LINE_OF_SIGHT } }\n" + kValid;
    const Outcome out = parse(sparks);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.cosmetic_bursts.size(), 1U);
    EXPECT_TRUE(out.settings.cosmetic_bursts[0].line_of_sight);
    expect_single(
        with("LINE_OF_SIGHT", "RULES", sparks), "visibility_filter: RULES", "not about places");
}

}  // namespace
}  // namespace zoned::config::test
