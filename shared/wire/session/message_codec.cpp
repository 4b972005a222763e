#include "shared/wire/session/message_codec.h"

namespace zoned::wire {

bool MessageDecoder::decode(std::span<const std::uint8_t> bytes, AnyMessage message, int deepest) {
    MessageReader reader(bytes);
    while (deepest >= 0 && !reader.done()) {
        MessageDecoder one{reader, reader.tag(), deepest};
        message.fields(message.message, one);
        if (!one.taken && reader.ok()) {
            reader.skip(one.tag, deepest);
        }
    }
    return deepest >= 0 && reader.ok();
}

bool MessageDecoder::has_room(std::size_t elements) {
    if (elements >= kMostElements) {
        in.fail();
    }
    return elements < kMostElements;
}

void MessageDecoder::nested(AnyMessage message) {
    taken = true;
    if (!decode(in.delimited(), message, deepest - 1)) {
        in.fail();
    }
}

}  // namespace zoned::wire
