// Report: JSON that an independent reader takes, and the fields that scripts rely on.
#include "server/recording/report.h"

#include "tests/unit/json_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

namespace zoned::recording {
namespace {

using json_text::field;
using json_text::Struct;
using json_text::Value;

TEST(Json, WritesEveryByteAsValidText) {
    for (int byte = 0; byte < 256; ++byte) {
        core::JsonWriter json;
        json.begin_object().field("k", std::string(1, static_cast<char>(byte))).end_object();
        const auto parsed = json_text::parse(json.text());
        if (byte < 128) {
            EXPECT_EQ(field(parsed, "k").string_value(), std::string(1, static_cast<char>(byte)));
        }
    }
}

TEST(Json, WritesNumbersThatReadBackTheSame) {
    for (const double number :
         {0.0, -1.5, 0.1, 1e-300, 1.7976931348623157e308, 33.333333333333336}) {
        core::JsonWriter json;
        json.begin_object().field("k", number).end_object();
        EXPECT_EQ(field(json_text::parse(json.text()), "k").number_value(), number);
    }
    core::JsonWriter json;
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
    const auto json = json_text::parse(to_json(report));
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
        EXPECT_NE(field(json, name).kind_case(), Value::KIND_NOT_SET) << name;
    }
    EXPECT_EQ(field(json, "ticks").number_value(), 900.0);
    EXPECT_EQ(field(json, "state_hash").string_value(), "0000000000abcdef");
    EXPECT_EQ(field(field(json, "rejected").struct_value(), "re\"play").number_value(), 1.0);
    const Struct zone = field(json, "zones").list_value().values(0).struct_value();
    EXPECT_EQ(field(zone, "state_hash").string_value(), "ffffffffffffffff");
    const Struct pass = field(json, "passes").list_value().values(0).struct_value();
    EXPECT_EQ(field(pass, "skip_reason").string_value(), "no viewer");
    EXPECT_EQ(field(pass, "ticks_skipped").number_value(), 3500.0);
}

}  // namespace
}  // namespace zoned::recording
