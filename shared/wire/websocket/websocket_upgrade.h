// WebSocketUpgrade: the HTTP request and answer with which a WebSocket begins (RFC 6455, section
// 4).
#pragma once

#include "shared/core/result.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace zoned::wire {

/// Name of the protocol that both ends speak inside (Sec-WebSocket-Protocol).
inline constexpr std::string_view kWebSocketProtocol = "zoned";
/// Longest request or answer, the empty line at its end included.
inline constexpr std::size_t kMaxUpgradeBytes = 8192;

/// A request's contents; all of it is the client's word.
struct UpgradeRequest {
    std::string host;
    std::string origin;      ///< empty: no browser asks
    std::string key;         ///< Sec-WebSocket-Key
    bool forwarded = false;  ///< a proxy says that it passes on what another machine sent
};

/// The reason for a refusal: the status of the answer, a name for counters, a text.
struct UpgradeRefusal {
    unsigned status = 400;
    std::string_view reason = "upgrade_malformed";
    std::string_view text;
};

/// Length of the request or answer at the front of `bytes`, its empty line included; 0: the empty
/// line has not come.
[[nodiscard]] std::size_t upgrade_length(std::string_view bytes);

/// Reads a whole request for the path "/".
[[nodiscard]] core::Result<UpgradeRequest, UpgradeRefusal> read_upgrade_request(
    std::string_view text);

/// The answer that takes the request.
[[nodiscard]] std::string upgrade_answer(const std::string& key);
/// The answer that refuses it, with the reason as text.
[[nodiscard]] std::string refusal_answer(const UpgradeRefusal& refusal);

/// The request of a client; `key` is 16 random bytes in base64.
[[nodiscard]] std::string upgrade_request(const std::string& host, const std::string& key);
/// Empty: the answer takes the request that was made with this key. Else why it does not.
[[nodiscard]] std::string check_upgrade_answer(std::string_view text, const std::string& key);

/// Base64 of RFC 4648, with padding.
[[nodiscard]] std::string to_base64(std::string_view bytes);

}  // namespace zoned::wire
