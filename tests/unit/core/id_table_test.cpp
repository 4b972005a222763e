#include "shared/core/containers/id_table.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <unordered_map>

namespace zoned::core {
namespace {

/// Adds, changes and removes at random among `count` keys, `stride` apart, beside a map of the
/// library.
void follow_a_map(std::uint32_t first, std::uint32_t stride, std::uint32_t count) {
    Rng rng(stride, count);
    IdTable<std::uint32_t> table;
    std::unordered_map<std::uint32_t, std::uint32_t> map;
    for (int step = 0; step < 20'000; ++step) {
        const std::uint32_t key = first + stride * rng.below(count);
        const std::uint32_t value = rng.below(1000);
        const bool there = map.contains(key);
        if (!there || rng.below(4) == 0) {
            ASSERT_EQ(table.insert(key, value), !there) << key;
            map.emplace(key, value);
        } else if (rng.below(2) == 0) {
            *table.find(key) = value;
            map[key] = value;
        } else {
            table.erase(key);
            map.erase(key);
        }
        ASSERT_EQ(table.size(), map.size());
        if (step % 500 != 0) {
            continue;
        }
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t* found = table.find(first + stride * k);
            const auto it = map.find(first + stride * k);
            ASSERT_EQ(found == nullptr, it == map.end()) << step;
            ASSERT_TRUE(found == nullptr || *found == it->second) << step;
        }
    }
}

TEST(IdTable, FollowsAMapWhateverTheStrideOfItsKeys) {
    for (const std::uint32_t stride : {1U, 3U, 64U, 4096U, 1U << 20U}) {
        follow_a_map(1, stride, 600);
        follow_a_map(17, stride, 40);
    }
}

TEST(IdTable, HoldsNothingAtFirstAndAfterItIsCleared) {
    IdTable<int> table;
    EXPECT_EQ(table.find(1), nullptr);
    EXPECT_EQ(table.find(0), nullptr);
    table.erase(1);
    EXPECT_TRUE(table.insert(1, 5));
    EXPECT_FALSE(table.insert(1, 6));
    EXPECT_EQ(*table.find(1), 5);
    EXPECT_EQ(table.find(0), nullptr);
    table.erase(2);
    EXPECT_EQ(table.size(), 1U);
    table.clear();
    EXPECT_EQ(table.find(1), nullptr);
    EXPECT_TRUE(table.insert(1, 7));
    EXPECT_EQ(*table.find(1), 7);
}

}  // namespace
}  // namespace zoned::core
