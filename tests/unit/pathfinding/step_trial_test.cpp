// StepTrial: what it tells without a trial is what a trial gives.
#include "server/ai/pathfinding/grid/step_trial.h"

#include "tests/unit/pathfinding/walkers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kSide_m = 40.0F;

/// The step by movement alone: in ticks of half a radius, to within 0.15 cells of the end.
bool walked_there(const motion::StaticGeometry& world,
                  motion::CharacterLimits limits,
                  const StepTrial::Foothold& from,
                  const StepTrial::Foothold& to,
                  float cell_m) {
    limits.speed = 1.0F;
    const float dx = to.at.x - from.at.x;
    const float dz = to.at.z - from.at.z;
    const float path = cell_m * (dx != 0.0F && dz != 0.0F ? std::numbers::sqrt2_v<float> : 1.0F);
    const auto ticks = static_cast<int>(std::ceil(path / (0.5F * limits.radius)));
    const float half = limits.radius + limits.half_segment;
    motion::CharacterState state;
    state.position = Vec3(from.at.x, from.floor + half, from.at.z);
    state.velocity = Vec3(dx, 0.0F, dz) / path;
    state.grounded = true;
    motion::InputCommand command;
    command.move_x = static_cast<std::int8_t>(dx > 0.0F ? 127 : dx < 0.0F ? -127 : 0);
    command.move_z = static_cast<std::int8_t>(dz > 0.0F ? 127 : dz < 0.0F ? -127 : 0);
    for (int tick = 0; tick < ticks && state.grounded; ++tick) {
        state =
            motion::apply_input(state, command, limits, world, path / static_cast<float>(ticks));
    }
    const float steepest =
        std::sqrt(1.0F - limits.max_slope_cos * limits.max_slope_cos) / limits.max_slope_cos;
    const float rise = limits.step_up + 0.1F * limits.radius + 0.15F * cell_m * steepest;
    return state.grounded && std::abs(state.position.y() - half - to.floor) <= rise &&
           std::hypot(state.position.x() - to.at.x, state.position.z() - to.at.z) <= 0.15F * cell_m;
}

std::vector<StepTrial::Foothold> footholds(StepTrial& trial, Spot at) {
    std::vector<StepTrial::Foothold> found;
    for (const float top : trial.tops(at)) {
        if (const auto floor = trial.stand(at, top)) {
            found.push_back({at, *floor});
        }
    }
    return found;
}

/// With tables besides, under which small characters walk.
motion::StaticGeometry world_with_tables(core::Rng& rng) {
    const motion::StaticGeometry world = random_world(rng, kSide_m, 40);
    std::vector<motion::StaticBox> boxes(world.boxes().begin(), world.boxes().end());
    for (int i = 0; i < 20; ++i) {
        boxes.push_back(static_box(Vec3(rng.range(-0.5F, 0.5F) * kSide_m,
                                        rng.range(0.6F, 1.2F),
                                        rng.range(-0.5F, 0.5F) * kSide_m),
                                   Vec3(1.5F, 0.05F, 1.5F),
                                   rng.range(0.0F, 90.0F)));
    }
    return {boxes, 0.0F};
}

