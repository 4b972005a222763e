// Groups of players: the permitted settings.
#include "tests/unit/config/config_helpers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::config::test {
namespace {

TEST(PartiesInConfigs, AreThereWhereTheyAreAskedFor) {
    EXPECT_FALSE(parse(kValid).settings.parties);
    const Outcome out =
        parse("parties { size: 3 most: 7 invitation_s: 2.5 rejoin_s: 0 }\n" + kValid);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    ASSERT_TRUE(out.settings.parties);
    EXPECT_EQ(out.settings.parties->size, 3u);
    EXPECT_EQ(out.settings.parties->most, 7u);
    EXPECT_EQ(out.settings.parties->rejoin_ticks, 0);
    EXPECT_EQ(out.settings.parties->invitation_ticks, std::lround(2.5 * out.settings.tick_rate_hz));
}

TEST(PartiesInConfigs, AreRefusedOutOfRange) {
    expect_single("parties { size: 1 }\n" + kValid, "size: 1", "2");
}

}  // namespace
}  // namespace zoned::config::test
