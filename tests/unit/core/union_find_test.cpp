#include "shared/core/containers/union_find.h"

#include <gtest/gtest.h>

namespace zoned::core {

TEST(UnionFind, NamesEachSetByItsSmallestNumber) {
    UnionFind sets;
    sets.reset(6);
    sets.join(5, 3);
    sets.join(3, 1);
    sets.join(4, 2);
    EXPECT_EQ(sets.root(5), 1U);
    EXPECT_EQ(sets.root(4), 2U);
    EXPECT_EQ(sets.root(0), 0U);
    sets.join(4, 5);
    EXPECT_EQ(sets.root(2), 1U);
}

TEST(UnionFind, GrowsBySetsOfOneNumberAndPartsThem) {
    UnionFind sets;
    sets.reset(2);
    sets.join(0, 1);
    sets.grow(4);
    EXPECT_EQ(sets.root(1), 0U);
    EXPECT_EQ(sets.root(3), 3U);
    sets.part(1);
    EXPECT_EQ(sets.root(1), 1U);
}

}  // namespace zoned::core
