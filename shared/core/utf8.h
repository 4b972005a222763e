// UTF-8: decoding and checking of text from outside (RFC 3629).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace zoned::core {

/// Bytes of the well-formed sequence at the front of `text` (shortest form, no surrogate, up to
/// U+10FFFF), 0 when there is none; `code` receives the character.
[[nodiscard]] std::size_t decode_utf8(std::string_view text, std::uint32_t& code);

/// True for well-formed UTF-8 without control characters (C0, DEL, C1), which could play tricks on
/// a terminal or a log.
[[nodiscard]] bool is_clean_utf8(std::string_view text);

}  // namespace zoned::core
