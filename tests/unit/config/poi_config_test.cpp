// Points of interest and trades in a config: they reach the agents, and each mistake is found at
// its line and column.
#include "server/config/npc/poi_config.h"

#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

/// The guard of the test config walks to a mill when it is day, and buys flour there.
const std::string kMill = with("brain {\n  name: \"guard\"",
                               R"(point_of_interest { name: "mill" x_m: 5 z_m: -7 radius_m: 2
  stock { good: "flour" start: 4 high: 9 per_s: 0.5 }
}
brain {
  name: "buyer"
  variable { name: "coins" start: 5 high: 9 }
  variable { name: "flour" high: 3 }
  state { name: "go" action: GO point_of_interest: "mill"
    transition { to: "buy" sense: "mill.distance" compare: BELOW threshold: 2
      also { sense: "mill.flour" threshold: 1 } also { sensor: TIME_OF_DAY threshold: 100 } }
  }
  state { name: "buy" action: GO point_of_interest: "mill"
    trade { point_of_interest: "mill" give { good: "coins" amount: 2 } take { good: "flour" } }
    transition { to: "go" threshold: 5 }
  }
}
brain {
  name: "guard")",
                               with("brain: \"guard\"", "brain: \"buyer\""));

std::string mill_with(const std::string& from, const std::string& to) {
    return with(from, to, kMill);
}

TEST(PointsOfInterestInConfigs, AreBuiltAsWritten) {
    const Outcome out = parse(kMill);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::PoiSettings& points_of_interest = out.settings.ai.points_of_interest;
    ASSERT_EQ(points_of_interest.points_of_interest.size(), 1U);
    EXPECT_EQ(points_of_interest.points_of_interest[0].at, Vec2d(5.0, -7.0));
    EXPECT_EQ(points_of_interest.points_of_interest[0].stock[0].good, "flour");
    EXPECT_EQ(points_of_interest.points_of_interest[0].stock[0].per_s, 0.5F);
    EXPECT_EQ(points_of_interest.day_s, 86400.0);
    const ai::Brain& buyer = out.settings.ai.brains[0];
    ASSERT_EQ(buyer.points_of_interest.size(), 2U);
    // By name: "mill.distance", "mill.flour"; they follow the variables.
    EXPECT_EQ(buyer.points_of_interest[0].stock, -1);
    EXPECT_EQ(buyer.points_of_interest[1].stock, 0);
    const ai::Transition& to_buy = buyer.states[0].transitions[0];
    EXPECT_EQ(to_buy.sense, ai::kOwnSenses + 2);
    EXPECT_EQ(to_buy.also[0].sense, ai::kOwnSenses + 3);
    EXPECT_EQ(to_buy.also[1].sense, ai::kSenseTimeOfDay);
    ASSERT_EQ(buyer.states[1].trades.size(), 1U);
    const ai::Trade& trade = buyer.states[1].trades[0];
    ASSERT_EQ(trade.items.size(), 2U);
    EXPECT_EQ(trade.items[0].variable, 0);
    EXPECT_EQ(trade.items[0].amount, -2.0F);
    EXPECT_EQ(trade.items[0].stock, -1) << "the mill takes coins without end";
    EXPECT_EQ(trade.items[1].variable, 1);
    EXPECT_EQ(trade.items[1].amount, 1.0F);
    EXPECT_EQ(trade.items[1].stock, 0);
}

TEST(MistakesInPointsOfInterest, AreFoundWhereTheyAre) {
    expect_single(mill_with("action: GO point_of_interest: \"mill\"\n    transition",
                            "action: GO\n    transition"),
                  "action: GO\n",
                  "says nowhere to go");
    expect_single(mill_with("action: GO point_of_interest: \"mill\"\n    transition",
                            "action: IDLE point_of_interest: \"mill\"\n    transition"),
                  "point_of_interest: \"mill\"\n    transition",
                  "is of GO alone");
    expect_single(
        mill_with("trade { point_of_interest: \"mill\"", "trade { point_of_interest: \"mall\""),
        "point_of_interest: \"mall\"",
        "no point of interest named 'mall'");
    expect_single(mill_with("take { good: \"flour\" }", "take { good: \"bread\" }"),
                  "good: \"bread\"",
                  "have no variable named 'bread'");
    expect_single(mill_with("take { good: \"flour\" }", "take { good: \"coins\" }"),
                  "good: \"coins\" }",
                  "in this trade already");
    expect_single(mill_with("give { good: \"coins\" amount: 2 } take { good: \"flour\" }", ""),
                  "trade { point_of_interest",
                  "gives nothing and takes nothing");
    expect_single(mill_with("\"mill.flour\"", "\"mill.bread\""),
                  "sense: \"mill.bread\"",
                  "no \"PLACE.distance\" or \"PLACE.GOOD\"");
    expect_single(mill_with("start: 4 high: 9", "start: 10 high: 9"), "start: 10", "above `high`");
    expect_single(mill_with("x_m: 5 z_m: -7", "x_m: 50000 z_m: -7"),
                  "point_of_interest {",
                  "outside the world");
    expect_single(mill_with("point_of_interest { name: \"mill\"",
                            "point_of_interest { name: \"mill\" x_m: 0 z_m: 0 }\npoint_of_interest "
                            "{ name: \"mill\""),
                  "name: \"mill\" x_m: 5",
                  "another place named 'mill'");
    expect_single(mill_with("per_s: 0.5 }", "per_s: 0.5 } stock { good: \"distance\" }"),
                  "good: \"distance\"",
                  "what the place is sensed by");
    expect_single(mill_with("per_s: 0.5 }", "per_s: 0.5 } stock { good: \"flour\" }"),
                  "good: \"flour\" }\n}",
                  "in stock here already");
}

}  // namespace
}  // namespace zoned::config::test
