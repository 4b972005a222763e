#include "server/interest/interest_rule.h"

#include <gtest/gtest.h>

namespace zoned::interest {
namespace {

TEST(LodAt, HoldsANearerLevelUntilItsHysteresisIsPassed) {
    InterestSettings settings;
    settings.lod_radius_m = {30.0F, 60.0F};
    settings.lod_lead_m = 3.0F;
    settings.hysteresis = 0.1F;
    EXPECT_EQ(lod_at(33.0F, settings, -1), 0);
    EXPECT_EQ(lod_at(33.1F, settings, -1), 1);
    EXPECT_EQ(lod_at(35.9F, settings, 0), 0);
    EXPECT_EQ(lod_at(36.1F, settings, 0), 1);
    EXPECT_EQ(lod_at(35.9F, settings, 1), 1);
    EXPECT_EQ(lod_at(68.9F, settings, 0), 1);
    EXPECT_EQ(lod_at(68.9F, settings, 2), 2);
    EXPECT_EQ(lod_at(1e9F, settings, 0), 2);
}

TEST(Hears, IsClosedAtTheSmallerRadiusAndWidenedForWhatIsKnown) {
    EXPECT_TRUE(hears(100.0F, 10.0F, 20.0F, false, 0.1F));
    EXPECT_FALSE(hears(100.1F, 10.0F, 20.0F, false, 0.1F));
    EXPECT_TRUE(hears(120.9F, 20.0F, 10.0F, true, 0.1F));
    EXPECT_FALSE(hears(121.1F, 20.0F, 10.0F, true, 0.1F));
    EXPECT_FALSE(hears(0.0F, 10.0F, 0.0F, true, 0.1F));
}

}  // namespace
}  // namespace zoned::interest
