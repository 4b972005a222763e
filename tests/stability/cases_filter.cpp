// Filters that change while the world runs: bodies that start and stop colliding, in overlap and
// asleep too.
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::stability {

namespace {

constexpr std::uint32_t kFixed = 1;  ///< category of static bodies
constexpr std::uint32_t kRed = 2;
constexpr std::uint32_t kBlue = 4;
constexpr std::uint32_t kAll = 0xFFFFFFFFU;

physics::Filter filter_of(std::uint32_t category, std::uint32_t mask) {
    return {category, mask};
}

double count_awake(const World& world, const std::vector<BodyId>& ids) {
    return static_cast<double>(std::count_if(
        ids.begin(), ids.end(), [&](BodyId id) { return !world.scene.state(id).asleep; }));
}

/// The largest difference of bodies that fall from rest from the closed form h - g t^2 / 2, while
/// they have fallen by less than `height`. A body that wakes a step late is off by g dt t, 7 cm.
double fall_error(World& world, const std::vector<BodyId>& ids, double height) {
    std::vector<double> from;
    for (const BodyId id : ids) {
        from.push_back(static_cast<double>(world.watch(id).position.y()));
    }
    double worst = 0.0;
    for (int i = 1; world.step(); ++i) {
        const double t = i * static_cast<double>(kFrame);
        if (0.5 * kG * t * t > height) {
            break;
        }
        for (std::size_t k = 0; k < ids.size(); ++k) {
            const auto y = static_cast<double>(world.watch(ids[k]).position.y());
            worst = std::max(worst, std::abs(y - from[k] + 0.5 * kG * t * t));
        }
    }
    return worst;
}

/// Boxes on boxes, asleep. The upper ones stop meeting the lower ones: they wake, fall freely
/// through them, and sleep within them. Free flight is exact but for rounding (1 mm). Then they
/// meet again: they wake and part. Pushed boxes go at 3 m/s at most and may fall a metre.
void sleepers(Run& run) {
    World world(run, "filter-sleep", "boxes through boxes");
    world.ground(100.0F);
    std::vector<BodyId> lower;
    std::vector<BodyId> upper;
    const int pairs = run.pick(8, 40);
    for (int i = 0; i < pairs; ++i) {
        const auto x = 4.0F * static_cast<float>(i - pairs / 2);
        BodyDef def = body_of(Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(x, 1.5F, 0.0F));
        def.filter = filter_of(kBlue, kAll);
        upper.push_back(world.add(def));
        def.position.y() = 0.5F;
        def.filter = filter_of(kRed, kAll);
        lower.push_back(world.add(def));
    }
    world.limits.speed_mps = kPush + std::sqrt(2.0 * kG * 1.0);
    world.fault_at = 125;  // in the fall
    world.run(2.0F);
    double awake = count_awake(world, upper) + count_awake(world, lower);
    for (const BodyId id : upper) {
        world.scene.set_filter(id, filter_of(kBlue, kFixed));
    }
    world.row.check("fall_error_m", fall_error(world, upper, 0.9), 1.0e-3);
    world.run(2.0F);
    awake += count_awake(world, upper) + count_awake(world, lower);
    world.row.check("awake_bodies", awake, 0.0);
    for (const BodyId id : upper) {
        world.scene.set_filter(id, filter_of(kBlue, kAll));
    }
    world.run(3.0F);
    world.row.check("depth_at_end_m", world.depth_now(), 2.0 * kGive);
    world.finish();
}

/// Boxes asleep on a static platform that opens: they fall freely by the 2 m below it, less their
/// half heights. Others sleep on the ground within a low platform that is open, which then closes:
/// they are pushed up onto it.
void trapdoor(Run& run) {
    World world(run, "filter-sleep", "platforms open and close");
    world.ground();
    const BodyId high = world.wall(Vec3(-10.0F, 2.5F, 0.0F), Vec3(4.0F, 0.5F, 4.0F));
    const BodyId low = world.wall(Vec3(10.0F, 0.4F, 0.0F), Vec3(4.0F, 0.4F, 4.0F));
    world.scene.set_filter(low, filter_of(kFixed, kBlue));
    std::vector<BodyId> falling;
    std::vector<BodyId> all;
    for (int i = 0; i < 9; ++i) {
        const auto x = 2.0F * static_cast<float>(i % 3 - 1);
        const auto z = 2.0F * static_cast<float>(i / 3 - 1);
        BodyDef def = mixed_body(i, Vec3(x - 10.0F, 3.6F, z));
        def.shape = i % 3 == 2 ? Shape::sphere(0.4F) : def.shape;
        def.filter = filter_of(kRed, kAll);
        falling.push_back(world.add(def));
        def = body_of(Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(x + 10.0F, 0.5F, z));
        def.filter = filter_of(kRed, kAll);
        all.push_back(world.add(def));
    }
    all.insert(all.end(), falling.begin(), falling.end());
    world.row.know(
        "what is pushed out of an overlap has no speed of its own while it moves: it may fall "
        "asleep before it is out",
        {{"depth_at_end_m", 4.0 * kGive}});
    world.limits.speed_mps = kPush + std::sqrt(2.0 * kG * 3.0);
    world.fault_at = 185;  // in the fall
    world.run(3.0F);
    double awake = count_awake(world, all);
    world.scene.set_filter(high, filter_of(kFixed, 0));
    // From 3.5 m down to the ground: 3 m with the half height of the body.
    world.row.check("fall_error_m", fall_error(world, falling, 2.8), 1.0e-3);
    world.scene.set_filter(low, filter_of(kFixed, kAll));
    world.run(3.0F);
    awake += count_awake(world, all);
    world.row.check("awake_bodies", awake, 0.0);
    world.scene.set_filter(high, filter_of(kFixed, kAll));
    world.run(1.0F);
    world.row.check("depth_at_end_m", world.depth_now(), 2.0 * kGive);
    world.finish();
}

/// A pile in which a tenth of the bodies turns from solid to ghost or back in each step. The room
/// stays solid for all. A body that becomes solid is pushed by those at its place, twelve at most,
/// since so many equal balls find room about one. It may fall by the height of the room. In the end
/// all are solid: overlaps of a metre part at 3 m/s, one layer after the other. Bodies at rest give
/// way by ten budgets at most, as in a resting pile.
void flicker(Run& run, std::uint64_t seed) {
    World world(run, "filter-flicker", "seed " + std::to_string(seed));
    world.room(4.0F, 14.0F);
    core::Rng rng(seed, 40);
    std::vector<BodyId> ids;
    for (int i = 0; i < run.pick(60, 150); ++i) {
        BodyDef def = mixed_body(i,
                                 Vec3(static_cast<float>(i % 5) * 1.4F - 2.8F,
                                      0.7F + static_cast<float>(i / 25) * 1.3F,
                                      static_cast<float>(i / 5 % 5) * 1.4F - 2.8F));
        def.filter = filter_of(kRed, kAll);
        ids.push_back(world.add(def));
    }
    world.limits.speed_mps = 12.0 * kPush + std::sqrt(2.0 * kG * 14.0);
    const auto steps = static_cast<int>(run.pick(3.0F, 20.0F) / kFrame);
    for (int i = 0; i < steps; ++i) {
        for (std::size_t k = 0; k < ids.size() / 10; ++k) {
            const BodyId id = ids[rng.below(static_cast<std::uint32_t>(ids.size()))];
            world.scene.set_filter(id, filter_of(kRed, rng.below(2) == 0 ? kFixed : kAll));
        }
        if (!world.step()) {
            break;
        }
    }
    for (const BodyId id : ids) {
        world.scene.set_filter(id, filter_of(kRed, kAll));
    }
    world.run(6.0F);
    world.row.check("depth_at_end_m", world.depth_now(), 10.0 * kGive);
    world.finish();
}

/// A column in which each step changes a filter to another one that all others also meet. The
/// contacts keep their memory, and the bounds are those of an undisturbed column.
void no_change(Run& run) {
    constexpr int kCount = 10;
    World world(run, "filter-column", "changes that change nothing");
    world.ground();
    std::vector<BodyId> ids;
    for (int i = 0; i < kCount; ++i) {
        BodyDef def = body_of(
            Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
        def.material.friction = 0.6F;
        ids.push_back(world.add(def));
    }
    world.limits.depth_m = 2.0 * kGive + 0.5 * kG * static_cast<double>(kFrame * kFrame);
    world.limits.drift_m = 2.0 * kGive * kCount;
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = std::sqrt(2.0 * kG * kGive * kCount);
    for (int i = 0; i < run.pick(300, 1200); ++i) {
        world.scene.set_filter(ids[static_cast<std::size_t>(i % kCount)],
                               filter_of(i / kCount % 2 == 0 ? kRed : kBlue, kAll));
        if (!world.step()) {
            break;
        }
    }
    world.finish();
}

/// Two crowds that never meet fall through each other: each body of theirs falls freely until the
/// ground, although they overlap all the time.
void ghosts(Run& run) {
    World world(run, "filter-crowds", "two that never meet");
    world.ground();
    std::vector<BodyId> ids;
    for (int i = 0; i < 100; ++i) {
        BodyDef def = mixed_body(i,
                                 Vec3(static_cast<float>(i % 10) - 5.0F,
                                      6.0F,
                                      3.0F * static_cast<float>(i / 10) - 15.0F));
        def.filter = filter_of(i % 2 == 0 ? kRed : kBlue, kFixed);
        ids.push_back(world.add(def));
    }
    world.limits.energy_share = 1.0e-3;
    world.limits.speed_mps = std::sqrt(2.0 * kG * 6.0) + 0.2;
    world.row.check("fall_error_m", fall_error(world, ids, 4.5), 1.0e-3);
    world.run(1.0F);
    world.finish();
}

void filters(Run& run) {
    sleepers(run);
    trapdoor(run);
    for (std::uint64_t k = 0; k < run.pick(1U, 5U); ++k) {
        flicker(run, run.seed + k);
    }
    no_change(run);
    ghosts(run);
}

}  // namespace

std::vector<Case> filter_cases() {
    return {{"filter",
             "filters that change at run time: bodies wake, fall, part as the closed forms say",
             filters}};
}

}  // namespace zoned::stability
