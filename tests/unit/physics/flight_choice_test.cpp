// Choices: the cheapest that keeps a budget, for anything and for free flight.
#include "server/physics/method_selection/flight_choice.h"

#include "server/physics/integrator/stability.h"
#include "server/physics/method_selection/cost_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics::method_selection {
namespace {

constexpr double kTickS = 1.0 / 30;
constexpr double kG = 9.81;

/// An option with a given cost and error, which counts how often it is tried.
MethodOption fake(const std::string& name, double least, MethodTrial trial, int* tried = nullptr) {
    MethodOption option;
    option.method = name;
    option.least_cost_ns = least;
    option.attempt = [trial, tried] {
        *tried += tried != nullptr ? 1 : 0;
        return trial;
    };
    return option;
}

MethodChoice chosen_from(double budget, const std::vector<MethodOption>& options) {
    MethodChoice choice;
    choice.budget = budget;
    choose(choice, options);
    return choice;
}

std::string winner(const MethodChoice& choice) {
    return choice.chosen ? choice.candidates[*choice.chosen].method : "none";
}

const MethodCandidate& candidate(const MethodChoice& choice, const std::string& name) {
    for (const MethodCandidate& c : choice.candidates) {
        if (c.method == name || name_of(c) == name) {
            return c;
        }
    }
    ADD_FAILURE() << "no " << name;
    return choice.candidates.front();
}

TEST(Choose, TakesTheCheapestThatKeepsTheBudgetAndTriesNothingDearer) {
    int tried = 0;
    int dear = 0;
    const MethodChoice choice = chosen_from(0.1,
                                            {fake("dear", 30.0, {0.0, 30.0, 0.0}, &dear),
                                             fake("good", 20.0, {0.1, 20.0, 0.0}, &tried),
                                             fake("same", 20.0, {0.0, 20.0, 0.0}, &dear),
                                             fake("rough", 10.0, {0.11, 10.0, 0.0}, &tried)});
    EXPECT_EQ(winner(choice), "good");
    EXPECT_EQ(tried, 2);
    EXPECT_EQ(dear, 0);
    EXPECT_EQ(candidate(choice, "good").refused, "");
    EXPECT_EQ(candidate(choice, "rough").refused, "off by 0.11: more than 0.1");
    EXPECT_EQ(candidate(choice, "dear").refused, "dearer than 20 ns");
    EXPECT_EQ(candidate(choice, "same").refused, "dearer than 20 ns");
}

/// The cost of a trial is known for some only afterwards.
TEST(Choose, GoesByWhatATrialShowsItToCost) {
    int tried = 0;
    const MethodChoice choice = chosen_from(1.0,
                                            {fake("surprise", 1.0, {0.0, 50.0, 0.0}, &tried),
                                             fake("plain", 12.0, {0.5, 20.0, 0.0}, &tried),
                                             fake("trap", 15.0, {0.0, 60.0, 0.0}, &tried),
                                             fake("other", 10.0, {0.5, 25.0, 0.0}, &tried)});
    EXPECT_EQ(tried, 4);
    EXPECT_EQ(winner(choice), "plain");
    EXPECT_EQ(candidate(choice, "surprise").refused, "dearer than 25 ns");
    EXPECT_EQ(candidate(choice, "other").refused, "dearer than 20 ns");
    EXPECT_EQ(candidate(choice, "trap").refused, "dearer than 20 ns");
}

TEST(Choose, NeverTriesWhatIsRefusedNorTakesWhatIsNotFinite) {
    int tried = 0;
    MethodOption unstable = fake("unstable", 1.0, {0.0, 1.0, 0.0}, &tried);
    unstable.refused = "explodes";
    int other = 0;
    const MethodChoice choice = chosen_from(1.0,
                                            {unstable,
                                             fake("nan", 2.0, {NAN, 2.0, 0.0}, &other),
                                             fake("infinite", 3.0, {INFINITY, 3.0, 0.0}, &other),
                                             fake("rough", 4.0, {7.0, 4.0, 0.0}, &other),
                                             fake("rougher", 5.0, {8.0, 5.0, 0.0}, &other)});
    EXPECT_EQ(tried, 0);
    EXPECT_EQ(other, 4);
    EXPECT_EQ(winner(choice), "none");
    EXPECT_EQ(candidate(choice, "unstable").refused, "explodes");
    EXPECT_EQ(candidate(choice, "nan").refused, "does not stay finite");
    ASSERT_NE(choice.best(), nullptr);
    EXPECT_EQ(choice.best()->method, "rough");
}

TEST(Choose, StopsWhereStartUpWouldWaitTooLong) {
    int tried = 0;
    const MethodChoice choice =
        chosen_from(1.0,
                    {fake("slow", 1.0, {2.0, 1.0, 2.0 * kMostSpent}, &tried),
                     fake("late", 2.0, {0.0, 2.0, 0.0}, &tried)});
    EXPECT_EQ(tried, 1);
    EXPECT_EQ(winner(choice), "none");
    EXPECT_NE(candidate(choice, "late").refused.find("not tried"), std::string::npos);
}

Flight falling(double linear = 0.0, double quadratic = 0.0, double fastest = 50.0) {
    Flight flight;
    flight.gravity = Vec3d(0, -kG, 0);
    flight.linear_drag = linear;
    flight.quadratic_drag = quadratic;
    flight.fastest = fastest;
    return flight;
}

/// Floats: 60 ticks up to 128 m off each round the position by up to 3.8e-6 m, and velocities up to
/// 64 m/s by 1.9e-6 m/s, which count for a second on the average.
constexpr double kRounding = 60 * (3.8e-6 + 1.9e-6);

TEST(FlightError, IsThatOfTheMethodInAFall) {
    // Explicit and implicit Euler are off by g h t / 2, the others by rounding.
    const FlightBudget wish{0.0, 2.0, kTickS};
    for (const int pieces : {1, 2, 4, 8}) {
        const double off = 0.5 * kG * kTickS / pieces * 2.0;
        for (const auto kind : {IntegratorKind::kExplicitEuler,
                                IntegratorKind::kSemiImplicitEuler,
                                IntegratorKind::kImplicitEuler}) {
            EXPECT_NEAR(flight_error(kind, pieces, falling(), wish), off, kRounding);
        }
        for (const auto kind : {IntegratorKind::kDefault,
                                IntegratorKind::kVelocityVerlet,
                                IntegratorKind::kRk2,
                                IntegratorKind::kRk4,
                                IntegratorKind::kAdaptive}) {
            EXPECT_LT(flight_error(kind, pieces, falling(), wish), kRounding) << name_of(kind);
        }
    }
}

TEST(FlightError, HasTheOrderOfTheMethodInAnyAir) {
    const FlightBudget wish{0.0, 2.0, kTickS};
    Flight windy = falling(0.3, 0.02);
    windy.wind = Vec3d(5, 0, 3);
    for (const Flight& flight : {falling(0.5), falling(0.0, 0.02), windy}) {
        for (const auto& [kind, order] : {std::pair(IntegratorKind::kDefault, 1.0),
                                          std::pair(IntegratorKind::kExplicitEuler, 1.0),
                                          std::pair(IntegratorKind::kImplicitEuler, 1.0),
                                          std::pair(IntegratorKind::kRk2, 2.0),
                                          std::pair(IntegratorKind::kVelocityVerlet, 2.0)}) {
            const double ratio =
                flight_error(kind, 1, flight, wish) / flight_error(kind, 2, flight, wish);
            // drag x h is at most 0.07 at first: so large is the next term beside this one.
            EXPECT_NEAR(std::log2(ratio), order, 0.25) << name_of(kind);
        }
    }
}

/// The closed solution and the adaptive pair are two methods for the same path.
TEST(FlightError, IsTheSameByBothReferences) {
    const FlightBudget wish{0.0, 2.0, kTickS};
    const double closed = flight_error(IntegratorKind::kRk2, 1, falling(2.0), wish);
    const double paired = flight_error(IntegratorKind::kRk2, 1, falling(2.0, 1.0e-12), wish);
    EXPECT_NEAR(closed, paired, kRounding);
    EXPECT_GT(closed, 5.0 * kRounding);
    // Thin air, by series and by exponentials.
    EXPECT_NEAR(flight_error(IntegratorKind::kDefault, 1, falling(1.0e-7), wish), 0.0, kRounding);
}

TEST(FlightChoice, IsTheCheapestOfAllThatKeepTheBudgetOnEveryFlight) {
    for (const std::vector<Flight>& flights : {std::vector{falling()},
                                               std::vector{falling(0.5), falling(5.0)},
                                               std::vector{falling(0.0, 0.05), falling(70.0)}}) {
        for (const double error_m : {1.0, 0.1, 0.01, 2.0e-3}) {
            const FlightBudget wish{error_m, 2.0, kTickS};
            const MethodChoice choice = choose_flight("bodies", flights, wish);
            double least = INFINITY;
            for (const IntegratorKind kind : kFlightMethods) {
                for (const int pieces : kFlightPieces) {
                    bool keeps = true;
                    for (const Flight& flight : flights) {
                        keeps = keeps && why_unstable(kind, pieces, flight, kTickS).empty() &&
                                flight_error(kind, pieces, flight, wish) <= error_m;
                    }
                    least = keeps ? std::min(least, flight_cost_ns(kind, pieces)) : least;
                }
            }
            ASSERT_TRUE(choice.chosen) << error_m;
            const MethodCandidate& c = choice.candidates[*choice.chosen];
            EXPECT_EQ(c.cost_ns, least) << error_m << " " << name_of(c);
            EXPECT_LE(c.error, error_m);
        }
    }
}

TEST(FlightChoice, RefusesWhatADragMakesUnstableAndTellsWhy) {
    Flight thick = falling(100.0);
    thick.name = "type feather";
    const MethodChoice choice = choose_flight("bodies", std::array{thick}, {1.0e-9, 2.0, kTickS});
    const std::string once = candidate(choice, "explicit_euler x 1").refused;
    EXPECT_NE(once.find("drag x h = 3.333, at most 2"), std::string::npos) << once;
    EXPECT_NE(once.find("type feather"), std::string::npos) << once;
    // Half a tick is 1.67 of 2.
    EXPECT_NE(candidate(choice, "explicit_euler x 2").refused.find("off by"), std::string::npos);
    EXPECT_FALSE(choice.chosen);
    EXPECT_EQ(choice.candidates.size(), kFlightMethods.size() * kFlightPieces.size());
    // A quadratic drag is as steep as 2 q v: 2 x 1 x 50 at the launch.
    EXPECT_EQ(falling(0.0, 1.0).steepest_drag(), 100.0);
    EXPECT_NE(why_unstable(IntegratorKind::kRk2, 1, falling(0.0, 1.0), kTickS), "");
}

TEST(FlightChoice, RefusesVerletAsTheSceneDoes) {
    const std::array verlet{IntegratorKind::kVerlet};
    const MethodChoice choice =
        choose_flight("bodies", std::array{falling()}, {1.0, 2.0, kTickS}, verlet);
    EXPECT_FALSE(choice.chosen);
    EXPECT_EQ(choice.candidates[0].refused, why_unfit_integrator(IntegratorKind::kVerlet));
}

}  // namespace
}  // namespace zoned::physics::method_selection
