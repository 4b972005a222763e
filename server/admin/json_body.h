// JSON bodies of the admin interface, written and read by the schema in proto/admin.proto.
#pragma once

#include "server/admin/admin_request.h"
#include "shared/core/result.h"

#include <string>

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

namespace zoned::admin {

/// All fields, in the order of the schema, with the names of the schema.
[[nodiscard]] std::string to_json(const google::protobuf::Message& message);

/// Fails on anything but one JSON object with known fields of the right types; the text says what
/// is wrong. An empty text is an empty object.
core::Result<bool> from_json(const std::string& text, google::protobuf::Message& out);

/// The message as the body of an answer with status 200.
[[nodiscard]] AdminResponse json_response(const google::protobuf::Message& message);

}  // namespace zoned::admin
