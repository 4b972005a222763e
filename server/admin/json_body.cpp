#include "server/admin/json_body.h"

#include "shared/core/utf8.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <cstdint>
#include <string_view>

namespace zoned::admin {

namespace util = google::protobuf::util;

namespace {

bool is_utf8(std::string_view text) {
    std::uint32_t code = 0;
    while (!text.empty()) {
        const std::size_t bytes = core::decode_utf8(text, code);
        if (bytes == 0) {
            return false;
        }
        text.remove_prefix(bytes);
    }
    return true;
}

}  // namespace

std::string to_json(const google::protobuf::Message& message) {
    util::JsonPrintOptions options;
    options.add_whitespace = true;
    options.always_print_primitive_fields = true;
    options.preserve_proto_field_names = true;
    std::string text;
    // Only a message with broken well-known types fails, and the schema has none.
    if (!util::MessageToJsonString(message, &text, options).ok()) {
        text = "{}";
    }
    return text;
}

core::Result<bool> from_json(const std::string& text, google::protobuf::Message& out) {
    using Out = core::Result<bool>;
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
        return true;
    }
    if (!is_utf8(text)) {
        return Out::failure("the body is no UTF-8");
    }
    const auto status = util::JsonStringToMessage(text, &out);
    if (!status.ok()) {
        return Out::failure("the body is not the JSON that is expected here: " +
                            std::string(status.message()));
    }
    return true;
}

AdminResponse json_response(const google::protobuf::Message& message) {
    AdminResponse response;
    response.body = to_json(message);
    return response;
}

}  // namespace zoned::admin
