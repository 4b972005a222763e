// JsonReader: reads JSON with a parser that is not ours, for the tests of our writers.
#pragma once

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace zoned::json_text {

using google::protobuf::Struct;
using google::protobuf::Value;

/// Fails the test when the text is no valid JSON object.
inline Struct parse(const std::string& text) {
    Struct out;
    const auto status = google::protobuf::util::JsonStringToMessage(text, &out);
    EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << text;
    return out;
}

/// Calls visit(name, value) for each field. It uses reflection, which runs inside the library:
/// under the thread sanitizer the library's headers lay maps out differently from the built
/// library.
inline void for_each_field(const Struct& object,
                           const std::function<void(const std::string&, const Value&)>& visit) {
    const auto* map = Struct::descriptor()->FindFieldByName("fields");
    const auto* reflection = object.GetReflection();
    for (int i = 0; i < reflection->FieldSize(object, map); ++i) {
        const auto& entry = reflection->GetRepeatedMessage(object, map, i);
        const auto* parts = entry.GetReflection();
        Value value;
        value.CopyFrom(parts->GetMessage(entry, entry.GetDescriptor()->map_value()));
        visit(parts->GetString(entry, entry.GetDescriptor()->map_key()), value);
    }
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
