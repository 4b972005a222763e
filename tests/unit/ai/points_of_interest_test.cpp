// Points of interest: spots, stock that grows, trades that are complete or not done at all, and the
// buyer of the last loaf.
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::size_t kBread = 0;
constexpr std::size_t kPond = 1;

PoiSettings town() {
    PoiSettings settings;
    settings.points_of_interest = {{"bakery", {10.0, 20.0}, 3.0F, {{"bread", 2.0F, 5.0F, 0.5F}}},
                                   {"pond", {-30.0, 0.0}, 10.0F, {}}};
    settings.day_s = 600.0;
    settings.dawn_s = 590.0;
    return settings;
}

TEST(PointsOfInterest, GiveEverybodyASpotOfTheirOwnWithinThem) {
    const PointsOfInterest points_of_interest(town(), Vec2d(10.0, 0.0), kDt);
    Vec2 sum = Vec2::Zero();
    for (std::uint32_t id = 1; id <= 1000; ++id) {
        const Vec2 spot = points_of_interest.spot(kPond, EntityId(id));
        EXPECT_LE((spot - Vec2(-40.0F, 0.0F)).norm(), 10.0F) << "the zone's origin is at x = 10";
        EXPECT_EQ(spot, points_of_interest.spot(kPond, EntityId(id)));
        sum += spot;
    }
    // The mean of 1,000 uniform points of a disc of 10 m: sigma is 5 m a side / sqrt(1000) = 0.16.
    EXPECT_LT((sum / 1000.0F - Vec2(-40.0F, 0.0F)).norm(), 4.0F * 0.16F * 1.4143F);
}

TEST(PointsOfInterest, KeepStockThatGrowsUpToItsBound) {
    PointsOfInterest points_of_interest(town(), Vec2d::Zero(), 1.0F);
    EXPECT_EQ(points_of_interest.stock(0, kBread, 0), 2.0F);
    EXPECT_EQ(points_of_interest.stock(0, kBread, 4), 4.0F);
    EXPECT_EQ(points_of_interest.stock(0, kBread, 100), 5.0F);
    const Trade two{0, {{0, 0, 2.0F}}};
    ASSERT_TRUE(points_of_interest.can(two, 4));
    points_of_interest.commit(two, 4);
    EXPECT_EQ(points_of_interest.stock(0, kBread, 4), 2.0F);
    EXPECT_EQ(points_of_interest.stock(0, kBread, 6), 3.0F);
    EXPECT_FALSE(points_of_interest.can({0, {{0, 0, 3.5F}}}, 6)) << "not so much is there";
    EXPECT_FALSE(points_of_interest.can({0, {{0, 0, -2.5F}}}, 6)) << "nor is there room";
    EXPECT_TRUE(points_of_interest.can({1, {{0, -1, 1e6F}}}, 6))
        << "what it does not stock has no end";
}

TEST(PointsOfInterest, KnowTheTimeOfDay) {
    const PointsOfInterest points_of_interest(town(), Vec2d::Zero(), 0.5F);
    EXPECT_EQ(points_of_interest.time_of_day(0), 590.0F);
    EXPECT_EQ(points_of_interest.time_of_day(19), 599.5F);
    EXPECT_EQ(points_of_interest.time_of_day(20), 0.0F);
    EXPECT_EQ(points_of_interest.time_of_day(20 + 1200 + 7), 3.5F);
    EXPECT_EQ(points_of_interest.day_s(), 600.0F);
}

/// Buys a loaf for two coins at once, and then stands.
Brain buyer() {
    Brain m;
    m.name = "buyer";
    m.decide_every_s = kDt;
    m.variables = {{"coins", 3.0F, 0.0F, 0.0F, 10.0F}, {"bread", 0.0F, 0.0F, 0.0F, 2.0F}};
    m.states.resize(2);
    m.states[0].name = "wait";
    m.states[0].transitions = {{1, Sensor::kTimeOfDay, Compare::kBelow, 100.0F, 0.0F}};
    m.states[1].name = "buy";
    m.states[1].trades = {{0, {{0, -1, -2.0F}, {1, 0, 1.0F}}}};
    return m;
}

/// Six at the bakery when the day begins, and one far from it.
class Market : public testing::TestWithParam<bool> {
  protected:
    Market() {
        field.settings.brains = {buyer()};
        field.settings.viewer_range_m = GetParam() ? std::numeric_limits<float>::infinity() : 30.0F;
        field.settings.suspend_after_s = 0.1F;
        field.points_of_interest = PointsOfInterest(town(), Vec2d::Zero(), kDt);
        compile(field.settings, kDt);
        for (std::uint32_t id = 1; id <= 7; ++id) {
            const Vec3 at = id == 4 ? Vec3(40.0F, 0.9F, 20.0F) : Vec3(10.0F, 0.9F, 20.0F);
            field.add_npc(id, kGuard, 0, at);
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
    }

    [[nodiscard]] float has(std::uint32_t id, std::size_t v) const {
        return variable_at(
            *field.agents.find(EntityId(id)), field.settings.compiled[0], v, field.now);
    }

    Field field;
};

TEST_P(Market, TheSmallestGetTheLastLoavesAndNobodyPaysForNone) {
    // Ten seconds until the day begins: by then five loaves are there, and six want one.
    const auto trades_until = [&](Tick end) {
        std::uint32_t trades = 0;
        while (field.now < end) {
            trades += field.step().trades;
        }
        return trades;
    };
    EXPECT_EQ(trades_until(330), 5U);
    for (const std::uint32_t id : {1U, 2U, 3U, 5U, 6U}) {
        EXPECT_EQ(has(id, 0), 1.0F) << id;
        EXPECT_EQ(has(id, 1), 1.0F) << id;
    }
    for (const std::uint32_t id : {4U, 7U}) {
        EXPECT_EQ(has(id, 0), 3.0F) << id;
        EXPECT_EQ(has(id, 1), 0.0F) << id;
    }
    // Half a loaf a second: the next one comes after two, and goes to the agent that waits for it.
    EXPECT_EQ(trades_until(400), 1U);
    EXPECT_EQ(has(7, 1), 1.0F);
    EXPECT_EQ(has(4, 1), 0.0F) << "it is not there";
    EXPECT_EQ(trades_until(900), 0U) << "once";
}

INSTANTIATE_TEST_SUITE_P(PointsOfInterest,
                         Market,
                         testing::Bool(),
                         [](const testing::TestParamInfo<bool>& tested) {
                             return tested.param ? "WhereAllIsSimulated" : "WhereNobodyLooks";
                         });

}  // namespace
}  // namespace zoned::ai
