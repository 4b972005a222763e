// Splines in a config: agents can follow them, and each mistake is found at its line.
#include "server/config/world/spline_config.h"

#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>

namespace zoned::config::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string kRoads = with("brain {\n  name: \"guard\"",
                                R"(track { name: "ring" closed: true width_m: 6 lanes: 3
  racing_line { margin_m: 1 }
  point { x_m: 20 z_m: 0 }
  point { x_m: 0 z_m: 20 }
  point { x_m: -20 z_m: 0 }
  point { x_m: 0 z_m: -20 }
}
track { name: "road" curve: B_SPLINE
  point { x_m: -20 z_m: 30 }
  point { x_m: 20 z_m: 30 }
}
brain {
  name: "driver"
  state { name: "drive" action: FOLLOW_TRACK
    follow { choice { track: "ring" weight: 2 }
      choice { track: "road" lane: 0 backwards: true }
      choice { track: "ring" racing_line: true }
      blend_m: 5 change_every_m: 40
    }
  }
}
brain {
  name: "guard")",
                                with("brain: \"guard\"", "brain: \"driver\""));

std::string roads_with(const std::string& from, const std::string& to) {
    return with(from, to, kRoads);
}

TEST(TracksInConfigs, AreBuiltAsWritten) {
    const Outcome out = parse(kRoads);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::splines::SplineNetwork& net = *out.settings.ai.points_of_interest.tracks;
    ASSERT_EQ(net.lanes(), 2U * 4U + 2U);
    const ai::FollowDef& follow = *out.settings.ai.brains[0].states[0].follow;
    ASSERT_EQ(follow.draws.size(), 3U);
    EXPECT_EQ(follow.draws[0].count, 3);
    EXPECT_EQ(follow.draws[0].weight, 2.0F);
    EXPECT_EQ(net.name(follow.draws[0].first), "ring, lane 0 of 3");
    EXPECT_EQ(follow.draws[1].count, 1);
    EXPECT_EQ(net.name(follow.draws[1].first), "road, lane 0 of 1, backwards");
    EXPECT_EQ(net.name(follow.draws[2].first), "ring, racing line");
    EXPECT_EQ(follow.blend_m, 5.0F);
    EXPECT_EQ(follow.change_every_m, 40.0F);
    EXPECT_THAT(track_warnings(out.settings), IsEmpty());
}

TEST(MistakesInTracks, AreFoundWhereTheyAre) {
    expect_single(
        roads_with("track: \"road\"", "track: \"raod\""), "track: \"raod\"", "no track named");
    expect_single(roads_with("lane: 0", "lane: 1"), "lane: 1", "there are 1 lanes");
    const std::string two =
        with("  point { x_m: 0 z_m: 20 }\n", "", roads_with("  point { x_m: -20 z_m: 0 }\n", ""));
    expect_single(two, "track { name: \"ring\"", "from 3 to 100000 points, not 2");
    expect_single(roads_with("x_m: -20 z_m: 30", "x_m: -120 z_m: 30"),
                  "point { x_m: -120",
                  "outside the world");
    expect_single(roads_with("width_m: 6", "width_m: 60"), "point { x_m: 20 z_m: 0", "bends with");
    expect_single(roads_with("margin_m: 1", "margin_m: 4"), "racing_line {", "half of width_m");
    expect_single(roads_with("curve: B_SPLINE", "racing_line { }"), "racing_line { }", "closed");
    expect_single(with("choice { track: \"road\"",
                       "choice { track: \"ring\"",
                       roads_with("name: \"road\"", "name: \"ring\"")),
                  "name: \"ring\" curve",
                  "name of another track");
    expect_single(roads_with("racing_line: true", "racing_line: true lane: 1"),
                  "lane: 1",
                  "either a lane or");
    expect_single(roads_with("action: FOLLOW_TRACK", "action: FOLLOW_TRACK speed_factor: -1"),
                  "speed_factor: -1",
                  "out of range");
    expect_single(
        roads_with("action: FOLLOW_TRACK", "action: IDLE"), "follow {", "FOLLOW_TRACK alone");
    EXPECT_TRUE(
        parse(roads_with("action: FOLLOW_TRACK", "action: FOLLOW_TRACK rubber_band { rivals: 3 }"))
            .ok);
    expect_single(roads_with("action: CHASE", "action: CHASE rubber_band { rivals: 3 }"),
                  "rivals: 3",
                  "FOLLOW_TRACK alone");
}

std::vector<std::string> warnings_of(const std::string& text) {
    const Outcome out = parse(text);
    EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
    return out.ok ? track_warnings(out.settings) : std::vector<std::string>{};
}

TEST(WarningsOfTracks, NameWhatCannotWork) {
    EXPECT_THAT(warnings_of(roads_with("width_m: 6 lanes: 3", "width_m: 2.1 lanes: 3")),
                testing::Contains(HasSubstr("0.8 m wide on a lane of 0.7 m")));
    // In a ring of 20 m at 25 m/s: 31 m/s2.
    EXPECT_THAT(warnings_of(with(
                    "brain: \"driver\"", "brain: \"driver\" character { speed_mps: 25 }", kRoads)),
                testing::Contains(HasSubstr("it will leave its lane there")));
    const std::string box =
        "statics { box { x_m: 0 y_m: 1 z_m: 30 size { x_m: 2 y_m: 2 z_m: 2 } } }\n";
    EXPECT_THAT(warnings_of(box + kRoads),
                testing::Contains(HasSubstr("road, lane 0 of 1, backwards: something stands in its "
                                            "way at 1.")));
    // Over a kerb, and on a broad deck, it goes.
    const std::string kerb =
        "statics { box { x_m: 0 y_m: 0.1 z_m: 30 size { x_m: 2 y_m: 0.2 z_m: 2 } } }\n";
    EXPECT_THAT(warnings_of(kerb + kRoads), IsEmpty());
}

}  // namespace
}  // namespace zoned::config::test
