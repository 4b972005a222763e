// MessageAgreement: whether the client's codec and the protobuf library read the same from any
// bytes, and write the same again.
#pragma once

#include "proto/session.pb.h"
#include "shared/wire/session/session_messages.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::test {

/// Empty where both refuse the bytes, or both accept them and write the same bytes for what they
/// read; else the difference. Unknown fields are dropped, as the codec does.
template <class Message, class Proto>
[[nodiscard]] std::string disagreement(std::span<const std::uint8_t> bytes) {
    Proto theirs;
    Message ours;
    const bool they = theirs.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
    const bool we = wire::decode_message(bytes, ours);
    if (they != we) {
        return we ? "the codec reads what protobuf refuses"
                  : "protobuf reads what the codec refuses";
    }
    if (!they) {
        return {};
    }
    theirs.DiscardUnknownFields();
    std::vector<std::uint8_t> written;
    wire::encode_message(ours, written);
    return std::string(written.begin(), written.end()) == theirs.SerializeAsString()
               ? std::string()
               : "they read different things: " + theirs.ShortDebugString();
}

/// For each message that travels by itself.
[[nodiscard]] inline std::string any_disagreement(std::span<const std::uint8_t> bytes) {
    const std::string all[] = {
        disagreement<wire::ServerMessage, proto::ServerMessage>(bytes),
        disagreement<wire::ClientMessage, proto::ClientMessage>(bytes),
        disagreement<wire::SharedEnvironmentMessage, proto::SharedEnvironment>(bytes),
        disagreement<wire::ParticleBurstMessage, proto::ParticleBurst>(bytes)};
    for (const std::string& one : all) {
        if (!one.empty()) {
            return one;
        }
    }
    return {};
}

}  // namespace zoned::test