TEST(StepTrial, TellsWithoutATrialWhatATrialGives) {
    core::Rng rng(12);
    int made = 0;
    int refused = 0;
    for (int round = 0; round < 24; ++round) {
        const motion::StaticGeometry world = world_with_tables(rng);
        motion::CharacterLimits limits;
        limits.radius = round % 3 == 0 ? 0.1F : round % 3 == 1 ? 0.4F : 0.8F;
        limits.half_segment = round % 3 == 0 ? 0.05F : rng.range(0.0F, 0.5F);
        const float cell = round % 2 == 0 ? 0.5F : 1.0F;
        StepTrial trial(world, limits, cell);
        const auto check = [&](const StepTrial::Foothold& a, const StepTrial::Foothold& b) {
            const StepTrial::Foothold& low = b.floor < a.floor ? b : a;
            const StepTrial::Foothold& high = b.floor < a.floor ? a : b;
            const bool walks = trial.walks(low, high);
            EXPECT_EQ(walks, walked_there(world, limits, low, high, cell))
                << "round " << round << ", from " << low.at.x << ", " << low.at.z << " at "
                << low.floor << " to " << high.floor;
            (walks ? made : refused) += 1;
        };
        for (int i = 0; i < 400; ++i) {
            const Spot at{rng.range(-0.5F, 0.5F) * kSide_m, rng.range(-0.5F, 0.5F) * kSide_m};
            const float aside = cell * static_cast<float>(static_cast<int>(rng.below(3)) - 1);
            const auto next = footholds(trial, {at.x + aside, at.z + cell});
            for (const StepTrial::Foothold& from : footholds(trial, at)) {
                for (const StepTrial::Foothold& to : next) {
                    check(from, to);
                }
            }
        }
    }
    EXPECT_GT(made, 1000);
    EXPECT_GT(refused, 200);
}

/// It comes as near to the middle of the next cell as a step must, at the foot of the wall.
TEST(StepTrial, OfASmallCharacterEndsBelowARoofNotOnIt) {
    motion::CharacterLimits limits;
    limits.radius = 0.1F;
    limits.half_segment = 0.05F;
    const Spot roof{1.0F, 0.0F};
    const auto walks = [&](float height) {
        const auto box =
            static_box(Vec3(1.97F, 0.5F * height, 0.0F), Vec3(1.0F, 0.5F * height, 3.0F), 0.0F);
        StepTrial trial(motion::StaticGeometry({box}, 0.0F), limits, 1.0F);
        const std::optional<float> floor = trial.stand(roof, height);
        EXPECT_TRUE(floor.has_value()) << height;
        return trial.walks({{0.0F, 0.0F}, *trial.stand({0.0F, 0.0F}, 0.0F)}, {roof, *floor});
    };
    EXPECT_FALSE(walks(1.2F));
    EXPECT_FALSE(walks(0.8F));
    EXPECT_TRUE(walks(0.2F)) << "a step";
}

TEST(PlanRect, HoldsItsBoxAndIsNoFartherThanIt) {
    core::Rng rng(13);
    for (int i = 0; i < 300; ++i) {
        motion::StaticBox box = static_box(Vec3(rng.range(-9, 9), 1.0F, rng.range(-9, 9)),
                                           Vec3(rng.range(0.1F, 4), 1.0F, rng.range(0.1F, 4)),
                                           rng.range(0, 180));
        box.orientation =
            box.orientation * Quat(Eigen::AngleAxisf(rng.range(-1.5F, 1.5F), Vec3::UnitZ()));
        const motion::StaticGeometry world({box}, 0.0F);
        const PlanRect plan(world, 0);
        for (int k = 0; k < 40; ++k) {
            const auto inside = [&] {
                const Vec3 local = box.half_extents.cwiseProduct(
                    Vec3(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)));
                const Vec3 at = box.centre + world.box_axes(0) * local;
                return Spot{at.x(), at.z()};
            };
            const Spot in = inside();
            ASSERT_LE(plan.distance(in), 1e-4F);
            ASSERT_GE(plan.depth(in), -1e-4F);
            const Spot a{rng.range(-15, 15), rng.range(-15, 15)};
            const Spot b{rng.range(-15, 15), rng.range(-15, 15)};
            ASSERT_LE(plan.distance(a), std::hypot(a.x - in.x, a.z - in.z) + 1e-4F);
            // No place of the line is nearer to any place of the box.
            const float share = rng.unit();
            const Spot on{a.x + share * (b.x - a.x), a.z + share * (b.z - a.z)};
            ASSERT_LE(plan.least_distance(a, b), std::hypot(on.x - in.x, on.z - in.z) + 1e-4F);
        }
    }
}

}  // namespace

}  // namespace zoned::ai::pathfinding
