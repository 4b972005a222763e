// UTF-8: well-formed and malformed texts.
#include "shared/core/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace zoned::core {
namespace {

std::string encode(std::uint32_t code) {
    const auto tail = [&](int shift) {
        return static_cast<char>(0x80u | ((code >> shift) & 0x3Fu));
    };
    if (code < 0x80) {
        return {static_cast<char>(code)};
    }
    if (code < 0x800) {
        return {static_cast<char>(0xC0u | (code >> 6)), tail(0)};
    }
    if (code < 0x10000) {
        return {static_cast<char>(0xE0u | (code >> 12)), tail(6), tail(0)};
    }
    return {static_cast<char>(0xF0u | (code >> 18)), tail(12), tail(6), tail(0)};
}

TEST(Utf8, DecodesEveryCharacterAndNoSurrogate) {
    for (std::uint32_t code = 0; code < 0x120000; ++code) {
        const std::string text = encode(code);
        std::uint32_t decoded = 0;
        const bool valid = code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
        ASSERT_EQ(decode_utf8(text, decoded), valid ? text.size() : 0) << code;
        if (valid) {
            ASSERT_EQ(decoded, code);
            // A sequence that is cut off is not a character.
            ASSERT_EQ(decode_utf8(text.substr(0, text.size() - 1), decoded), 0u);
        }
    }
}

TEST(Utf8, RefusesLongerFormsThanNeeded) {
    std::uint32_t code = 0;
    for (const char* text : {"\xC0\xAF", "\xC1\xBF", "\xE0\x9F\xBF", "\xF0\x8F\xBF\xBF", "\x80"}) {
        EXPECT_EQ(decode_utf8(text, code), 0u);
    }
}

TEST(Utf8, IsCleanWithoutControlCharacters) {
    EXPECT_TRUE(is_clean_utf8(""));
    EXPECT_TRUE(is_clean_utf8("Zo\xC3\xAB \xF0\x9F\x90\x91"));
    EXPECT_FALSE(is_clean_utf8("a\nb"));
    EXPECT_FALSE(is_clean_utf8("\x7F"));
    EXPECT_FALSE(is_clean_utf8("\xC2\x9B"));  // CSI, begins a terminal's control sequence
    EXPECT_FALSE(is_clean_utf8(std::string_view("\0", 1)));
    EXPECT_FALSE(is_clean_utf8("ok \xFF"));
}

}  // namespace
}  // namespace zoned::core
