#include "server/session/names.h"

#include <cstdint>

namespace zoned::session {

namespace {

/// Length of the well-formed sequence at `i`, 0 when there is none; `code` receives the character.
std::size_t decode(std::string_view text, std::size_t i, std::uint32_t& code) {
    const auto byte = [&](std::size_t k) {
        return static_cast<std::uint8_t>(text[k]);
    };
    const std::uint8_t first = byte(i);
    if (first < 0x80) {
        code = first;
        return 1;
    }
    std::size_t length = 0;
    std::uint32_t lowest = 0;  // below it, the sequence is longer than need be
    if ((first & 0xE0u) == 0xC0u) {
        length = 2;
        lowest = 0x80;
        code = first & 0x1Fu;
    } else if ((first & 0xF0u) == 0xE0u) {
        length = 3;
        lowest = 0x800;
        code = first & 0x0Fu;
    } else if ((first & 0xF8u) == 0xF0u) {
        length = 4;
        lowest = 0x10000;
        code = first & 0x07u;
    } else {
        return 0;
    }
    if (text.size() - i < length) {
        return 0;
    }
    for (std::size_t k = 1; k < length; ++k) {
        if ((byte(i + k) & 0xC0u) != 0x80u) {
            return 0;
        }
        code = (code << 6) | (byte(i + k) & 0x3Fu);
    }
    const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
    return code < lowest || code > 0x10FFFF || surrogate ? 0 : length;
}

}  // namespace

bool is_clean_utf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        std::uint32_t code = 0;
        const std::size_t length = decode(text, i, code);
        if (length == 0 || code < 0x20 || (code >= 0x7F && code < 0xA0)) {
            return false;
        }
        i += length;
    }
    return true;
}

bool is_valid_name(std::string_view name) {
    return !name.empty() && name.size() <= kMaxNameBytes && is_clean_utf8(name) &&
           name.find_first_not_of(' ') != std::string_view::npos;
}

bool is_valid_team(std::string_view team) {
    return team.size() <= kMaxNameBytes && is_clean_utf8(team);
}

std::string printable(std::string_view text, std::size_t max_bytes) {
    std::string out;
    for (const char c : text.substr(0, max_bytes)) {
        out.push_back(c >= 0x20 && c < 0x7F ? c : '?');
    }
    if (text.size() > max_bytes) {
        out += "...";
    }
    return out;
}

}  // namespace zoned::session
