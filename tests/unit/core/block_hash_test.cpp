#include "shared/core/block_hash.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace zoned::core {
namespace {

std::uint64_t hash_of(const std::vector<std::uint64_t>& words) {
    BlockHash hash;
    for (const std::uint64_t word : words) {
        hash.add(word);
    }
    return hash.value();
}

TEST(BlockHash, SeesEachBitOfEachWordHoweverManyThereAre) {
    // Less than a block, more than one, and around its end.
    for (const std::size_t size : {1U, 3U, 4U, 5U, 60U, 127U, 128U, 129U, 300U}) {
        std::vector<std::uint64_t> words(size);
        Rng rng(size);
        for (std::uint64_t& word : words) {
            word = rng.next();
        }
        std::set<std::uint64_t> seen = {hash_of(words)};
        std::size_t changes = 1;
        for (std::size_t i = 0; i < size; ++i) {
            for (unsigned bit = 0; bit < 64; bit += 7, ++changes) {
                words[i] ^= std::uint64_t{1} << bit;
                seen.insert(hash_of(words));
                words[i] ^= std::uint64_t{1} << bit;
            }
        }
        EXPECT_EQ(seen.size(), changes) << size << " words";
    }
}

TEST(BlockHash, SeesOrderCountAndTheSignOfZero) {
    EXPECT_NE(hash_of({1, 2, 3, 4}), hash_of({1, 2, 4, 3}));
    EXPECT_NE(hash_of({1, 2, 3, 4, 5}), hash_of({5, 2, 3, 4, 1})) << "of one chain";
    EXPECT_NE(hash_of({7}), hash_of({7, 0}));
    BlockHash plus;
    plus.add(0.0F);
    BlockHash minus;
    minus.add(-0.0F);
    EXPECT_NE(plus.value(), minus.value());
}

struct Record {
    std::uint8_t small = 3;
    float real = 1.5F;
    std::int16_t negative = -2;
    bool yes = true;
    std::uint64_t large = 1;
    std::int64_t other = -1;
};

std::uint64_t packed(const Record& record) {
    BlockHash hash;
    hash.pack(record.small);
    hash.pack(record.real);
    hash.pack(record.negative);
    hash.pack(record.yes);
    hash.pack(record.large);
    hash.pack(record.other);
    return hash.value();
}

TEST(BlockHash, SeesEachNumberThatIsPacked) {
    std::set<std::uint64_t> seen = {packed({})};
    std::size_t changes = 1;
    const auto see = [&](const Record& record) {
        seen.insert(packed(record));
        ++changes;
    };
    for (unsigned bit = 0; bit < 8; ++bit) {
        see({.small = static_cast<std::uint8_t>(3U ^ 1U << bit)});
    }
    for (unsigned bit = 0; bit < 16; ++bit) {
        see({.negative = static_cast<std::int16_t>(-2 ^ static_cast<int>(1U << bit))});
    }
    for (unsigned bit = 0; bit < 64; ++bit) {
        see({.large = 1U ^ std::uint64_t{1} << bit});
        see({.other = static_cast<std::int64_t>(~std::uint64_t{0} ^ std::uint64_t{1} << bit)});
    }
    see({.yes = false});
    see({.real = 0.0F});
    see({.real = -0.0F});
    EXPECT_EQ(seen.size(), changes);
    // Negative values fill no word but their own bits.
    BlockHash minus;
    minus.pack(std::int8_t{-1});
    minus.pack(std::uint8_t{0});
    BlockHash wide;
    wide.pack(std::int16_t{0xFF});
    EXPECT_EQ(minus.value(), wide.value());
}

TEST(BlockHash, IsTheSameOnEveryMachine) {
    BlockHash hash;
    for (std::uint32_t i = 0; i < 1'000; ++i) {
        hash.add(i);
        hash.add(static_cast<float>(i) * 0.5F);
        hash.add(static_cast<std::uint64_t>(i) << 40U);
        hash.add(static_cast<std::int16_t>(-1));
    }
    // Computed by a separate program, from the definition.
    EXPECT_EQ(hash.value(), 0x80C34409C279BAFAull);
}

}  // namespace
}  // namespace zoned::core
