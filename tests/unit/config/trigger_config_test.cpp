// Triggers: the permitted settings, and the reported mistakes.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

namespace zoned::config::test {
namespace {

const std::string kTriggers = R"(trigger {
  name: "goal" x_m: 10 y_m: 1 z_m: -5
  size { x_m: 4 y_m: 2 z_m: 6 }
  yaw_deg: 90
  type: "crate"
}
trigger {
  name: "trap"
  size { x_m: 1 y_m: 1 z_m: 1 }
}
)";

TEST(TriggersInConfigs, AreBoxesWithTheTypesThatTheyNotice) {
    const Outcome out = parse(kTriggers + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.triggers.size(), 2U);
    const zone::Trigger& goal = out.settings.triggers[0];
    EXPECT_EQ(goal.name, "goal");
    EXPECT_EQ(goal.notices, (std::vector<bool>{false, true, false}));
    // Turned by a quarter: 6 m along x, 4 m along z.
    EXPECT_TRUE(goal.holds(Vec3(12.9F, 1.9F, -3.1F)));
    EXPECT_FALSE(goal.holds(Vec3(13.1F, 1.0F, -5.0F)));
    EXPECT_FALSE(goal.holds(Vec3(10.0F, 1.0F, -2.9F)));
    EXPECT_FALSE(goal.holds(Vec3(10.0F, 2.1F, -5.0F)));
    EXPECT_EQ(out.settings.triggers[1].notices, (std::vector<bool>{true, true, true}));
}

TEST(TriggersInConfigs, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kTriggers + kValid;
    expect_single(with("name: \"trap\"", "name: \"goal\"", text),
                  "name: \"goal\"\n  size",
                  "the name of another trigger");
    expect_single(with("  name: \"trap\"\n", "", text), "trigger {\n  size", "name");
    expect_single(with("  size { x_m: 1 y_m: 1 z_m: 1 }\n", "", text),
                  "trigger {\n  name: \"trap\"",
                  "a trigger has a size");
    expect_single(with("type: \"crate\"", "type: \"crates\"", text),
                  "type: \"crates\"",
                  "no type is called 'crates'");
    expect_single(with("x_m: 10", "x_m: 5000", text), "trigger {", "outside the world");
}

}  // namespace
}  // namespace zoned::config::test
