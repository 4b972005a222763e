// Declared fields of types: what the config says becomes their schema, and mistakes are named.
#include "server/config/expand/load_settings.h"
#include "server/config/settings.h"
#include "server/config/world/world_description.h"
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

const std::string kCrate = "aura_m { normal: 50 }\n}\ntype {\n  name: \"guard\"";

std::string with_fields(const std::string& fields) {
    return with(kCrate, "aura_m { normal: 50 }\n" + fields + "}\ntype {\n  name: \"guard\"");
}

TEST(DeclaredFields, AreExpandedWithTheirRangesAndInitialValues) {
    const Outcome out = parse(with_fields(R"(
  field { name: "fuel" number { min: -1 max: 1 quantum: 0.1 initial: 0.3 } max_changes_per_s: 7 }
  field { name: "mode" choice { value: "off" value: "on" initial: "on" } }
  field { name: "locked" flag { initial: true } }
  field { name: "label" text { initial: "Kiste" } }
)"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.types[0].fields, nullptr);
    ASSERT_NE(out.settings.types[1].fields, nullptr);
    const wire::FieldSchema& schema = *out.settings.types[1].fields;
    ASSERT_EQ(schema.fields().size(), 4U);
    const wire::DeclaredField& fuel = schema.fields()[0];
    EXPECT_EQ(fuel.most, 20U);
    EXPECT_EQ(fuel.bits, 5);
    EXPECT_EQ(fuel.interval, 5);  // 30 ticks a second
    const auto initial = [&](std::size_t i) {
        return wire::text_of(schema.fields()[i],
                             wire::words_of(schema.fields()[i], schema.initial()));
    };
    EXPECT_EQ(initial(0), "0.3");
    EXPECT_EQ(initial(1), "on");
    EXPECT_EQ(initial(2), "true");
    EXPECT_EQ(initial(3), "Kiste");
    EXPECT_EQ(schema.fields()[1].interval, 0);
    EXPECT_EQ(schema.words(), 3U + wire::kTextWords);
}

TEST(DeclaredFields, AreTakenFromABaseUnlessTheTypeHasItsOwn) {
    const Outcome out =
        parse(with_fields("  field { name: \"fuel\" number { } }\n") +
              "type { name: \"barrel\" base: \"crate\" }\n"
              "type { name: \"keg\" base: \"crate\" field { name: \"beer\" flag { } } }\n");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.types[3].fields->fields()[0].name, "fuel");
    EXPECT_EQ(out.settings.types[4].fields->fields()[0].name, "beer");
    EXPECT_EQ(out.settings.types[4].fields->fields().size(), 1U);
}

struct FieldMistake {
    std::string field;
    std::string needle;
    std::string words;
};

class WrongField : public testing::TestWithParam<FieldMistake> {};

TEST_P(WrongField, IsReportedAtItsPlace) {
    expect_single(with_fields("  " + GetParam().field + "\n"), GetParam().needle, GetParam().words);
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes,
    WrongField,
    testing::Values(
        FieldMistake{"field { name: \"fuel\" }", "field { name", "needs its kind"},
        FieldMistake{"field { flag { } }", "field {", "needs a name"},
        FieldMistake{"field { name: \"a b\" flag { } }", "name: \"a b\"", "name"},
        FieldMistake{"field { name: \"fuel\" flag { } } field { name: \"fuel\" flag { } }",
                     "name: \"fuel\" flag { } }\n",
                     "another field of this type"},
        FieldMistake{"field { name: \"fuel\" number { min: 5 max: 5 } }", "max: 5", "not above"},
        FieldMistake{"field { name: \"fuel\" number { max: 1 quantum: 0.3 } }",
                     "quantum: 0.3",
                     "into whole steps"},
        FieldMistake{"field { name: \"fuel\" number { max: 1000 quantum: 0.00001 } }",
                     "quantum: 0.00001",
                     "at most 16777215"},
        FieldMistake{"field { name: \"fuel\" number { initial: 101 } }",
                     "initial: 101",
                     "outside the range"},
        FieldMistake{"field { name: \"mode\" choice { value: \"a\" } }", "choice {", "2 to 256"},
        FieldMistake{"field { name: \"mode\" choice { value: \"a\" value: \"\" } }",
                     "value: \"\"",
                     "1..32"},
        FieldMistake{"field { name: \"mode\" choice { value: \"a\" value: \"a\" } }",
                     "value: \"a\" } }",
                     "another value"},
        FieldMistake{"field { name: \"mode\" choice { value: \"a\" value: \"b\" initial: \"c\" } }",
                     "initial: \"c\"",
                     "there is no value 'c'"},
        FieldMistake{
            "field { name: \"label\" text { initial: \"0123456789012345678901234567890X\" } }",
            "initial: \"0",
            "31"},
        FieldMistake{"field { name: \"label\" text { initial: \"a\\001\" } }",
                     "initial: \"a",
                     "UTF-8"},
        FieldMistake{"field { name: \"fuel\" number { } max_changes_per_s: 2000 }",
                     "max_changes_per_s",
                     "1000"}));

TEST(DeclaredFields, AreAtMostSixtyFourOfAType) {
    std::string many;
    for (int i = 0; i < 65; ++i) {
        many += "  field { name: \"f" + std::to_string(i) + "\" flag { } }\n";
    }
    const Outcome out = parse(with_fields(many));
    ASSERT_FALSE(out.ok);
    EXPECT_NE(format_errors("test", out.errors).find("64"), std::string::npos)
        << format_errors("test", out.errors);
}

TEST(DeclaredFields, HaveRoomForSixteenTexts) {
    std::string texts;
    for (int i = 0; i < 16; ++i) {
        texts += "  field { name: \"t" + std::to_string(i) + "\" text { } }\n";
    }
    EXPECT_TRUE(parse(with_fields(texts)).ok);
    const Outcome out = parse(with_fields(texts + "  field { name: \"f\" flag { } }\n"));
    ASSERT_FALSE(out.ok);
    EXPECT_NE(format_errors("test", out.errors).find("129 words"), std::string::npos)
        << format_errors("test", out.errors);
}

}  // namespace
}  // namespace zoned::config::test
