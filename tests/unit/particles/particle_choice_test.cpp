// Particles in pieces: their error, and the number of pieces that a budget asks for.
#include "server/physics/method_selection/particle_choice.h"

#include <gtest/gtest.h>

namespace zoned::physics::method_selection {
namespace {

constexpr double kTickS = 1.0 / 30;
constexpr double kTwoSeconds = 2.0;

FlightBudget within(double metres) {
    return {metres, kTwoSeconds, kTickS};
}

/// Semi-implicit Euler is off by g h t / 2 in a fall. 20 m in floats, added up over 60 ticks of up
/// to 16 pieces: some roundings of 1e-6 m.
TEST(ParticleChoice, CutsTheErrorOfAFallByThePieces) {
    const ParticleSystemDef def;
    const auto g = static_cast<double>(kGravity);
    for (const int pieces : {1, 2, 4, 16}) {
        EXPECT_NEAR(particle_error(def, pieces, 0.0, within(1.0)),
                    0.5 * g * kTwoSeconds * kTickS / pieces,
                    1e-3)
            << pieces;
    }
}

/// Of first order with drag, wind and quadratic drag too: half the step, half the error. Terms of
/// second order are as small against it as drag x h / 2.
TEST(ParticleChoice, IsOfFirstOrderInTheAir) {
    ParticleSystemDef def;
    def.linear_drag = 0.5F;
    def.quadratic_drag = 0.02F;
    def.wind.uniform = Vec3(3, 0, 1);
    const double one = particle_error(def, 4, 20.0, within(1.0));
    const double half = particle_error(def, 8, 20.0, within(1.0));
    EXPECT_NEAR(one / half, 2.0, 0.1);
}

TEST(ParticleChoice, TakesTheFewestPiecesThatKeepTheBudget) {
    const ParticleSystemDef def;
    // 0.327 m in one piece.
    for (const auto& [budget, pieces] : {std::pair(0.5, 1), {0.2, 2}, {0.05, 8}, {0.006, 64}}) {
        const MethodChoice choice = choose_particle_pieces(def, 5.0, within(budget));
        ASSERT_TRUE(choice.chosen) << budget;
        EXPECT_EQ(choice.candidates[*choice.chosen].pieces, pieces) << budget;
        EXPECT_LE(choice.candidates[*choice.chosen].error, budget);
    }
    EXPECT_FALSE(choose_particle_pieces(def, 5.0, within(1e-4)).chosen);
}

/// Obstacles and gusts do not count in the error.
TEST(ParticleChoice, LeavesOutWhatIsInTheWay) {
    ParticleSystemDef def;
    const double free = particle_error(def, 2, 5.0, within(1.0));
    def.walls = {{Vec3::UnitY(), 0.0F}};
    def.wind.gust_speed = 10.0F;
    EXPECT_EQ(particle_error(def, 2, 5.0, within(1.0)), free);
}

}  // namespace
}  // namespace zoned::physics::method_selection
