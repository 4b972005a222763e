// World warnings: what a good config most likely does not mean, and silence about what it may.
#include "server/config/expand/world_warnings.h"

#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>

namespace zoned::config {
namespace {

using test::parse;
using test::with;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The tests' own config, whose guard nobody hears, with an aura for it.
std::string heard(const std::string& text = test::kValid) {
    return with("  brain: \"guard\"\n", "  brain: \"guard\"\n  aura_m { normal: 50 }\n", text);
}

std::vector<std::string> warnings_of(const std::string& text) {
    const auto out = parse(text);
    EXPECT_TRUE(out.ok) << format_errors("test", out.errors);
    return world_warnings_of(out.settings);
}

TEST(WorldWarnings, NamesATypeThatNobodyHears) {
    EXPECT_THAT(warnings_of(test::kValid), ElementsAre(HasSubstr("type 'guard': it has no aura")));
    EXPECT_THAT(warnings_of(heard()), IsEmpty());
}

TEST(WorldWarnings, SaysNothingOfTheWorldsThatComeWithTheServer) {
    for (const char* name : {"minimal", "valley", "hills", "machines"}) {
        Settings settings;
        std::vector<ConfigError> errors;
        ASSERT_TRUE(load_settings(
            std::string(ZONED_SOURCE_DIR "/config/") + name + ".txtpb", {}, settings, errors));
        EXPECT_THAT(world_warnings_of(settings), IsEmpty()) << name;
    }
}

/// The hills of the config folder, so high above the ground at their edges.
std::string with_hills(double offset_m) {
    return heard() +
           "statics { surface { file: \"" ZONED_SOURCE_DIR
           "/config/geometry/hills.png\" x_m: 50 height_m: 12 spacing_m: 0.5 offset_m: " +
           std::to_string(offset_m) + " } }\n";
}

TEST(WorldWarnings, NamesAHeightfieldThatEndsInAStep) {
    EXPECT_THAT(warnings_of(with_hills(3.0)),
                ElementsAre(testing::AllOf(HasSubstr("hills.png): its edge stands "),
                                           HasSubstr(" m above the ground at x "))));
    EXPECT_THAT(warnings_of(with_hills(-20.0)), IsEmpty());
}

TEST(WorldWarnings, NamesACharacterThatIsStoppedFasterThanPromised) {
    const auto with_speed = [](const std::string& speed) {
        return with("  nimbus_m { normal: 50 }\n",
                    "  nimbus_m { normal: 50 }\n  character { speed_mps: " + speed + " }\n",
                    heard());
    };
    EXPECT_THAT(warnings_of(with_speed("9")), IsEmpty());
    EXPECT_THAT(warnings_of(with_speed("30")),
                ElementsAre(HasSubstr("a wall stops it at once from 48 m/s")));
    // A lift of 10 m in two seconds.
    EXPECT_THAT(
        warnings_of(with_speed("9") + "platform { name: \"lift\" box { x_m: 20 y_m: 0.5 z_m: 20 "
                                      "size { x_m: 4 y_m: 1 z_m: 4 } } "
                                      "stop { x_m: 20 y_m: 10.5 z_m: 20 } speed_mps: 5 }\n"),
        testing::Contains(HasSubstr("from 19.4 m/s")));
}

TEST(WorldWarnings, NamesAFallThatTheWireCannotCarry) {
    EXPECT_THAT(warnings_of(heard() +
                            "statics { box { x_m: 20 y_m: 50 z_m: 0 size { x_m: 4 y_m: 100 z_m: 4 "
                            "} } }\nreplication { quantization { max_speed_mps: 20 } }\n"),
                ElementsAre(HasSubstr("a fall from the highest static ends at 4")));
}

}  // namespace
}  // namespace zoned::config
