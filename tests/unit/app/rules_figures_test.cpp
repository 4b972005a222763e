#include "server/app/world/rules_figures.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::app {
namespace {

using Told = std::vector<zone::RulesFigure>;

TEST(RulesFigures, AddWhatIsCountedOverZonesAndKeepTheLastOfEachGauge) {
    RulesFigures figures;
    figures.take(Told{{"kills", 2.0, true}, {"open", 1.0, false}, {"open", 4.0, false}}, 0);
    figures.take(Told{{"kills", 0.5, true}, {"open", 7.0, false}}, 1);
    EXPECT_EQ(figures.counts, (std::map<std::string, double>{{"kills", 2.5}}));
    EXPECT_EQ(figures.gauges.at({"open", 0}), 4.0);
    EXPECT_EQ(figures.gauges.at({"open", 1}), 7.0);
    EXPECT_EQ(figures.refused, 0u);
}

TEST(RulesFigures, RefuseNamesAndNumbersThatMetricsCannotHold) {
    RulesFigures figures;
    const double none = std::numeric_limits<double>::quiet_NaN();
    figures.take(Told{{"", 1.0, true},
                      {"a b", 1.0, true},
                      {"x\"} 1\nzoned_up", 1.0, false},
                      {std::string(65, 'a'), 1.0, true},
                      {"good", none, true},
                      {"good", std::numeric_limits<double>::infinity(), false}},
                 0);
    EXPECT_EQ(figures.refused, 6u);
    EXPECT_TRUE(figures.counts.empty() && figures.gauges.empty());
}

TEST(RulesFigures, HaveRoomForAHundredNames) {
    RulesFigures figures;
    for (int i = 0; i < 150; ++i) {
        figures.take(Told{{"n" + std::to_string(i), 1.0, true}}, 0);
    }
    EXPECT_EQ(figures.counts.size(), zone::kMostRulesFigures);
    EXPECT_EQ(figures.refused, 50u);
    figures.take(Told{{"n7", 1.0, true}}, 0);
    EXPECT_EQ(figures.counts.at("n7"), 2.0);
}

}  // namespace
}  // namespace zoned::app
