#include "tests/bench/results.h"

#include "tests/unit/json_reader.h"

#include <gmock/gmock.h>

#include <limits>

namespace zoned::bench {
namespace {

using json_text::field;

Results example() {
    Results results;
    results.machine = "a \"machine\"";
    results.commit = "abc";
    results.build = "here";
    results.notes.push_back("note <1> & so on");
    Row row;
    row.suite = "physics";
    row.scene = "S1";
    row.time_us_p50 = 12.5;
    row.time_us_p99 = 13.5;
    row.error = 0.25;
    row.error_unit = "m";
    row.metric("drift_mean_m", 0.125);
    row.metric("broken", std::numeric_limits<double>::quiet_NaN());
    results.rows.push_back(row);
    row.peer = "bullet";
    row.error = 0.0;
    results.rows.push_back(row);
    return results;
}

TEST(ToJson, IsReadByAnotherParserWithAllFields) {
    const json_text::Struct top = json_text::parse(to_json(example()));
    EXPECT_EQ(field(top, "machine").string_value(), "a \"machine\"");
    EXPECT_EQ(field(top, "commit").string_value(), "abc");
    const auto rows = field(top, "rows").list_value();
    ASSERT_EQ(rows.values_size(), 2);
    const json_text::Struct row = rows.values(0).struct_value();
    EXPECT_THAT(json_text::field_names(row),
                testing::UnorderedElementsAre("suite",
                                              "scene",
                                              "method",
                                              "parameter",
                                              "time_us_p50",
                                              "time_us_p99",
                                              "error",
                                              "error_unit",
                                              "metrics",
                                              "peer",
                                              "state_hash"));
    EXPECT_EQ(field(row, "method").string_value(), "default");
    EXPECT_EQ(field(row, "time_us_p50").number_value(), 12.5);
    EXPECT_EQ(field(field(row, "metrics").struct_value(), "drift_mean_m").number_value(), 0.125);
    EXPECT_EQ(field(rows.values(1).struct_value(), "peer").string_value(), "bullet");
}

TEST(ToJson, WritesNullForWhatIsNotFinite) {
    const json_text::Struct top = json_text::parse(to_json(example()));
    const json_text::Struct row = field(top, "rows").list_value().values(0).struct_value();
    EXPECT_EQ(field(field(row, "metrics").struct_value(), "broken").kind_case(),
              json_text::Value::kNullValue);
}

TEST(ToTable, NamesPeersAndNotes) {
    const std::string table = to_table(example());
    EXPECT_THAT(table, testing::HasSubstr("bullet/default"));
    EXPECT_THAT(table, testing::HasSubstr("note: note <1>"));
}

}  // namespace
}  // namespace zoned::bench
