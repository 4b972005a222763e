#include "server/rules/peer_messages.h"

#include <utility>

namespace zoned::rules {

namespace {

template <std::size_t I = 0>
std::optional<PeerMessage> decode_alternative(std::size_t index, ArchiveReader& reader) {
    if constexpr (I == std::variant_size_v<PeerMessage>) {
        return std::nullopt;
    } else {
        if (index != I) {
            return decode_alternative<I + 1>(index, reader);
        }
        std::variant_alternative_t<I, PeerMessage> message;
        std::variant_alternative_t<I, PeerMessage>::fields(reader, message);
        return reader.done() ? std::optional<PeerMessage>(message) : std::nullopt;
    }
}

}  // namespace

zone::Bytes encode(const PeerMessage& message) {
    zone::Bytes bytes;
    bytes.push_back(static_cast<std::uint8_t>(message.index()));
    Writer writer(bytes);
    std::visit([&](const auto& m) { m.fields(writer, m); }, message);
    return bytes;
}

std::optional<PeerMessage> decode(std::span<const std::uint8_t> payload) {
    if (payload.empty()) {
        return std::nullopt;
    }
    ArchiveReader reader(payload.subspan(1));
    return decode_alternative(payload.front(), reader);
}

}  // namespace zoned::rules
