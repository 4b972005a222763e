// Clocks and courses that both sides compute for themselves.
#include "shared/clock/shared_environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace zoned::clock {
namespace {

constexpr double kTick_s = 1.0 / 30.0;

EnvironmentDefs day_and_weather() {
    EnvironmentDefs defs;
    defs.clocks.push_back({"time_of_day", 24.0, {0, 8.0, 24.0 / 1200.0}});  // a day is 20 minutes
    SharedVariableDef weather{"rain", 7, 5.0, {}};
    weather.phases = {{"clear", 0.0, 3.0, 20.0, 60.0},
                      {"drizzle", 0.3, 1.0, 10.0, 30.0},
                      {"storm", 1.0, 1.0, 5.0, 15.0}};
    defs.variables.push_back(weather);
    return defs;
}

TEST(SharedClock, RunsAtItsRateAndWraps) {
    SharedClock clock(kTick_s, 24.0);
    EXPECT_EQ(clock.at(5.0), std::nullopt);
    clock.announce({0, 23.0, 0.02});
    EXPECT_NEAR(*clock.at(30.0 * 49.0), 23.98, 1e-9);
    EXPECT_NEAR(*clock.at(30.0 * 51.0), 0.02, 1e-9);
    SharedClock back(kTick_s, 24.0);
    back.announce({0, 0.01, -0.02});
    EXPECT_NEAR(*back.at(30.0), 23.99, 1e-9);
    back.announce({10, -1e-300, 0.0});
    EXPECT_LT(*back.at(10.0), 24.0);
}

TEST(SharedClock, KeepsItsPastWhenAChangeIsAnnouncedInAdvance) {
    SharedClock clock(kTick_s, 0.0);
    clock.announce({0, 0.0, 1.0});
    clock.announce({300, *clock.at(300.0), 4.0});
    EXPECT_NEAR(*clock.at(150.0), 5.0, 1e-12);
    EXPECT_NEAR(*clock.at(300.0), 10.0, 1e-12);
    EXPECT_NEAR(*clock.at(330.0), 14.0, 1e-12);
    EXPECT_EQ(clock.from(200).size(), 2U);
    EXPECT_EQ(clock.from(300).size(), 1U);
    // Another announcement for an earlier tick takes the place of the later one.
    clock.announce({240, *clock.at(240.0), 0.0});
    EXPECT_NEAR(*clock.at(400.0), 8.0, 1e-12);
    for (Tick t = 500; t < 900; t += 10) {
        clock.announce({t, 1.0, 1.0});
    }
    EXPECT_EQ(clock.at(100.0), std::nullopt) << "long ago";
    EXPECT_LE(clock.from(0).size(), SharedClock::kMostCourses);
}

TEST(SharedClock, DriftsByTheErrorOfTheTickTimesTheRateAndNoMore) {
    const EnvironmentDefs defs = day_and_weather();
    SharedEnvironment server(defs, kTick_s);
    server.begin(defs);
    SharedEnvironment client(defs, kTick_s);
    for (const ClockCourse& course : server.clock(0).from(0)) {
        client.announce(0, course);
    }
    for (Tick tick = 0; tick < 30LL * 3600 * 24 * 30; tick += 999983) {
        EXPECT_EQ(client.clock_at(0, tick), server.clock_at(0, tick)) << "the same bits";
        // A client whose clock is off by 20 ms shows a value that is off by 20 ms of it.
        const double off = *client.clock(0).at(static_cast<double>(tick) + 0.02 / kTick_s) -
                           *server.clock_at(0, tick);
        const double wrapped = std::remainder(off, 24.0);
        // A month of hours in doubles: 11 digits are left.
        EXPECT_NEAR(wrapped, 0.02 * 24.0 / 1200.0, 1e-7);
    }
}

TEST(SharedVariable, IsComputedAlikeFromAnyCursor) {
    const EnvironmentDefs defs = day_and_weather();
    SharedEnvironment server(defs, kTick_s);
    server.begin(defs);
    SharedEnvironment late(defs, kTick_s);
    EXPECT_EQ(late.value_at(0, 100), std::nullopt);
    for (Tick tick = 0; tick < 60000; ++tick) {
        server.advance(tick);
        if (tick == 31234) {
            EXPECT_EQ(late.place(0, *server.cursor_at(0, tick)), 0.0);
        }
        if (tick >= 31234) {
            late.advance(tick);
            ASSERT_EQ(late.value_at(0, tick), server.value_at(0, tick));
            ASSERT_EQ(late.cursor_at(0, tick), server.cursor_at(0, tick));
        }
    }
    EXPECT_EQ(server.at("rain", 60000), server.value_at(0, 60000));
    EXPECT_EQ(server.at("time_of_day", 60000), server.clock_at(0, 60000));
    EXPECT_EQ(server.at("moon", 60000), std::nullopt);
}

TEST(SharedVariable, GoesThroughItsPhasesAsLongAndAsOftenAsToldAndNeverJumps) {
    const EnvironmentDefs defs = day_and_weather();
    const SharedVariable rain(defs.variables[0], kTick_s);
    VariableCursor cursor = rain.begin();
    std::map<std::uint32_t, int> met;
    std::map<std::uint32_t, int> after_clear;
    for (int i = 0; i < 20000; ++i) {
        const VariablePhase& phase = rain.def().phases[cursor.phase];
        const Tick length = rain.length(cursor);
        EXPECT_GE(static_cast<double>(length), phase.min_s / kTick_s - 1.0);
        EXPECT_LE(static_cast<double>(length), phase.max_s / kTick_s + 1.0);
        const VariableCursor next = *rain.carry_on(cursor, cursor.since + length);
        EXPECT_EQ(next.number, cursor.number + 1);
        EXPECT_NE(next.phase, cursor.phase);
        EXPECT_EQ(rain.value(next, next.since), rain.value(cursor, next.since));
        ++met[cursor.phase];
        after_clear[next.phase] += cursor.phase == 0 ? 1 : 0;
        cursor = next;
    }
    // After clear skies drizzle and storms are equally likely: binomial, within five deviations.
    const int clear = met[0];
    EXPECT_NEAR(after_clear[1], 0.5 * clear, 5.0 * std::sqrt(0.25 * clear));
    EXPECT_EQ(rain.carry_on(cursor, cursor.since - 1), std::nullopt);
}

TEST(SharedVariable, OfAHostileLengthIsGivenUpInBoundedTime) {
    SharedVariableDef def{
        "flicker", 1, 0.0, {{"on", 1.0, 1.0, 0.0, 0.0}, {"off", 0.0, 1.0, 0.0, 0.0}}};
    const SharedVariable flicker(def, kTick_s);
    EXPECT_TRUE(flicker.carry_on(flicker.begin(), 1000).has_value());
    EXPECT_EQ(flicker.carry_on(flicker.begin(), Tick{1} << 40), std::nullopt);
}

TEST(SharedEnvironment, SaysByHowMuchItWasWrongWhenItIsToldBetter) {
    const EnvironmentDefs defs = day_and_weather();
    SharedEnvironment state(defs, kTick_s);
    state.begin(defs);
    const VariableCursor right = *state.cursor_at(0, 5000);
    EXPECT_EQ(state.place(0, right), 0.0);
    VariableCursor other = right;
    other.phase = (right.phase + 1) % 3;
    other.before = right.before + 0.25;
    EXPECT_NEAR(state.place(0, other), 0.25, 1e-12);
    EXPECT_EQ(state.cursor_at(0, right.since), other);
}

}  // namespace
}  // namespace zoned::clock
