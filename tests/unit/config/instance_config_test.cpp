// Instances: the permitted settings, and the reported mistakes.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

namespace zoned::config::test {
namespace {

const std::string kCrypt = R"(instance {
  name: "crypt"
  area { min_x_m: 40 max_x_m: 80 min_z_m: -20 max_z_m: 20 }
  copies: 5
  close_s: 2
}
spawn { x_m: 50 z_m: 1 }
)";

TEST(InstancesInConfigs, AreZonesBeyondTheWorld) {
    const Outcome out = parse(kCrypt + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_TRUE(out.settings.instances);
    const zone::InstanceKind& crypt = out.settings.instances->kinds.at(0);
    EXPECT_EQ(crypt.name, "crypt");
    EXPECT_EQ(crypt.close_ticks, 60);
    ASSERT_EQ(crypt.copies.size(), 5u);
    ASSERT_EQ(out.settings.zones.size(), 7u);
    EXPECT_EQ(out.settings.zones[2].name, "crypt.1");
    EXPECT_GE(out.settings.zones[2].min_x, 100.0 + 120.0);
    EXPECT_EQ(out.settings.zones[6].max_x - out.settings.zones[6].min_x, 40.0);
    EXPECT_EQ(out.settings.first_states.size(), 5u);
    ASSERT_EQ(crypt.entrances.size(), 1u);
    EXPECT_EQ(crypt.entrances[0].x(), -10.0);
    // Nobody begins at an entrance.
    EXPECT_EQ(out.settings.spawn_points.size(), 1u);
    // The text is what was written: copies are made anew where it is read again.
    const Outcome again = parse(out.settings.text);
    ASSERT_TRUE(again.ok) << format_errors("test", again.errors);
    EXPECT_EQ(again.settings.digest, out.settings.digest);
    EXPECT_EQ(again.settings.text, out.settings.text);
}

TEST(InstancesInConfigs, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kCrypt + kValid;
    expect_single(with("  name: \"crypt\"\n", "", text), "instance {", "name");
    expect_single(with("min_x_m: 40", "min_x_m: 90", text), "instance {", "minimum");
    expect_single(with("min_x_m: 40", "min_x_m: -40", text), "area {", "within one zone");
    expect_single(with("spawn { x_m: 50 z_m: 1 }\n", "", text), "instance {", "no entrance");
    expect_single(with("spawn { x_m: 1 z_m: 2 }\n", "", text), "instance {", "no spawn point");
    expect_single(
        with("ghost_margin_m: 60", "ghost_margin_m: 1900", with("copies: 5", "copies: 512", text)),
        "instance {",
        "beyond 50 km");
    const std::string cave =
        "instance { name: \"cave\" copies: 512 area { min_x_m: 20 max_x_m: 30 min_z_m: 0 "
        "max_z_m: 9 } }\nspawn { x_m: 25 z_m: 1 }\n";
    expect_single(cave + with("copies: 5", "copies: 512", text), "instance {", "more than 1024");
    expect_single(
        "instance { name: \"cave\" area { min_x_m: 70 max_x_m: 90 min_z_m: 0 max_z_m: 9 } "
        "}\nspawn { x_m: 75 z_m: 1 }\n" +
            text,
        "area { min_x_m: 40",
        "overlaps");
}

}  // namespace
}  // namespace zoned::config::test
