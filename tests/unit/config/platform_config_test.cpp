// Platforms: the permitted settings, and the reported mistakes.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

namespace zoned::config::test {
namespace {

const std::string kPlatforms = R"(platform {
  name: "lift" speed_mps: 2 wait_s: 1.5 begin_s: 4
  box { x_m: 10 y_m: 1 size { x_m: 3 y_m: 0.2 z_m: 4 } }
  stop { x_m: 10 y_m: 5 }
  stop { x_m: 10 y_m: 5 z_m: 3.01 }
}
platform {
  name: "ferry" moved_by: RULES start_stop: 1
  box { y_m: 1 }
  stop { x_m: 20 y_m: 1 }
}
)";

TEST(PlatformsInConfigs, AreExpandedToTicksAndToldAtLogin) {
    const Outcome out = parse(kPlatforms + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.platforms.size(), 2U);
    const NamedPlatform& lift = out.settings.platforms[0];
    EXPECT_EQ(lift.name, "lift");
    EXPECT_EQ(lift.platform.box.half_extents, Vec3(1.5F, 0.1F, 2.0F));
    // At 30 ticks a second; the second piece takes 45.15 ticks, which are 46 whole ones.
    const motion::PlatformPath& path = lift.platform.path;
    ASSERT_EQ(path.stops.size(), 3U);
    EXPECT_EQ(path.stops[0], (motion::PlatformStop{Vec3::Zero(), 0}));
    EXPECT_EQ(path.stops[1], (motion::PlatformStop{Vec3(0.0F, 4.0F, 0.0F), 60}));
    EXPECT_EQ(path.stops[2].at, 106);
    EXPECT_NEAR(path.stops[2].offset.z(), 3.01, motion::kPlatformStep_m);
    EXPECT_EQ(path.wait, 45);
    EXPECT_EQ(path.shift, 120);
    EXPECT_EQ(path.back, 0);
    EXPECT_FALSE(path.by_rules.has_value());
    const motion::PlatformPath& ferry = out.settings.platforms[1].platform.path;
    EXPECT_EQ(ferry.by_rules, 1U);
    EXPECT_EQ(ferry.start, ferry.stops[1].at);
    EXPECT_NE(parse(with("speed_mps: 2", "speed_mps: 3", kPlatforms + kValid)).settings.digest,
              out.settings.digest);
    const Outcome loop =
        parse(with("speed_mps: 2", "speed_mps: 2 loop: true", kPlatforms + kValid));
    ASSERT_TRUE(loop.ok) << format_errors("test", loop.errors);
    EXPECT_EQ(loop.settings.platforms[0].platform.path.back, 76) << "5.006 m at 2 m/s";
}

TEST(PlatformsInConfigs, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kPlatforms + kValid;
    const std::string ferry = "platform {\n  name: \"ferry\"";
    expect_single(with("name: \"ferry\"", "name: \"lift\"", text),
                  "name: \"lift\" moved_by",
                  "the name of another platform");
    expect_single(with("  stop { x_m: 20 y_m: 1 }\n", "", with("start_stop: 1", "", text)),
                  "platform {\n  name: \"ferry\"",
                  "has one stop");
    expect_single(with("x_m: 10 y_m: 5 z_m: 3.01", "x_m: 10 y_m: 5", text),
                  "stop { x_m: 10 y_m: 5 }\n}",
                  "is where the stop before it is");
    expect_single(with("speed_mps: 2", "speed_mps: 0", text), "speed_mps: 0", "out of range");
    expect_single(
        with("x_m: 20 y_m: 1", "x_m: 2000 y_m: 1", text), "stop { x_m: 2000", "outside the world");
    expect_single(
        with("  box { y_m: 1 }\n  stop { x_m: 20", "  stop { x_m: 20", text), ferry, "has a box");
    expect_single(with("start_stop: 1", "start_stop: 2", text),
                  "start_stop: 2",
                  "there is no stop 2: the last one is 1");
    expect_single(with("start_stop: 1", "loop: true", text), ferry, "is moved by rules");
    expect_single(with("begin_s: 4", "start_stop: 1", text),
                  "start_stop: 1\n  box",
                  "is for platforms with moved_by: RULES");
    expect_single(with("begin_s: 4", "loop: true", with("y_m: 5 z_m: 3.01", "y_m: 1", text)),
                  "stop { x_m: 10 y_m: 1 }",
                  "a loop comes back there by itself");
    expect_single(with("name: \"ferry\"", "", text), "platform {\n   moved_by", "name");
}

}  // namespace
}  // namespace zoned::config::test
