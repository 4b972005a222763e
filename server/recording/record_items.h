// Record items: converts mailbox messages to and from their recorded form.
#pragma once

#include "server/mailbox/messages.h"
#include "proto/recording.pb.h"

namespace zoned::recording {

void to_record(const mailbox::InboxItem& item, proto::RecordedItem& out);

/// False when the record holds no item or a number that does not fit its field.
bool from_record(const proto::RecordedItem& record, mailbox::InboxItem& out);

}  // namespace zoned::recording
