#include "shared/core/hex.h"

#include <gtest/gtest.h>

namespace zoned::core {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Hex, WritesTwoLowerCaseDigitsForEachByte) {
    EXPECT_EQ(to_hex(Bytes{0x00, 0x0F, 0xA5, 0xFF}), "000fa5ff");
    EXPECT_EQ(to_hex({}), "");
}

TEST(Hex, ReadsDigitsOfEitherCase) {
    EXPECT_EQ(from_hex("000fA5Ff"), (Bytes{0x00, 0x0F, 0xA5, 0xFF}));
    EXPECT_EQ(from_hex(""), Bytes{});
}

TEST(Hex, RefusesWhatIsNoPairOfDigits) {
    for (const char* text : {"0", "0g", "g0", " 00", "0x", "00\n"}) {
        EXPECT_FALSE(from_hex(text)) << text;
    }
}

}  // namespace
}  // namespace zoned::core
