// Deformations in configs: where the control points lie, which fields they are, and mistakes.
#include "server/config/world/scatter.h"
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

world::EntityType deformed(const std::string& soft, const std::string& fields = "") {
    const Outcome out = parse(kValid + "type { name: \"deformed\" mass_kg: 5 " + fields +
                              " soft { " + soft + " } }\n");
    EXPECT_EQ(format_errors("test", out.errors), "");
    return out.settings.types[static_cast<std::size_t>(find_type(out.settings, "deformed"))];
}

std::string mistakes_of(const std::string& soft, const std::string& fields = "") {
    const Outcome out = parse(kValid + "type { name: \"deformed\" mass_kg: 5 " + fields +
                              " soft { " + soft + " } }\n");
    return out.ok ? "" : format_errors("test", out.errors);
}

using Points = std::array<std::uint32_t, 3>;

TEST(DeformationConfig, HasAControlPointForEachNodeWhereThoseAreFew) {
    const world::EntityType rope = deformed("rope { length_m: 3 nodes: 7 }");
    ASSERT_NE(rope.deformation, nullptr);
    EXPECT_EQ(rope.deformation->points, (Points{1, 7, 1}));
    EXPECT_EQ(deformed("jelly { size { x_m: 1 y_m: 0.5 z_m: 2 } }").deformation->points,
              (Points{4, 4, 4}));
}

TEST(DeformationConfig, SpreadsItsPointsAboutAsFarApartAlongAllAxes) {
    const auto sheet = "cloth { width_m: 4 height_m: 2 columns: 41 rows: 21 }";
    // 0.44 m and 0.4 m apart; one more along x would make 66.
    EXPECT_EQ(deformed(sheet).deformation->points, (Points{10, 6, 1}));
    EXPECT_EQ(deformed(std::string(sheet) + " deformation { points: 2 }").deformation->points,
              (Points{2, 1, 1}));
    EXPECT_EQ(deformed(std::string(sheet) + " deformation { sent: false }").deformation, nullptr);
}

TEST(DeformationConfig, ComesBehindTheFieldsOfTheGameAndInTheRoomThatTheyLeave) {
    const world::EntityType torn = deformed("cloth { } tear_strain: 0.5",
                                            "field { name: \"owner\" text { } } "
                                            "field { name: \"dry\" flag { } }");
    ASSERT_NE(torn.deformation, nullptr);
    EXPECT_EQ(torn.torn_field, 3);
    EXPECT_EQ(torn.first_control_point, 3);
    EXPECT_EQ(torn.fields->fields()[2].name, "torn");
    EXPECT_EQ(torn.fields->fields()[3].name, "control_point_0");
    EXPECT_EQ(torn.fields->fields().size(), 3U + torn.deformation->size());
    EXPECT_LE(torn.fields->fields().size(), wire::kMostDeclared);
    // Fifteen texts leave 8 of 128 words.
    std::string texts;
    for (int i = 0; i < 15; ++i) {
        texts += "field { name: \"t" + std::to_string(i) + "\" text { } } ";
    }
    const world::EntityType wordy = deformed("cloth { }", texts);
    ASSERT_NE(wordy.deformation, nullptr);
    EXPECT_LE(wordy.deformation->size(), 8U);
    EXPECT_EQ(wordy.fields->fields().size(), 15U + wordy.deformation->size());
    EXPECT_NE(mistakes_of("cloth { }", texts + "field { name: \"t15\" text { } } ").find("no room"),
              std::string::npos);
}

TEST(DeformationConfig, PromisesNoMoreThanItsStepsCanHold) {
    // A radius of 1.43 m: steps of 2.2 cm, whose rounding is off by 1.9 cm; twice that is the
    // least.
    const std::string sheet = "cloth { width_m: 2 height_m: 2 } deformation { bound_m: ";
    EXPECT_EQ(mistakes_of(sheet + "0.05 }"), "");
    EXPECT_NE(mistakes_of(sheet + "0.03 }").find("at least 0.0"), std::string::npos);
    EXPECT_NE(mistakes_of("cloth { }", "field { name: \"torn\" flag { } }").find("by themselves"),
              std::string::npos);
    EXPECT_NE(mistakes_of("cloth { }", "field { name: \"control_point_9\" flag { } }")
                  .find("by themselves"),
              std::string::npos);
}

}  // namespace
}  // namespace zoned::config::test
