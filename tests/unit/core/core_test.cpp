#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <unordered_set>
#include <vector>

namespace zoned::core {
namespace {

TEST(Rng, FollowsThePublishedGenerator) {
    // The first outputs of pcg32 seeded with (42, 54), from the author's demonstration program
    // (pcg-random.org, pcg32-demo). The reference seeds state and stream directly.
    Rng rng;
    rng.state = 0;
    rng.stream = (54u << 1) | 1u;
    rng.next();
    rng.state += 42;
    rng.next();
    for (const std::uint32_t expected :
         {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu}) {
        EXPECT_EQ(rng.next(), expected);
    }
}

TEST(Rng, MixFollowsThePublishedSplitMix64) {
    // The first outputs of splitmix64 from state 0 (Vigna's reference implementation).
    EXPECT_EQ(mix(0), 0xE220A8397B1DCDAFull);
    EXPECT_EQ(mix(0x9E3779B97F4A7C15ull), 0x6E789E6AA1B965F4ull);
}

TEST(Rng, GivesTheSameNumbersForTheSameSeedAndOthersForAnother) {
    Rng a(1, 2);
    Rng b(1, 2);
    Rng other_seed(2, 2);
    Rng other_sequence(1, 3);
    int equal_seed = 0;
    int equal_sequence = 0;
    for (int i = 0; i < 1000; ++i) {
        const std::uint32_t x = a.next();
        EXPECT_EQ(x, b.next());
        equal_seed += x == other_seed.next() ? 1 : 0;
        equal_sequence += x == other_sequence.next() ? 1 : 0;
    }
    EXPECT_EQ(equal_seed, 0);
    EXPECT_EQ(equal_sequence, 0);
}

TEST(Rng, ContinuesFromACopyOfItsState) {
    Rng a(9);
    a.next();
    Rng b;
    b.state = a.state;
    b.stream = a.stream;
    for (int i = 0; i < 100; ++i) {
        ASSERT_EQ(a.next(), b.next());
    }
}

/// Chi-square of counts that ought to be equal.
double chi_square(const std::vector<int>& counts, int draws) {
    const double expected = static_cast<double>(draws) / static_cast<double>(counts.size());
    double sum = 0.0;
    for (const int count : counts) {
        sum += (count - expected) * (count - expected) / expected;
    }
    return sum;
}

TEST(Rng, BelowIsUniform) {
    for (const std::uint32_t bound : {2u, 3u, 6u, 10u, 100u, 257u}) {
        Rng rng(11, bound);
        constexpr int kDraws = 200000;
        std::vector<int> counts(bound, 0);
        for (int i = 0; i < kDraws; ++i) {
            const std::uint32_t x = rng.below(bound);
            ASSERT_LT(x, bound);
            ++counts[x];
        }
        // Chi-square with k degrees of freedom has mean k and variance 2k; five deviations and a
        // constant for the skew of small k leave less than one seed in a million.
        const double k = bound - 1;
        EXPECT_LT(chi_square(counts, kDraws), k + 5.0 * std::sqrt(2.0 * k) + 15.0) << bound;
    }
}

TEST(Rng, BelowIsUnbiasedWhereRemaindersAreNot) {
    // Of 2^32 values a bound of 3 * 2^30 hit by remainder or by plain multiplication would give
    // some results twice as often: a third of them would hold half of the draws.
    constexpr std::uint32_t kBound = 3u << 30;
    constexpr int kDraws = 300000;
    Rng rng(12);
    std::vector<int> by_remainder(3, 0);
    std::vector<int> by_third(3, 0);
    for (int i = 0; i < kDraws; ++i) {
        const std::uint32_t x = rng.below(kBound);
        ++by_remainder[x % 3];
        ++by_third[x >> 30];
    }
    EXPECT_LT(chi_square(by_remainder, kDraws), 30.0);
    EXPECT_LT(chi_square(by_third, kDraws), 30.0);
}

TEST(Rng, BelowOneIsZeroAndTheLargestBoundIsReached) {
    Rng rng(13);
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(rng.below(1), 0u);
        EXPECT_LT(rng.below(0xFFFFFFFFu), 0xFFFFFFFFu);
    }
}

TEST(Rng, UnitAndRangeKeepTheirIntervalsAndMeans) {
    Rng rng(14);
    double sum = 0.0;
    double squares = 0.0;
    constexpr int kDraws = 100000;
    for (int i = 0; i < kDraws; ++i) {
        const float u = rng.unit();
        ASSERT_GE(u, 0.0F);
        ASSERT_LT(u, 1.0F);
        const float r = rng.range(-3.0F, 5.0F);
        ASSERT_GE(r, -3.0F);
        ASSERT_LT(r, 5.0F);
        sum += u;
        squares += static_cast<double>(u) * u;
    }
    // Mean 1/2 with deviation sqrt(1 / 12 n) = 0.0009, second moment 1/3 with sqrt(4 / 45 n).
    EXPECT_NEAR(sum / kDraws, 0.5, 5 * 0.0009);
    EXPECT_NEAR(squares / kDraws, 1.0 / 3.0, 5 * 0.00095);
}

TEST(StateHash, DependsOnEveryWordAndOnTheirOrder) {
    const auto hash = [](std::initializer_list<std::uint64_t> words) {
        StateHash h;
        for (const std::uint64_t w : words) {
            h.add(w);
        }
        return h.value();
    };
    EXPECT_EQ(hash({1, 2, 3}), hash({1, 2, 3}));
    EXPECT_NE(hash({1, 2, 3}), hash({1, 3, 2}));
    EXPECT_NE(hash({1, 2}), hash({1, 2, 0}));
    EXPECT_NE(hash({}), hash({0}));
}

TEST(StateHash, SeesASingleBitOfAFloat) {
    const auto hash = [](float f) {
        StateHash h;
        h.add(f);
        return h.value();
    };
    EXPECT_NE(hash(1.0F), hash(std::nextafter(1.0F, 2.0F)));
    EXPECT_NE(hash(0.0F), hash(-0.0F));
    EXPECT_EQ(hash(0.5F), hash(0.5F));
}

TEST(StateHash, BytesIncludeTheirNumber) {
    const auto hash = [](const std::vector<std::uint8_t>& bytes) {
        StateHash h;
        h.add_bytes(bytes);
        return h.value();
    };
    EXPECT_NE(hash({}), hash({0}));
    EXPECT_NE(hash({0}), hash({0, 0}));
    EXPECT_NE(hash({1, 2, 3, 4, 5, 6, 7, 8}), hash({1, 2, 3, 4, 5, 6, 7, 8, 0}));
    EXPECT_NE(hash({1, 2, 3, 4, 5, 6, 7, 8, 9}), hash({1, 2, 3, 4, 5, 6, 7, 8, 10}));
}

TEST(StateHash, ScattersTheBitsOfSmallChanges) {
    // A good hash flips each of 64 bits with probability 1/2: mean 32, deviation 4 / sqrt(n).
    Rng rng(15);
    double flipped = 0.0;
    std::set<std::uint64_t> seen;
    constexpr int kCases = 4000;
    for (int i = 0; i < kCases; ++i) {
        const std::uint64_t word = (static_cast<std::uint64_t>(rng.next()) << 32) | rng.next();
        StateHash a;
        StateHash b;
        a.add(word);
        b.add(word ^ (1ull << rng.below(64)));
        flipped += std::popcount(a.value() ^ b.value());
        seen.insert(a.value());
    }
    EXPECT_NEAR(flipped / kCases, 32.0, 5.0 * 4.0 / std::sqrt(kCases));
    EXPECT_EQ(seen.size(), static_cast<std::size_t>(kCases));
}

TEST(Result, HoldsAValueOrAReason) {
    const Result<int> good = 7;
    ASSERT_TRUE(good.ok());
    EXPECT_EQ(good.value(), 7);
    EXPECT_EQ(*good, 7);
    const Result<int> bad = Result<int>::failure("too short");
    EXPECT_FALSE(bad);
    EXPECT_EQ(bad.error(), "too short");
}

TEST(Result, CarriesValuesThatCanOnlyBeMoved) {
    Result<std::unique_ptr<int>> result = std::make_unique<int>(3);
    const std::unique_ptr<int> taken = std::move(result).value();
    EXPECT_EQ(*taken, 3);
}

TEST(Result, HoldsTextAsValueAndAsReasonWithoutMixingThem) {
    const Result<std::string> good = std::string("fine");
    EXPECT_EQ(good.value(), "fine");
    const auto bad = Result<std::string>::failure("bad");
    EXPECT_FALSE(bad.ok());
}

TEST(ResultDeathTest, StopsWhoReadsTheWrongSide) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    const Result<int> good = 7;
    const Result<int> bad = Result<int>::failure("no");
    EXPECT_DEATH(static_cast<void>(bad.value()), "value\\(\\) of a failed Result");
    EXPECT_DEATH(static_cast<void>(good.error()), "error\\(\\) of a Result that holds a value");
}

TEST(StrongId, ZeroIsNone) {
    EXPECT_FALSE(static_cast<bool>(EntityId()));
    EXPECT_TRUE(static_cast<bool>(EntityId(1)));
    EXPECT_LT(EntityId(1), EntityId(2));
    std::unordered_set<EntityId> set{EntityId(1), EntityId(2), EntityId(1)};
    EXPECT_EQ(set.size(), 2U);
}

}  // namespace
}  // namespace zoned::core
