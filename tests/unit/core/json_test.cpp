// JsonWriter: escapes, numbers, nesting.
#include "shared/core/json.h"

#include <gtest/gtest.h>

namespace zoned::core {
namespace {

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

}  // namespace
}  // namespace zoned::core
