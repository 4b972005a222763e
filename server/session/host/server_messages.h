// Server messages: builds the frames to clients from the messages of the zones and the host.
#pragma once

#include "server/mailbox/messages.h"
#include "proto/session.pb.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::session {

/// Serialises a message into a frame, without the length prefix.
[[nodiscard]] std::vector<std::uint8_t> serialise(const proto::ServerMessage& message);

/// The field Welcome.world, serialised: the same bytes for all clients.
[[nodiscard]] std::vector<std::uint8_t> world_field(const proto::WorldDescription& world);
/// The frame of a Welcome without its last `tail_bytes`, which are its field `world`.
[[nodiscard]] std::vector<std::uint8_t> welcome_head(const proto::Welcome& welcome,
                                                     std::size_t tail_bytes);

[[nodiscard]] std::vector<std::uint8_t> closing_frame(proto::ClosingReason reason,
                                                      const std::string& text,
                                                      const proto::Redirect* redirect = nullptr);
[[nodiscard]] std::vector<std::uint8_t> joined_frame(const mailbox::Joined& joined);
[[nodiscard]] std::vector<std::uint8_t> audit_frame(const mailbox::AuditRecord& record);
[[nodiscard]] std::vector<std::uint8_t> command_ack_frame(std::uint64_t through);
[[nodiscard]] std::vector<std::uint8_t> ahead_frame(const proto::Redirect& redirect);
/// A datagram that takes the stream because UDP does not get through.
[[nodiscard]] std::vector<std::uint8_t> datagram_frame(std::span<const std::uint8_t> sealed);

}  // namespace zoned::session
