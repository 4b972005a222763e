// Display names: checks the texts from outside that are shown to players or put into messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace zoned::session {

inline constexpr std::size_t kMaxNameBytes = 32;

/// 1..32 bytes of clean UTF-8, not only spaces.
[[nodiscard]] bool is_valid_name(std::string_view name);

/// 0..32 bytes of clean UTF-8.
[[nodiscard]] bool is_valid_team(std::string_view team);

/// For messages: at most `max_bytes` of printable ASCII, everything else becomes '?'.
[[nodiscard]] std::string printable(std::string_view text, std::size_t max_bytes = 64);

}  // namespace zoned::session
