#include "shared/wire/bit_stream.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <utility>

namespace zoned::wire {
namespace {

TEST(BitStream, GivesBackRandomSequencesOfAllWidths) {
    core::Rng rng(1);
    for (int round = 0; round < 2'000; ++round) {
        std::vector<std::pair<std::uint32_t, int>> items;
        BitWriter writer;
        int total = 0;
        for (;;) {
            const int bits = static_cast<int>(rng.below(33));
            if (total + bits > 120 * 8) {
                break;
            }
            total += bits;
            items.emplace_back(rng.next() & low_mask(bits), bits);
            writer.write(items.back().first, bits);
        }
        std::vector<std::uint8_t> bytes{0xAB};
        writer.finish(bytes);
        ASSERT_EQ(bytes.size(), 1u + static_cast<std::size_t>(total + 7) / 8);
        ASSERT_EQ(bytes[0], 0xAB) << "finish appends";
        BitReader reader{std::span(bytes).subspan(1)};
        for (const auto& [value, bits] : items) {
            ASSERT_EQ(reader.read(bits), value);
        }
        reader.align();
        EXPECT_FALSE(reader.failed());
        EXPECT_TRUE(reader.at_end());
    }
}

TEST(BitStream, PutsTheFirstBitIntoTheLowestBitOfTheFirstByte) {
    BitWriter writer;
    writer.write(1, 1);
    writer.write(0b10, 2);
    writer.write(0xFFFFFFFFu, 9);
    std::vector<std::uint8_t> bytes;
    writer.finish(bytes);
    EXPECT_EQ(bytes, (std::vector<std::uint8_t>{0xFD, 0x0F}));
}

TEST(BitReader, FailsForGoodAndGivesZerosPastTheEnd) {
    const std::vector<std::uint8_t> bytes{0xFF, 0xFF, 0xFF};
    BitReader reader(bytes);
    EXPECT_EQ(reader.read(20), 0xFFFFFu);
    EXPECT_EQ(reader.read(5), 0u);
    EXPECT_TRUE(reader.failed());
    EXPECT_EQ(reader.read(1), 0u) << "what is left is not handed out after a failure";
    EXPECT_TRUE(reader.failed());
    BitReader nothing;
    EXPECT_EQ(nothing.read(0), 0u);
    EXPECT_FALSE(nothing.failed());
    EXPECT_EQ(nothing.read(32), 0u);
    EXPECT_TRUE(nothing.failed());
}

TEST(BitReader, RefusesPaddingThatIsNotZero) {
    const std::vector<std::uint8_t> bytes{0x11};
    BitReader good(bytes);
    EXPECT_EQ(good.read(5), 0x11u);
    good.align();
    EXPECT_FALSE(good.failed());
    BitReader bad(bytes);
    EXPECT_EQ(bad.read(4), 0x1u);
    bad.align();
    EXPECT_TRUE(bad.failed());
}

TEST(Varint, TakesTheNarrowestWidthAndNoticesAWiderOne) {
    constexpr VarintWidths kWidths{8, 12, 16, 32};
    for (const std::uint32_t value : {0u, 255u, 256u, 4095u, 4096u, 65535u, 65536u, 0xFFFFFFFFu}) {
        BitWriter writer;
        write_varint(writer, value, kWidths);
        std::vector<std::uint8_t> bytes;
        writer.finish(bytes);
        BitReader reader(bytes);
        bool canonical = true;
        EXPECT_EQ(read_varint(reader, kWidths, canonical), value);
        EXPECT_TRUE(canonical);
    }
    BitWriter writer;
    writer.write(1, 2);
    writer.write(255, 12);
    std::vector<std::uint8_t> bytes;
    writer.finish(bytes);
    BitReader reader(bytes);
    bool canonical = true;
    EXPECT_EQ(read_varint(reader, kWidths, canonical), 255u);
    EXPECT_FALSE(canonical);
}

TEST(Leb128, GivesBackNumbersAndRefusesLongOnesCutOnesAndLargeOnes) {
    for (const std::uint32_t value : {0u, 1u, 127u, 128u, 16383u, 16384u, 0xFFFFFFFFu}) {
        std::vector<std::uint8_t> bytes;
        append_leb128(value, bytes);
        std::size_t offset = 0;
        std::uint32_t back = 1;
        ASSERT_TRUE(read_leb128(bytes, offset, back));
        EXPECT_EQ(back, value);
        EXPECT_EQ(offset, bytes.size());
        offset = 0;
        EXPECT_FALSE(read_leb128(std::span(bytes).first(bytes.size() - 1), offset, back));
    }
    const std::vector<std::vector<std::uint8_t>> bad{
        {0x80, 0x00}, {0xFF, 0xFF, 0xFF, 0xFF, 0x1F}, {0x80, 0x80, 0x80, 0x80, 0x80, 0x01}, {}};
    for (const auto& bytes : bad) {
        std::size_t offset = 0;
        std::uint32_t value = 0;
        EXPECT_FALSE(read_leb128(bytes, offset, value));
    }
}

}  // namespace
}  // namespace zoned::wire
