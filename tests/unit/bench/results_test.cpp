#include "tests/bench/results.h"

#include "tests/bench/plot.h"
#include "tests/unit/json_reader.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
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

TEST(ReportHtml, ShowsPicturesWithTheirCaptions) {
    Results results = example();
    results.pictures.push_back({"a", "doors <2>", "<svg id=\"own\"></svg>"});
    const std::string html = report_html(results);
    EXPECT_THAT(html, testing::HasSubstr("doors &lt;2&gt;"));
    EXPECT_THAT(html, testing::HasSubstr("<svg id=\"own\"></svg>"));
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

TEST(Report, DrawsRowsWithUpdatesAsCurvesOfEachMotion) {
    Results results;
    for (const char* motion : {"walk", "fall"}) {
        for (const double threshold : {0.01, 0.1}) {
            Row row;
            row.suite = "s";
            row.scene = "reckoning";
            row.parameter = "threshold=" + std::to_string(threshold) + " motion=" + motion;
            row.time_us_p50 = 1.0;
            row.error = threshold;
            row.error_unit = std::string("m");
            row.metric("updates_per_s", 1.0 / threshold);
            results.rows.push_back(row);
        }
    }
    const std::string html = report_html(results);
    EXPECT_THAT(html, testing::HasSubstr("<h2>s reckoning motion=walk</h2>"));
    EXPECT_THAT(html, testing::HasSubstr("<h2>s reckoning motion=fall</h2>"));
    EXPECT_THAT(html, testing::HasSubstr("publications a second"));
}

TEST(Report, DrawsRowsWithStepsAsCurvesThatLeaveOutWhatExploded) {
    Results results;
    for (const int steps : {10, 20, 40}) {
        Row row;
        row.suite = "s";
        row.scene = "motion";
        row.method = "a";
        row.parameter = "dt=" + std::to_string(1.0 / steps);
        row.time_us_p50 = 0.5;
        row.error = steps == 10 ? INFINITY : 1.0 / steps;
        row.error_unit = std::string("m");
        row.metric("steps_per_s", steps);
        results.rows.push_back(row);
    }
    const std::string html = report_html(results);
    EXPECT_NE(html.find("microseconds of a simulated second"), std::string::npos);
    const std::size_t from = html.find("points=\"") + 8;
    const std::string points = html.substr(from, html.find('"', from) - from);
    EXPECT_EQ(std::count(points.begin(), points.end(), ','), 2);
    EXPECT_EQ(html.find("<h2>s motion</h2>"), html.rfind("<h2>"));
}

}  // namespace
}  // namespace zoned::bench
