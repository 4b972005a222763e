#include "shared/core/utf8.h"

namespace zoned::core {

std::size_t decode_utf8(std::string_view text, std::uint32_t& code) {
    const auto byte = [&](std::size_t i) {
        return static_cast<std::uint8_t>(text[i]);
    };
    if (text.empty()) {
        return 0;
    }
    const std::uint8_t first = byte(0);
    if (first < 0x80) {
        code = first;
        return 1;
    }
    // 0xC0 and 0xC1 would begin longer forms of what one byte says, 0xF5 and above lie beyond the
    // last character.
    if (first < 0xC2 || first > 0xF4) {
        return 0;
    }
    const std::size_t length = first >= 0xF0 ? 4 : (first >= 0xE0 ? 3 : 2);
    if (text.size() < length) {
        return 0;
    }
    code = first & (0x7Fu >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0u) != 0x80u) {
            return 0;
        }
        code = (code << 6) | (byte(i) & 0x3Fu);
    }
    constexpr std::uint32_t kShortest[5] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
    return code < kShortest[length] || code > 0x10FFFF || surrogate ? 0 : length;
}

bool is_clean_utf8(std::string_view text) {
    while (!text.empty()) {
        std::uint32_t code = 0;
        const std::size_t length = decode_utf8(text, code);
        if (length == 0 || code < 0x20 || (code >= 0x7F && code < 0xA0)) {
            return false;
        }
        text.remove_prefix(length);
    }
    return true;
}

}  // namespace zoned::core
