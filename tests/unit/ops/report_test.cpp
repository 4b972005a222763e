// Report and JSON: escapes, numbers, nesting, and the fields that scripts rely on.
#include "server/ops/report.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

namespace zoned::ops {
namespace {

/// Parsed by an independent reader; fails the test when it is no valid JSON.
google::protobuf::Struct parse_json(const std::string& text) {
    google::protobuf::Struct out;
    const auto status = google::protobuf::util::JsonStringToMessage(text, &out);
    EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << text;
    return out;
}

TEST(Json, EscapesWhatTextMayHold) {
    EXPECT_EQ(json_quote("plain"), "\"plain\"");
    EXPECT_EQ(json_quote("a\"b\\c"), "\"a\\\"b\\\\c\"");
    EXPECT_EQ(json_quote("\n\r\t\x01\x7F"), "\"\\n\\r\\t\\u0001\\u007f\"");
    EXPECT_EQ(json_quote(std::string("\0", 1)), "\"\\u0000\"");
    EXPECT_EQ(json_quote("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x90\x91"),
              "\"\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x90\x91\"");
}

TEST(Json, ReplacesBytesThatAreNotUtf8) {
    const std::string mark = "\xEF\xBF\xBD";
    EXPECT_EQ(json_quote("\xFF"), "\"" + mark + "\"");
    EXPECT_EQ(json_quote("a\xC3"), "\"a" + mark + "\"") << "cut off";
    EXPECT_EQ(json_quote("\xC0\x80"), "\"" + mark + mark + "\"") << "overlong zero";
    EXPECT_EQ(json_quote("\xED\xA0\x80"), "\"" + mark + mark + mark + "\"") << "surrogate";
    EXPECT_EQ(json_quote("\xF4\x90\x80\x80"), "\"" + mark + mark + mark + mark + "\"") << "too big";
}

TEST(Json, WritesEveryByteAsValidText) {
    for (int byte = 0; byte < 256; ++byte) {
        JsonWriter json;
        json.begin_object().field("k", std::string(1, static_cast<char>(byte))).end_object();
        const auto parsed = parse_json(json.text());
        if (byte < 128) {
            EXPECT_EQ(parsed.fields().at("k").string_value(),
                      std::string(1, static_cast<char>(byte)));
        }
    }
}

TEST(Json, WritesNumbersThatReadBackTheSame) {
    for (const double number :
         {0.0, -1.5, 0.1, 1e-300, 1.7976931348623157e308, 33.333333333333336}) {
        JsonWriter json;
        json.begin_object().field("k", number).end_object();
        EXPECT_EQ(parse_json(json.text()).fields().at("k").number_value(), number);
    }
    JsonWriter json;
    json.begin_array()
        .value(std::numeric_limits<double>::infinity())
        .value(std::numeric_limits<double>::quiet_NaN())
        .value(UINT64_MAX)
        .value(INT64_MIN)
        .value(true)
        .end_array();
    EXPECT_EQ(json.text(),
              "[\n  null,\n  null,\n  18446744073709551615,\n  -9223372036854775808,\n  true\n]");
}

TEST(Json, NestsWithCommasWhereTheyBelong) {
    JsonWriter json;
    json.begin_object()
        .field("a", 1)
        .key("b")
        .begin_array()
        .begin_object()
        .end_object()
        .value("x")
        .end_array()
        .key("c")
        .begin_object()
        .end_object()
        .end_object();
    EXPECT_EQ(json.text(), "{\n  \"a\": 1,\n  \"b\": [\n    {},\n    \"x\"\n  ],\n  \"c\": {}\n}");
}

TEST(Percentiles, AreNearestRank) {
    std::vector<double> samples;
    for (int i = 1000; i >= 1; --i) {
        samples.push_back(i);
    }
    const Percentiles p = percentiles_of(samples);
    EXPECT_EQ(p.p50, 500.0);
    EXPECT_EQ(p.p99, 990.0);
    EXPECT_EQ(p.p999, 999.0);
    EXPECT_EQ(p.max, 1000.0);
    std::vector<double> one = {3.0};
    EXPECT_EQ(percentiles_of(one).p50, 3.0);
    std::vector<double> none;
    EXPECT_EQ(percentiles_of(none).max, 0.0);
}

TEST(ServerReport, HoldsTheFieldsThatScriptsRelyOn) {
    ServerReport report;
    report.world = "valley";
    report.ticks = 900;
    report.tick_ms = {1.0, 2.0, 3.0, 4.0};
    report.overruns = 2;
    report.overruns_by_reason = {{"descheduled", 2}};
    report.rejected = {{"bad seal", 3}, {"re\"play", 1}};
    report.state_hash = 0xABCDEF;
    report.extra = {{"view_resets", 1.0}};
    report.zones = {{"x0z0", 625, 0xFFFFFFFFFFFFFFFFull}};
    report.passes = {{"interest", 4, 100, 3500, 12.5, 77, "no viewer"}};
    const auto json = parse_json(to_json(report));
    for (const char* name : {"ticks",
                             "tick_ms_p50",
                             "tick_ms_p99",
                             "tick_ms_p999",
                             "tick_ms_max",
                             "tick_cpu_ms_p99",
                             "overruns",
                             "entities",
                             "awake_bodies",
                             "sessions_max",
                             "packets_in",
                             "packets_out",
                             "bytes_in",
                             "bytes_out",
                             "rejected",
                             "handoffs",
                             "state_hash",
                             "view_resets"}) {
        EXPECT_EQ(json.fields().count(name), 1u) << name;
    }
    EXPECT_EQ(json.fields().at("ticks").number_value(), 900.0);
    EXPECT_EQ(json.fields().at("state_hash").string_value(), "0000000000abcdef");
    EXPECT_EQ(json.fields().at("rejected").struct_value().fields().at("re\"play").number_value(),
              1.0);
    const auto& zone = json.fields().at("zones").list_value().values(0).struct_value();
    EXPECT_EQ(zone.fields().at("state_hash").string_value(), "ffffffffffffffff");
    const auto& pass = json.fields().at("passes").list_value().values(0).struct_value();
    EXPECT_EQ(pass.fields().at("skip_reason").string_value(), "no viewer");
    EXPECT_EQ(pass.fields().at("ticks_skipped").number_value(), 3500.0);
}

TEST(ServerReport, IsWrittenToItsFileOrSaysWhyNot) {
    const std::string file = testing::TempDir() + "zoned_report.json";
    ASSERT_TRUE(write_report(file, ServerReport{}).ok());
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    EXPECT_EQ(text.str(), to_json(ServerReport{}));
    std::remove(file.c_str());
    const auto failed = write_report("/nonexistent/report.json", ServerReport{});
    ASSERT_FALSE(failed.ok());
    EXPECT_THAT(failed.error(), testing::HasSubstr("No such file"));
}

}  // namespace
}  // namespace zoned::ops
