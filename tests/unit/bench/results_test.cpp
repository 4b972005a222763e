#include "tests/bench/results.h"

#include "tests/bench/plot.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <limits>

namespace zoned::bench {
namespace {

using google::protobuf::Struct;
using google::protobuf::Value;

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

/// The JSON read by a parser that is not ours.
Struct parsed(const std::string& json) {
    Struct message;
    const auto status = google::protobuf::util::JsonStringToMessage(json, &message);
    EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << json;
    return message;
}

TEST(ToJson, IsReadByAnotherParserWithAllFields) {
    const Struct top = parsed(to_json(example()));
    EXPECT_EQ(top.fields().at("machine").string_value(), "a \"machine\"");
    EXPECT_EQ(top.fields().at("commit").string_value(), "abc");
    const auto& rows = top.fields().at("rows").list_value();
    ASSERT_EQ(rows.values_size(), 2);
    const auto& row = rows.values(0).struct_value().fields();
    std::vector<std::string> names;
    for (const auto& [name, value] : row) {
        names.push_back(name);
    }
    EXPECT_THAT(names,
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
    EXPECT_EQ(row.at("method").string_value(), "default");
    EXPECT_EQ(row.at("time_us_p50").number_value(), 12.5);
    EXPECT_EQ(row.at("metrics").struct_value().fields().at("drift_mean_m").number_value(), 0.125);
    EXPECT_EQ(rows.values(1).struct_value().fields().at("peer").string_value(), "bullet");
}

TEST(ToJson, WritesNullForWhatIsNotFinite) {
    const Struct top = parsed(to_json(example()));
    const auto& row = top.fields().at("rows").list_value().values(0).struct_value().fields();
    EXPECT_EQ(row.at("metrics").struct_value().fields().at("broken").kind_case(),
              Value::kNullValue);
}

TEST(ToTable, NamesPeersAndNotes) {
    const std::string table = to_table(example());
    EXPECT_THAT(table, testing::HasSubstr("bullet/default"));
    EXPECT_THAT(table, testing::HasSubstr("note: note <1>"));
}

TEST(ReportHtml, EscapesTextAndDrawsEveryRow) {
    const std::string html = report_html(example());
    EXPECT_THAT(html, testing::HasSubstr("note &lt;1&gt; &amp; so on"));
    std::size_t circles = 0;
    for (std::size_t at = html.find("<circle"); at != std::string::npos;
         at = html.find("<circle", at + 1)) {
        ++circles;
    }
    EXPECT_EQ(circles, 2u);
    EXPECT_THAT(html, testing::Not(testing::HasSubstr("nan")));
}

TEST(ScatterSvg, PlacesZeroErrorsOnTheLowerEdge) {
    const std::string svg =
        scatter_svg("", "", "", {{"zero", 10.0, 0.0, true}, {"one", 10.0, 1e-3, true}});
    EXPECT_THAT(svg, testing::HasSubstr("cy=\"350.0\""));
}

TEST(Report, DrawsRowsWithPassesAsOneCurvePerMethod) {
    Results results;
    for (const char* method : {"a", "b"}) {
        for (const int passes : {1, 10, 100}) {
            Row row;
            row.suite = "s";
            row.scene = "curve";
            row.method = method;
            row.parameter = "passes=" + std::to_string(passes);
            row.time_us_p50 = 2.0 * passes;
            row.error = 1.0 / passes;
            row.error_unit = std::string("m/s");
            row.metric("passes", passes);
            results.rows.push_back(row);
        }
    }
    const std::string html = report_html(results);
    std::size_t lines = 0;
    for (std::size_t at = html.find("<polyline"); at != std::string::npos;
         at = html.find("<polyline", at + 1)) {
        ++lines;
    }
    // Two methods, against time and against passes, under one heading.
    EXPECT_EQ(lines, 4U);
    EXPECT_EQ(html.find("<h2>s curve</h2>"), html.rfind("<h2>"));
}

}  // namespace
}  // namespace zoned::bench
