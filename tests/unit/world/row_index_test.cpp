#include "server/world/row_index.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <unordered_map>
#include <vector>

namespace zoned::world {
namespace {

/// Adds, moves and removes at random among `count` ids, `stride` apart, beside a map of the
/// library.
void follow_a_map(std::uint32_t first, std::uint32_t stride, std::uint32_t count) {
    core::Rng rng(stride, count);
    RowIndex index;
    std::unordered_map<std::uint32_t, Row> map;
    for (int step = 0; step < 20'000; ++step) {
        const std::uint32_t id = first + stride * rng.below(count);
        const Row row = rng.below(1000);
        const bool there = map.contains(id);
        if (!there || rng.below(4) == 0) {
            ASSERT_EQ(index.insert(EntityId(id), row), !there) << id;
            map.emplace(id, row);
        } else if (rng.below(2) == 0) {
            index.move(EntityId(id), row);
            map[id] = row;
        } else {
            index.erase(EntityId(id));
            map.erase(id);
        }
        if (step % 500 == 0) {
            for (std::uint32_t k = 0; k < count; ++k) {
                const auto it = map.find(first + stride * k);
                ASSERT_EQ(index.find(EntityId(first + stride * k)),
                          it == map.end() ? kNoRow : it->second)
                    << step;
            }
        }
    }
}

TEST(RowIndex, FollowsAMapWhateverTheStrideOfItsIds) {
    for (const std::uint32_t stride : {1U, 3U, 64U, 4096U, 1U << 20U}) {
        follow_a_map(1, stride, 600);
        follow_a_map(17, stride, 40);
    }
}

TEST(RowIndex, HoldsNothingAtFirstAndAfterItIsCleared) {
    RowIndex index;
    EXPECT_EQ(index.find(EntityId(1)), kNoRow);
    EXPECT_EQ(index.find(EntityId()), kNoRow);
    EXPECT_TRUE(index.insert(EntityId(1), 5));
    EXPECT_FALSE(index.insert(EntityId(1), 6));
    EXPECT_EQ(index.find(EntityId(1)), 5U);
    EXPECT_EQ(index.find(EntityId()), kNoRow);
    index.clear();
    EXPECT_EQ(index.find(EntityId(1)), kNoRow);
    EXPECT_TRUE(index.insert(EntityId(1), 7));
    EXPECT_EQ(index.find(EntityId(1)), 7U);
}

}  // namespace
}  // namespace zoned::world
