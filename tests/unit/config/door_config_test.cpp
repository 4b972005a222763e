// Doors and paths: the permitted settings, and the reported mistakes.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

namespace zoned::config::test {
namespace {

const std::string kDoors = R"(door {
  name: "gate"
  box { x_m: 10 y_m: 1 size { x_m: 0.2 y_m: 3 z_m: 4 } yaw_deg: 90 }
  period_s: 10
  open { from_s: 8 to_s: 2 }
  open { from_s: 3 to_s: 4.5 }
}
door {
  name: "shop"
  box { y_m: 1 }
  open { from_s: 60 to_s: 120 }
}
ai { day_s: 600 dawn_s: 50 pathfinding { cell_m: 0.4 work_per_tick: 5000 } }
)";

TEST(DoorsInConfigs, AreExpandedToTicksAndToldAtLogin) {
    const Outcome out = parse(kDoors + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_EQ(out.settings.doors.size(), 2U);
    const NamedDoor& gate = out.settings.doors[0];
    EXPECT_EQ(gate.name, "gate");
    EXPECT_EQ(gate.door.box.half_extents, Vec3(0.1F, 1.5F, 2.0F));
    // At 30 ticks a second; over the end of the period it is two spans.
    using Span = motion::Timetable::OpenSpan;
    EXPECT_EQ(gate.door.times.period, 300);
    EXPECT_EQ(gate.door.times.shift, 0);
    EXPECT_EQ(gate.door.times.open, (std::vector<Span>{{0, 60}, {90, 135}, {240, 300}}));
    const motion::Timetable& shop = out.settings.doors[1].door.times;
    EXPECT_EQ(shop.period, 18000) << "a day";
    EXPECT_EQ(shop.shift, 1500) << "at dawn";
    EXPECT_FALSE(shop.open_at(0));
    EXPECT_EQ(shop.next_change(0), 300) << "dawn is at 50 s, and it opens at 60 s";
    EXPECT_NE(parse(with("to_s: 120", "to_s: 121", kDoors + kValid)).settings.digest,
              out.settings.digest);
    EXPECT_EQ(out.settings.ai.pathfinding.cell_m, 0.4F);
    EXPECT_EQ(out.settings.ai.pathfinding.work_per_tick, 5000U);
    EXPECT_EQ(parse(kValid).settings.ai.pathfinding.cell_m, 0.0F) << "no paths are planned";
}

TEST(DoorsInConfigs, OfRulesHaveOneStateAndNoTimes) {
    const std::string door = R"(door { name: "cell" moved_by: RULES box { y_m: 1 } }
)";
    const Outcome shut = parse(door + kValid);
    ASSERT_TRUE(shut.ok) << format_errors("test", shut.errors);
    const motion::Door& cell = shut.settings.doors[0].door;
    EXPECT_EQ(cell.by_rules, 0U);
    EXPECT_FALSE(cell.times.open_at(12345));
    const Outcome open = parse(with("RULES", "RULES starts_open: true", door + kValid));
    ASSERT_TRUE(open.ok) << format_errors("test", open.errors);
    EXPECT_TRUE(open.settings.doors[0].door.times.open_at(12345));
    expect_single(with("RULES", "RULES open { from_s: 1 to_s: 2 }", door + kValid),
                  "door { name: \"cell\"",
                  "is moved by rules: it has no times of its own");
    expect_single(with("  period_s: 10\n", "  period_s: 10 starts_open: true\n", kDoors + kValid),
                  "starts_open",
                  "is for doors with moved_by: RULES");
}

TEST(Levers, AreRefusedWithoutAFlagToTurn) {
    const std::string lever =
        R"(type { name: "lever" box { } aura_m { normal: 5 } field { name: "on" flag { } } lever { } }
)";
    const Outcome out = parse(kValid + lever);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const std::optional<world::Lever>& as = out.settings.types.back().lever;
    ASSERT_TRUE(as.has_value());
    EXPECT_EQ(as->button, 1U << 6U);
    EXPECT_EQ(as->field, wire::field_id("on"));
    expect_single(with("lever { }", "lever { field: \"off\" }", kValid + lever),
                  "field: \"off\"",
                  "'off' is no flag among the fields of the type");
    expect_single(with("flag { }", "number { }", kValid + lever),
                  "lever { }",
                  "'on' is no flag among the fields of the type");
}

TEST(DoorsInConfigs, AreRefusedWhereTheyMakeNoSense) {
    const std::string text = kDoors + kValid;
    expect_single(with("name: \"shop\"", "name: \"gate\"", text),
                  "name: \"gate\"\n  box { y_m",
                  "the name of another door");
    expect_single(with("  period_s: 10\n",
                       "  period_s: 0\n",
                       with("open { from_s: 60 to_s: 120 }",
                            "open { to_s: 1 }",
                            with("  open { from_s: 8 to_s: 2 }\n  open { from_s: 3 to_s: 4.5 }\n",
                                 "  open { to_s: 0.05 }\n",
                                 text))),
                  "period_s: 0",
                  "out of range");
    expect_single(with("from_s: 8", "from_s: 10", text), "from_s: 10", "not within the period");
    expect_single(with("to_s: 4.5", "to_s: 11", text), "to_s: 11", "beyond the period");
    expect_single(with("to_s: 4.5", "to_s: 3", text), "to_s: 3 ", "never, or always");
    expect_single(with("to_s: 4.5", "to_s: 3.01", text), "open { from_s: 3", "shorter than a tick");
    expect_single(with("to_s: 4.5", "", text), "open { from_s: 3", "an opening has an end");
    expect_single(with("to_s: 4.5", "to_s: 9", text), "open { from_s: 8", "overlaps");
    expect_single(with("from_s: 60 to_s: 120", "from_s: 0 to_s: 600", text),
                  "door {\n  name: \"shop\"",
                  "never shuts");
    expect_single(with("  open { from_s: 60 to_s: 120 }\n", "", text),
                  "door {\n  name: \"shop\"",
                  "never opens");
    expect_single(
        with("box { y_m: 1 }", "box { x_m: 5000 }", text), "box { x_m: 5000", "outside the world");
    expect_single(with("  box { y_m: 1 }\n", "", text), "door {\n  name: \"shop\"", "has a box");
    expect_single(with("name: \"shop\"", "", text), "door {\n  \n", "name");
}

TEST(PathfindingConfigs, NeedCellsThatFitTheZones) {
    std::string text = with("cell_m: 0.4", "cell_m: 0.1", kDoors + kValid);
    text = with("max_x_m: 100\n  max_z_m", "max_x_m: 1000\n  max_z_m", text);
    text = with("max_x_m: 100 max_z_m: 50 }", "max_x_m: 1000 max_z_m: 50 }", text);
    expect_single(text, "cell_m: 0.1", "zone 'east': 10044 x 1044 cells; a side has at most 8192");
    expect_single(with("cell_m: 0.4", "cell_m: 0", kDoors + kValid), "cell_m: 0 ", "out of range");
}

}  // namespace
}  // namespace zoned::config::test
