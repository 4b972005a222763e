// Text check: is it UTF-8 that can be shown anywhere?
#pragma once

#include <string_view>

namespace zoned::rules {

/// True for well-formed UTF-8 (RFC 3629: shortest forms, no surrogates, up to U+10FFFF) without
/// control characters, which could play tricks on a terminal or a log.
bool is_plain_utf8(std::string_view text);

}  // namespace zoned::rules
