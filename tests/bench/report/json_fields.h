// JsonFields: the fields of a JSON object that protobuf has parsed.
#pragma once

#include <google/protobuf/struct.pb.h>

#include <functional>
#include <string>

namespace zoned::json_text {

using google::protobuf::Struct;
using google::protobuf::Value;

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

}  // namespace zoned::json_text
