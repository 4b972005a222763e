#include "server/ai/ants/tsp_text.h"

#include <gmock/gmock.h>

namespace zoned::ai::pathfinding {

namespace {

using ::testing::HasSubstr;

constexpr const char* kHead = "NAME : t\nTYPE : TSP\nDIMENSION : 3\nEDGE_WEIGHT_TYPE : ";
constexpr const char* kNodes = "NODE_COORD_SECTION\n3 0 1.6\n1 0 0\r\n2 3.0e0 4\nEOF\nrest";

TEST(TspText, RoundsDistancesAsTheInstanceSays) {
    const auto nearest = parse_tsp(std::string(kHead) + "EUC_2D\n" + kNodes);
    ASSERT_TRUE(nearest) << nearest.error();
    EXPECT_EQ(nearest->name, "t");
    EXPECT_EQ(nearest->distances.between(0, 1), 5);
    EXPECT_EQ(nearest->distances.between(0, 2), 2);
    EXPECT_EQ(nearest->distances.between(1, 2), 4) << "of 3.84";
    const auto up = parse_tsp(std::string(kHead) + "CEIL_2D\n" + kNodes);
    ASSERT_TRUE(up) << up.error();
    EXPECT_EQ(up->distances.between(0, 1), 5);
    EXPECT_EQ(up->distances.between(1, 2), 4);
}

TEST(TspText, RefusesWhatIsMalformedWithLineAndReason) {
    struct Malformed {
        std::string text;
        const char* place;
        const char* reason;
    };

    const std::string head = std::string(kHead) + "EUC_2D\nNODE_COORD_SECTION\n";
    const Malformed cases[] = {
        {"", "line 1", "ends before NODE_COORD_SECTION"},
        {"NAME t\n", "line 1", "'KEY : VALUE'"},
        {"TYPE : ATSP\n", "line 1", "'ATSP', not TSP"},
        {"COLOUR : red\n", "line 1", "'COLOUR' is not known"},
        {"\n\nDIMENSION : 2\n", "line 3", "from 3 to"},
        {"DIMENSION : 99999999999999999999\n", "line 1", "whole number"},
        {"DIMENSION : -5\n", "line 1", "'-5'"},
        {"EDGE_WEIGHT_TYPE : GEO\n", "line 1", "'GEO', neither"},
        {"NODE_COORD_SECTION\n", "line 1", "no DIMENSION"},
        {"DIMENSION : 3\nNODE_COORD_SECTION\n", "line 2", "no EDGE_WEIGHT_TYPE"},
        {head + "0 1 1\n", "line 6", "from 1 to 3"},
        {head + "1 1 1\n1 2 2\n", "line 7", "given twice"},
        {head + "1 1\n", "line 6", "two numbers"},
        {head + "1 nan 2\n", "line 6", "two numbers"},
        {head + "1 1e300 2\n", "line 6", "two numbers"},
        {head + "1 1 2 3\n", "line 6", "'3' is too much"},
        {head + "1 1 2\nEOF\n", "line 7", "1 nodes are given of 3"}};
    for (const Malformed& m : cases) {
        const auto read = parse_tsp(m.text);
        ASSERT_FALSE(read) << m.text;
        EXPECT_THAT(read.error(), HasSubstr(m.place)) << m.text;
        EXPECT_THAT(read.error(), HasSubstr(m.reason)) << m.text;
    }
}

}  // namespace

}  // namespace zoned::ai::pathfinding
