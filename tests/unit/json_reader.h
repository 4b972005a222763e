// JsonReader: reads JSON with a parser that is not ours, for the tests of our writers.
#pragma once

#include "tests/bench/report/json_fields.h"

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::json_text {

/// Fails the test when the text is no valid JSON object.
inline Struct parse(const std::string& text) {
    Struct out;
    const auto status = google::protobuf::util::JsonStringToMessage(text, &out);
    EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << text;
    return out;
}

/// The field's value, or null and a failed test.
inline Value field(const Struct& object, const std::string& name) {
    Value out;
    bool found = false;
    for_each_field(object, [&](const std::string& key, const Value& value) {
        if (key == name) {
            out = value;
            found = true;
        }
    });
    EXPECT_TRUE(found) << "no field " << name;
    return out;
}

inline std::vector<std::string> field_names(const Struct& object) {
    std::vector<std::string> names;
    for_each_field(object, [&](const std::string& key, const Value&) { names.push_back(key); });
    return names;
}

}  // namespace zoned::json_text
