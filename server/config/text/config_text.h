// config_text: parses protobuf text format into a Config or another message, and reports every
// mistake in the text itself.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace zoned::config {

/// Parses `text` into `config` and records the place of each setting. Unknown fields are skipped,
/// values of the wrong type or given twice are blanked and reported, so that one run finds them
/// all. False when the parser could not get to the end of the text. The rest is then unknown, and
/// relations between settings cannot be checked.
bool parse_config_text(const std::string& text,
                       google::protobuf::Message& config,
                       Diagnostics& diagnostics);

/// Nearest of the message's field names, or empty when none is similar: for "did you mean".
std::string similar_field(const google::protobuf::Descriptor& message, const std::string& name);

/// End of the error about a field that the message lacks: "; it is called 'x' now", "; did you mean
/// 'x'?" or nothing.
std::string advice_on(const google::protobuf::Descriptor& message, const std::string& name);

}  // namespace zoned::config
