// Received: a message of the server's protobuf as the client's codec reads it from its bytes.
#pragma once

#include "shared/core/assert.h"
#include "shared/wire/session/message_codec.h"

namespace zoned::test {

template <class Message, class Sent>
[[nodiscard]] Message received(const Sent& sent) {
    Message message;
    const bool good = wire::decode_message(wire::bytes_of(sent.SerializeAsString()), message);
    ZONED_ASSERT(good, "both sides know the same messages");
    return message;
}

}  // namespace zoned::test
