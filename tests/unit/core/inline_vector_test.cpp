#include "shared/core/containers/inline_vector.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::core {
namespace {

TEST(InlineVector, HoldsAsManyAsItSays) {
    InlineVector<int, 3> list;
    EXPECT_TRUE(list.empty());
    for (int value = 1; value <= 3; ++value) {
        list.push_back(value);
    }
    EXPECT_EQ(std::vector<int>(list.begin(), list.end()), (std::vector<int>{1, 2, 3}));
    EXPECT_EQ(list.size(), list.kMost);
    EXPECT_DEATH(list.push_back(4), "full");
}

TEST(InlineVector, IsEqualByWhatItHolds) {
    using List = InlineVector<int, 3>;
    EXPECT_EQ((List{1, 2}), (List{1, 2}));
    EXPECT_NE((List{1, 2}), (List{1, 2, 0})) << "a zero that is there, and one that is not";
    EXPECT_NE((List{1, 2}), (List{1, 3}));
}

}  // namespace
}  // namespace zoned::core
