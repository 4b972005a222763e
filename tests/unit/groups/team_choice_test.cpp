// Team choice: parties stay together, those who wait longest play, and nobody is overlooked.
#include "server/zone/groups/team_choice.h"

#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace zoned::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::Optional;
using Sizes = std::vector<std::uint32_t>;

TEST(TeamChoice, TakesThoseWhoWaitLongest) {
    EXPECT_EQ(choose_teams(Sizes{1}, {2, 1, 1}), std::nullopt);
    EXPECT_EQ(choose_teams(Sizes{}, {2, 1, 1}), std::nullopt);
    EXPECT_THAT(choose_teams(Sizes{1, 1, 1}, {2, 1, 1}), Optional(ElementsAre(0, 1, kNoTeam)));
    EXPECT_THAT(choose_teams(Sizes{1, 1, 1, 1}, {2, 2, 2}), Optional(ElementsAre(0, 1, 0, 1)));
}

TEST(TeamChoice, KeepsPartiesTogether) {
    EXPECT_THAT(choose_teams(Sizes{3, 1, 2}, {2, 3, 3}), Optional(ElementsAre(0, 1, 1)));
    // Two twos and a third leave one place each, which nobody fills.
    EXPECT_EQ(choose_teams(Sizes{2, 2, 2}, {2, 3, 3}), std::nullopt);
    EXPECT_THAT(choose_teams(Sizes{2, 2, 2, 1, 1}, {2, 3, 3}),
                Optional(ElementsAre(0, 1, kNoTeam, 0, 1)));
    EXPECT_EQ(choose_teams(Sizes{4, 1, 1, 1}, {2, 3, 3}), std::nullopt);
}

TEST(TeamChoice, PassesATicketThatWouldLeaveAGap) {
    // The second would have to be parted.
    EXPECT_THAT(choose_teams(Sizes{2, 2, 1, 3}, {2, 3, 3}),
                Optional(ElementsAre(0, kNoTeam, 0, 1)));
}

TEST(TeamChoice, IsContentWithFewer) {
    EXPECT_THAT(choose_teams(Sizes{2, 2}, {2, 3, 2}), Optional(ElementsAre(0, 1)));
    EXPECT_THAT(choose_teams(Sizes{1, 1, 1}, {2, 3, 1}), Optional(ElementsAre(0, 1, 0)));
}

/// All ways, one after the other.
bool any_way(const Sizes& sizes, std::size_t i, Sizes& players, const TeamShape& shape) {
    if (i == sizes.size()) {
        return std::ranges::all_of(players, [&](std::uint32_t n) { return n >= shape.least; });
    }
    for (std::uint32_t& team : players) {
        if (team + sizes[i] <= shape.size) {
            team += sizes[i];
            const bool found = any_way(sizes, i + 1, players, shape);
            team -= sizes[i];
            if (found) {
                return true;
            }
        }
    }
    return i > 0 && any_way(sizes, i + 1, players, shape);
}

TEST(TeamChoice, FindsATeamWhereverThereIsOne) {
    core::Rng rng(11);
    int found = 0;
    int none = 0;
    for (int round = 0; round < 4000; ++round) {
        TeamShape shape;
        shape.teams = 1 + rng.below(3);
        shape.size = 1 + rng.below(4);
        shape.least = 1 + rng.below(shape.size);
        Sizes sizes(rng.below(8));
        for (std::uint32_t& size : sizes) {
            size = 1 + rng.below(4);
        }
        const auto teams = choose_teams(sizes, shape);
        Sizes players(shape.teams, 0);
        const bool exists = !sizes.empty() && any_way(sizes, 0, players, shape);
        ASSERT_EQ(teams.has_value(), exists) << round;
        found += exists ? 1 : 0;
        none += exists ? 0 : 1;
        if (!teams) {
            continue;
        }
        ASSERT_EQ(teams->size(), sizes.size());
        ASSERT_NE((*teams)[0], kNoTeam);
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            if ((*teams)[i] != kNoTeam) {
                players[(*teams)[i]] += sizes[i];
            }
        }
        for (const std::uint32_t n : players) {
            ASSERT_GE(n, shape.least);
            ASSERT_LE(n, shape.size);
        }
    }
    EXPECT_GT(found, 500);
    EXPECT_GT(none, 500);
}

TEST(TeamChoice, EndsSoonForMany) {
    // Threes never fill teams of 100: a hundred tickets, a bounded search.
    EXPECT_EQ(choose_teams(Sizes(5000, 3), {4, 100, 100}), std::nullopt);
    const auto teams = choose_teams(Sizes(5000, 1), {2, 40, 40});
    ASSERT_TRUE(teams);
    EXPECT_EQ(std::ranges::count(*teams, kNoTeam), 5000 - 80);
}

}  // namespace
}  // namespace zoned::zone
