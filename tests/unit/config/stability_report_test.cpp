// The stability report: the warnings of the physics for each config, and none for a stable one.
#include "server/config/expand/stability_report.h"

#include "server/config/expand/load_settings.h"
#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>

namespace zoned::config {
namespace {

using test::parse;
using test::with;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(StabilityWarnings, SaysNothingOfOrdinaryConfigs) {
    EXPECT_THAT(stability_warnings_of(parse(test::kValid).settings), IsEmpty());
    for (const char* name : {"minimal", "valley"}) {
        Settings settings;
        std::vector<ConfigError> errors;
        ASSERT_TRUE(load_settings(
            std::string(ZONED_SOURCE_DIR "/config/") + name + ".txtpb", {}, settings, errors));
        EXPECT_THAT(stability_warnings_of(settings), IsEmpty()) << name;
    }
}

TEST(StabilityWarnings, NamesATinyType) {
    const auto out = parse(with("box { x_m: 1 y_m: 1 z_m: 1 }", "box { x_m: 1 y_m: 0.01 z_m: 1 }"));
    ASSERT_TRUE(out.ok);
    EXPECT_THAT(stability_warnings_of(out.settings),
                ElementsAre(HasSubstr("type 'crate': is 0.01 m thick, thinner than")));
}

TEST(StabilityWarnings, NamesAZoneThatReachesTooFarForTheErrorBudget) {
    // A zone's corner lies 50 m out; floats are a tenth of 1e-5 m apart up to 8.4 m.
    const auto out = parse(test::kValid, {"physics.error_budget_m=0.00001"});
    ASSERT_TRUE(out.ok);
    const auto warnings = stability_warnings_of(out.settings);
    EXPECT_THAT(warnings, ::testing::Contains(HasSubstr("zone 'west': its corner lies 50 m out")));
    EXPECT_THAT(warnings, ::testing::Contains(HasSubstr("zone 'east': its corner lies 50 m out")));
}

TEST(StabilityWarnings, NamesTheHeaviestPropOnTheLightest) {
    const std::string anvil =
        "type { name: \"anvil\" mass_kg: 1000000 box { x_m: 1 y_m: 1 z_m: 1 } }\n";
    const auto out = parse(with("type {\n  name: \"guard\"", anvil + "type {\n  name: \"guard\""));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_THAT(
        stability_warnings_of(out.settings),
        ElementsAre(HasSubstr("type 'anvil' on type 'crate': 1e+06 kg on 1 kg is too much")));
}

TEST(StabilityWarnings, NamesAStepThatIsTooLong) {
    // One kilogram on another gives by 2 g / (2 pi 30 / 8 per second)^2 = 35 mm.
    const auto out = parse(test::kValid, {"physics.substeps=1"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_THAT(stability_warnings_of(out.settings),
                ::testing::Contains(HasSubstr("physics: the step is too long for contacts")));
}

}  // namespace
}  // namespace zoned::config
