// Frequent records: the messages that every player sends in every tick, written in protobuf's wire
// format without the detour over protobuf's objects.
#pragma once

#include "server/mailbox/messages.h"

#include <string>

namespace zoned::recording {

/// Appends the item as an entry of RecordedInputs.items, byte for byte as protobuf would (Protocol
/// Buffers Documentation, "Encoding"). False, and nothing is appended: it is none of the frequent
/// kinds (inputs, acknowledgements, progress of sessions).
bool append_frequent_record(const mailbox::InboxItem& item, std::string& out);

}  // namespace zoned::recording
