// Platforms: where they are at each tick, and how they carry, push and let through characters.
#include "shared/core/rng.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"
#include "shared/motion/platforms/platform_carry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace zoned::motion::platforms_test {
namespace {

constexpr float kDt = 1.0F / 30.0F;
constexpr CharacterLimits kLimits;
constexpr Capsule kCapsule{kLimits.radius, kLimits.half_segment};
constexpr float kStand = kLimits.radius + kLimits.half_segment;

StaticBox box(const Vec3& centre, const Vec3& half) {
    StaticBox out;
    out.centre = centre;
    out.half_extents = half;
    return out;
}

/// A path through places, at a speed, as the config lays one out.
PlatformPath path(const std::vector<Vec3>& places, float speed, Tick wait, bool loop = false) {
    PlatformPath out;
    out.wait = wait;
    const auto ticks = [&](const Vec3& a, const Vec3& b) {
        return std::max<Tick>(1, static_cast<Tick>(std::ceil((b - a).norm() / (speed * kDt))));
    };
    Tick at = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        at += i == 0 ? 0 : ticks(places[i - 1], places[i]);
        PlatformStop& stop = out.stops.emplace_back();
        stop.at = at;
        for (int axis = 0; axis < 3; ++axis) {
            stop.offset[axis] =
                on_platform_step(static_cast<double>(places[i][axis] - places[0][axis]));
        }
    }
    out.back = loop ? ticks(places.back(), places.front()) : 0;
    return out;
}

StaticGeometry world_of(std::vector<Platform> platforms, std::vector<StaticBox> walls = {}) {
    return StaticGeometry(std::move(walls), 0.0F, kStaticCell_m, {}, {}, std::move(platforms));
}

InputCommand go(int x, int z, std::uint16_t buttons = 0) {
    InputCommand command;
    command.move_x = static_cast<std::int8_t>(x);
    command.move_z = static_cast<std::int8_t>(z);
    command.buttons = buttons;
    return command;
}

CharacterState standing_at(const Vec3& feet) {
    CharacterState state;
    state.position = feet + Vec3(0.0F, kStand + kSkin, 0.0F);
    state.grounded = true;
    return state;
}

float gap(const Vec3& position, const StaticGeometry& world, std::uint32_t platform, Tick tick) {
    return distance_to(kCapsule,
                       position,
                       world.platform_box(platform, tick),
                       world.platform_axes(platform))
               .distance -
           kLimits.radius;
}

TEST(PlatformPath, GoesByItsTimesWithoutSkippingATickAtAnyTick) {
    core::Rng rng(3, 1);
    for (int round = 0; round < 200; ++round) {
        PlatformPath it;
        Tick at = 0;
        const auto stops = 2 + static_cast<int>(rng.below(4));
        for (int i = 0; i < stops; ++i) {
            it.stops.push_back({Vec3(static_cast<float>(i), 0.0F, 0.0F), at});
            at += 1 + static_cast<Tick>(rng.below(9));
        }
        it.back = rng.below(2) == 0 ? 0 : 1 + static_cast<Tick>(rng.below(9));
        it.wait = static_cast<Tick>(rng.below(5));
        it.shift = static_cast<Tick>(rng.below(100));
        // The round, tick by tick.
        std::vector<Tick> round_trip;
        const auto travel = [&](Tick from, Tick to) {
            for (Tick t = 0; t < it.wait; ++t) {
                round_trip.push_back(from);
            }
            for (Tick t = from; t != to; t += to > from ? 1 : -1) {
                round_trip.push_back(t);
            }
        };
        for (std::size_t i = 0; i + 1 < it.stops.size(); ++i) {
            travel(it.stops[i].at, it.stops[i + 1].at);
        }
        if (it.back > 0) {
            travel(it.stops.back().at, it.length());
        } else {
            for (std::size_t i = it.stops.size() - 1; i > 0; --i) {
                travel(it.stops[i].at, it.stops[i - 1].at);
            }
        }
        ASSERT_EQ(it.period(), static_cast<Tick>(round_trip.size()));
        for (Tick tick = -150; tick < 150; ++tick) {
            const Tick phase = ((tick + it.shift) % it.period() + it.period()) % it.period();
            ASSERT_EQ(it.along_at(tick), round_trip[static_cast<std::size_t>(phase)])
                << "tick " << tick;
        }
    }
}

TEST(PlatformPath, PlacesAreMultiplesOfTheStepAtItsSpeed) {
    const std::vector<Vec3> places = {
        Vec3(3.3F, 0.1F, -7.0F), Vec3(3.3F, 9.7F, -7.0F), Vec3(-20.0F, 9.7F, 5.0F)};
    const PlatformPath it = path(places, 1.7F, 10, true);
    for (Tick along = 0; along < it.length(); ++along) {
        const Vec3 here = it.offset(along);
        for (const float coordinate : here) {
            ASSERT_EQ(coordinate, on_platform_step(static_cast<double>(coordinate)));
        }
        ASSERT_LE((it.offset(along + 1) - here).norm(),
                  1.7F * kDt + 2.0F * static_cast<float>(kPlatformStep_m));
    }
    EXPECT_EQ(it.offset(it.length()), it.offset(0));
    EXPECT_EQ(it.offset(it.stops[1].at), it.stops[1].offset);
}

TEST(Platforms, ARiderWhoStandsKeepsItsPlaceToTheBitForHours) {
    // Up, down, sideways and round, some hundred metres from the origin.
    const std::vector<Vec3> places = {Vec3(-200.3F, 1.0F, 311.7F),
                                      Vec3(-200.3F, 25.4F, 311.7F),
                                      Vec3(-170.9F, 3.0F, 290.1F),
                                      Vec3(-230.0F, 0.6F, 300.0F)};
    const StaticGeometry world =
        world_of({{box(places[0], Vec3(2.0F, 0.25F, 2.0F)), path(places, 2.7F, 17, true)}});
    CharacterState state = standing_at(places[0] + Vec3(0.71F, 0.25F, -0.33F));
    state.velocity = platform_velocity(world, 0, kDt, 0);
    std::optional<Vec3> relative;
    Vec3 farthest = Vec3::Zero();
    for (Tick tick = 1; tick < 400'000; ++tick) {
        state = apply_input(state, {}, kLimits, world, kDt, tick);
        ASSERT_TRUE(state.grounded) << tick;
        const Vec3 at = state.position - world.platform_box(0, tick).centre;
        if (tick > 1000 && !relative) {
            relative = at;
        }
        if (relative) {
            ASSERT_EQ(at, *relative) << "tick " << tick;
        }
        ASSERT_EQ(state.velocity, platform_velocity(world, 0, kDt, tick)) << tick;
        farthest = farthest.cwiseMax(world.platform_offset(0, tick).cwiseAbs());
    }
    EXPECT_GT(farthest.minCoeff(), 20.0F) << "the platform went places";
}

TEST(Platforms, WalkingIsRelativeToThem) {
    const std::vector<Vec3> places = {Vec3(0.0F, 1.0F, 0.0F), Vec3(60.0F, 16.0F, 0.0F)};
    const Platform ferry{box(places[0], Vec3(6.0F, 0.25F, 6.0F)), path(places, 3.0F, 0)};
    const StaticGeometry moving = world_of({ferry});
    Platform parked = ferry;
    parked.path.by_rules = 0;
    const StaticGeometry standing = world_of({parked});
    CharacterState a = standing_at(Vec3(-4.0F, 1.25F, -4.0F));
    CharacterState b = a;
    a.velocity = platform_velocity(moving, 0, kDt, 0);
    core::Rng rng(4, 1);
    InputCommand command;
    for (Tick tick = 1; tick < 300; ++tick) {
        if (tick % 15 == 0) {
            const Vec3 middle = -b.position;  // never off the edge
            command = go(static_cast<int>(middle.x() * 20.0F) + static_cast<int>(rng.below(31)),
                         static_cast<int>(middle.z() * 20.0F) + static_cast<int>(rng.below(31)));
        }
        a = apply_input(a, command, kLimits, moving, kDt, tick);
        b = apply_input(b, command, kLimits, standing, kDt, tick);
        const Vec3 relative = a.position - moving.platform_offset(0, tick);
        // Rounding of 300 ticks of 1e-6 m each; velocities differ by that of steps of the platform.
        ASSERT_LT((relative - b.position).norm(), 2e-3F) << "tick " << tick;
    }
}

TEST(Platforms, AJumpStraightUpComesDownWhereItBegan) {
    for (const Vec3& way : {Vec3(80.0F, 0.0F, 0.0F), Vec3(40.0F, 30.0F, 0.0F)}) {
        const std::vector<Vec3> places = {Vec3(0.0F, 40.0F, 0.0F), Vec3(0.0F, 40.0F, 0.0F) + way};
        const StaticGeometry world =
            world_of({{box(places[0], Vec3(3.0F, 0.25F, 3.0F)), path(places, 4.0F, 0)}});
        CharacterState state = standing_at(Vec3(0.0F, 40.25F, 0.0F));
        Tick tick = 1;
        for (; tick < 20; ++tick) {
            state = apply_input(state, {}, kLimits, world, kDt, tick);
        }
        const Vec3 before = state.position - world.platform_offset(0, tick - 1);
        float highest = 0.0F;
        for (int i = 0; i < 60; ++i, ++tick) {
            state =
                apply_input(state, go(0, 0, i == 0 ? kButtonJump : 0), kLimits, world, kDt, tick);
            const Vec3 now = state.position - world.platform_offset(0, tick);
            highest = std::max(highest, now.y() - before.y());
        }
        ASSERT_TRUE(state.grounded);
        const Vec3 after = state.position - world.platform_offset(0, tick - 1);
        EXPECT_LT((after - before).norm(), 0.02F) << (after - before).transpose();
        EXPECT_NEAR(
            highest, kLimits.jump_speed * kLimits.jump_speed / (2.0F * kLimits.gravity), 0.05F);
    }
}

TEST(Platforms, WalkingOffKeepsTheirVelocity) {
    const std::vector<Vec3> places = {Vec3(0.0F, 20.0F, 0.0F), Vec3(80.0F, 20.0F, 0.0F)};
    const StaticGeometry world =
        world_of({{box(places[0], Vec3(2.0F, 0.25F, 2.0F)), path(places, 3.0F, 0)}});
    CharacterState state = standing_at(Vec3(0.0F, 20.25F, 0.0F));
    Tick tick = 1;
    while (state.grounded && tick < 200) {
        state = apply_input(state, go(0, 127), kLimits, world, kDt, tick++);
    }
    ASSERT_FALSE(state.grounded);
    EXPECT_NEAR(state.velocity.x(), 3.0F, 0.01F);
    EXPECT_NEAR(state.velocity.z(), kLimits.speed, 0.01F);
}

TEST(Platforms, PushWhoStandsInTheirWayAside) {
    // A block that comes along the ground, at walking and at the highest speed.
    for (const float speed : {1.0F, 20.0F}) {
        const std::vector<Vec3> places = {Vec3(-10.0F, 1.0F, 0.0F), Vec3(30.0F, 1.0F, 0.0F)};
        const StaticGeometry world =
            world_of({{box(places[0], Vec3(1.0F, 0.99F, 3.0F)), path(places, speed, 0)}});
        CharacterState state = standing_at(Vec3::Zero());
        const Tick end = world.platforms()[0].path.length();
        for (Tick tick = 1; tick < end; ++tick) {
            state = apply_input(state, {}, kLimits, world, kDt, tick);
            ASSERT_GT(gap(state.position, world, 0, tick), -1e-4F) << "tick " << tick;
            ASSERT_LT(state.velocity.norm(), 1.0F);
        }
        const float front = world.platform_box(0, end - 1).centre.x() + 1.0F;
        EXPECT_NEAR(state.position.x(), front + kLimits.radius, 0.01F);
        EXPECT_NEAR(state.position.y(), kStand, 0.01F);
    }
}

TEST(Platforms, LetThroughWhomTheyWouldCrush) {
    // Down on the ground, up against a roof, and sideways into a wall.
    struct Case {
        Vec3 from;
        Vec3 to;
        Vec3 half;
        Vec3 feet;
        std::vector<StaticBox> walls;
    };

    const std::vector<Case> cases = {
        {Vec3(0, 6, 0), Vec3(0, 0.3F, 0), Vec3(2, 0.25F, 2), Vec3(0, 0, 0), {}},
        {Vec3(0, 1, 0),
         Vec3(0, 8, 0),
         Vec3(2, 0.25F, 2),
         Vec3(0, 1.25F, 0),
         {box(Vec3(0, 5, 0), Vec3(1, 0.2F, 1))}},
        {Vec3(-8, 1, 0),
         Vec3(8, 1, 0),
         Vec3(1, 0.9F, 2),
         Vec3(0, 0, 0),
         {box(Vec3(2, 2, 0), Vec3(0.5F, 2, 5))}}};
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const Case& c = cases[i];
        const StaticGeometry world =
            world_of({{box(c.from, c.half), path({c.from, c.to}, 2.0F, 15)}}, c.walls);
        const StaticGeometry bare = world.without_platforms();
        CharacterState state = standing_at(c.feet);
        bool inside = false;
        for (Tick tick = 1; tick < 2000; ++tick) {
            const Vec3 before = state.position;
            state = apply_input(state, {}, kLimits, world, kDt, tick);
            ASSERT_TRUE(state.position.allFinite() && state.velocity.allFinite());
            // Nothing is thrown: not faster than the platform and gravity make it.
            ASSERT_LT((state.position - before).norm(), 0.4F) << "case " << i << " tick " << tick;
            ASSERT_LT(state.velocity.norm(), 11.0F);
            const CapsuleSweep alone(bare, kCapsule, {state.position, state.position});
            ASSERT_LT((alone.parted(state.position) - state.position).norm(), 0.002F)
                << "case " << i << " tick " << tick << ": in a wall";
            inside = inside || gap(state.position, world, 0, tick) < -0.1F;
        }
        EXPECT_TRUE(inside) << "case " << i << ": it was to be crushed";
        EXPECT_TRUE(state.grounded);
    }
}

TEST(Platforms, RulesMoveThemByCourses) {
    PlatformPath it = path({Vec3(0, 1, 0), Vec3(0, 5, 0), Vec3(6, 5, 0)}, 2.0F, 0);
    it.by_rules = 3;
    it.start = it.stops[1].at;
    const StaticGeometry untold = world_of({{box(Vec3(0, 1, 0), Vec3(2, 0.25F, 2)), it}});
    const auto courses = std::make_shared<PlatformCourses>(4);
    const StaticGeometry told = untold.with_courses(nullptr, courses);
    EXPECT_EQ(told.platform_offset(0, 50), it.stops[1].offset);
    const Tick top = it.stops[1].at;
    ASSERT_TRUE(courses->announce(3, {100, top, it.length()}, 80));
    EXPECT_EQ(told.along_at(0, 99), top);
    EXPECT_EQ(told.along_at(0, 100), top);
    EXPECT_EQ(told.along_at(0, 110), top + 10);
    EXPECT_EQ(told.along_at(0, 10'000), it.length());
    // Turned round under way.
    ASSERT_TRUE(courses->announce(3, {120, told.along_at(0, 120), 0}, 100));
    EXPECT_EQ(told.along_at(0, 120), top + 20);
    EXPECT_EQ(told.along_at(0, 125), top + 15);
    EXPECT_EQ(told.platform_offset(0, 10'000), Vec3(Vec3::Zero()));
    EXPECT_EQ(untold.platform_offset(0, 10'000), it.stops[1].offset);
}

TEST(Platforms, FarAwayOnesChangeNoBit) {
    core::Rng rng(9, 1);
    std::vector<StaticBox> walls;
    for (int i = 0; i < 60; ++i) {
        walls.push_back(
            box(Vec3(rng.range(-12.0F, 12.0F), rng.range(0.0F, 2.0F), rng.range(-12.0F, 12.0F)),
                Vec3(rng.range(0.1F, 2.0F), rng.range(0.1F, 1.0F), rng.range(0.1F, 2.0F))));
    }
    const StaticGeometry bare = world_of({}, walls);
    const StaticGeometry world = world_of({{box(Vec3(60, 1, 0), Vec3(2, 0.25F, 2)),
                                            path({Vec3(60, 1, 0), Vec3(60, 9, 30)}, 2.0F, 15)}},
                                          walls);
    CharacterState a = standing_at(Vec3(0, 5, 0));
    CharacterState b = a;
    for (Tick tick = 0; tick < 3000; ++tick) {
        const InputCommand command = go(static_cast<int>(rng.below(255)) - 127,
                                        static_cast<int>(rng.below(255)) - 127,
                                        rng.below(8) == 0 ? kButtonJump : 0);
        a = apply_input(a, command, kLimits, bare, kDt, tick);
        b = apply_input(b, command, kLimits, world, kDt, tick);
        ASSERT_EQ(a.position, b.position);
        ASSERT_EQ(a.velocity, b.velocity);
    }
}

/// Platforms of all kinds about a yard of walls.
struct PlatformYard {
    explicit PlatformYard(std::uint64_t seed) {
        core::Rng rng(seed, 1);
        for (int i = 0; i < 10; ++i) {
            walls.push_back(
                box(Vec3(rng.range(-7.0F, 7.0F), rng.range(0.0F, 3.0F), rng.range(-7.0F, 7.0F)),
                    Vec3(rng.range(0.2F, 2.0F), rng.range(0.1F, 1.5F), rng.range(0.2F, 2.0F))));
            walls.back().orientation =
                orientation_from_yaw(static_cast<std::uint16_t>(rng.below(65536)));
        }
        const auto courses = std::make_shared<PlatformCourses>(8);
        std::vector<Platform> platforms;
        for (std::uint32_t i = 0; i < 8; ++i) {
            std::vector<Vec3> places;
            const auto stops = 2 + rng.below(3);
            for (std::uint32_t s = 0; s < stops; ++s) {
                places.emplace_back(
                    rng.range(-7.0F, 7.0F), rng.range(0.1F, 4.0F), rng.range(-7.0F, 7.0F));
            }
            Platform it{
                box(places[0],
                    Vec3(rng.range(0.3F, 2.5F), rng.range(0.1F, 1.0F), rng.range(0.3F, 2.5F))),
                path(places,
                     rng.range(0.5F, 8.0F),
                     static_cast<Tick>(rng.below(40)),
                     rng.below(2) == 0)};
            it.box.orientation = orientation_from_yaw(static_cast<std::uint16_t>(rng.below(65536)));
            if (i % 3 == 0) {
                it.path.by_rules = i;
                it.path.back = 0;
                // As many as are kept; the last one holds.
                PlatformCourse before;
                for (Tick from = 10; from < 2400; from += 80 + static_cast<Tick>(rng.below(60))) {
                    const auto stop = rng.below(static_cast<std::uint32_t>(it.path.stops.size()));
                    const PlatformCourse course{
                        from, before.along_at(from), it.path.stops[stop].at};
                    if (courses->announce(i, course, from - 9)) {
                        before = course;
                    }
                }
            }
            platforms.push_back(it);
        }
        bare = world_of({}, walls);
        world = world_of(std::move(platforms), walls).with_courses(nullptr, courses);
    }

    std::vector<StaticBox> walls;
    StaticGeometry bare;
    StaticGeometry world;
};

/// Whether something fixed, or another platform, is where a platform would push the character.
bool held(const PlatformYard& yard, const Vec3& position, std::uint32_t platform, Tick tick) {
    const Aabb here = Aabb{position, position}.grown(2.0F);
    const SegmentBoxDistance found = distance_to(kCapsule,
                                                 position,
                                                 yard.world.platform_box(platform, tick),
                                                 yard.world.platform_axes(platform));
    // Within a tick another platform may have held it and gone on.
    const Vec3 out = yard.world.platform_axes(platform) * found.normal * 8.0F * kDt;
    PassedPlatforms all;
    all.add(platform);
    const CapsuleSweep sweep(yard.world, kCapsule, here, tick, &all);
    return sweep.sweep(position, out).hit;
}

TEST(Platforms, NeverLeaveAnyoneInAWallOrInThemselvesButWhomTheyCrush) {
    int let_through = 0;
    int rides = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const PlatformYard yard(seed);
        core::Rng rng(100 + seed, 1);
        for (int walker = 0; walker < 20; ++walker) {
            CharacterState state = standing_at(Vec3(9.0F, 0.0F, rng.range(-9.0F, 9.0F)));
            InputCommand command;
            std::array<bool, 8> inside{};
            for (Tick tick = 1; tick < 1500; ++tick) {
                if (rng.below(12) == 0) {
                    command = go(static_cast<int>(rng.below(255)) - 127,
                                 static_cast<int>(rng.below(255)) - 127,
                                 rng.below(3) == 0 ? kButtonJump : 0);
                    if (rng.below(3) == 0) {
                        command = {};
                    }
                }
                if (std::abs(state.position.x()) > 9.0F || std::abs(state.position.z()) > 9.0F) {
                    command = go(state.position.x() > 0.0F ? -127 : 127,
                                 state.position.z() > 0.0F ? -127 : 127);
                }
                const CharacterState before = state;
                const bool may_rest =
                    !moved_by_platform(before.position, kLimits, yard.world, tick);
                state = apply_input(before, command, kLimits, yard.world, kDt, tick);
                const auto where = [&] {
                    return testing::Message()
                           << "seed " << seed << " walker " << walker << " tick " << tick;
                };
                ASSERT_TRUE(state.position.allFinite() && state.velocity.allFinite()) << where();
                if (may_rest && before.grounded && before.velocity.isZero(0.0F) &&
                    command.move_x == 0 && command.move_z == 0 && command.buttons == 0) {
                    ASSERT_EQ(state.position, before.position) << where();
                }
                // The fastest platform and a sprint, and a fall of the height of the yard.
                ASSERT_LT((state.position - before.position).norm(), 0.9F) << where();
                const CapsuleSweep alone(yard.bare, kCapsule, {state.position, state.position});
                ASSERT_LT((alone.parted(state.position) - state.position).norm(), 0.005F)
                    << where();
                for (std::uint32_t p = 0; p < 8; ++p) {
                    const bool in = gap(state.position, yard.world, p, tick) < 0.0F;
                    if (in && !inside[p]) {
                        // Pressed there before it walked on.
                        const PlatformCarry pressed =
                            carry_by_platforms(before, kLimits, yard.world, kDt, tick);
                        ASSERT_TRUE(held(yard, pressed.position, p, tick))
                            << where() << ": in platform " << p << " by "
                            << gap(state.position, yard.world, p, tick);
                        ++let_through;
                    }
                    inside[p] = in;
                }
                rides +=
                    state.grounded && state.position.y() > 1.2F && state.velocity.norm() > 0.1F;
            }
        }
    }
    EXPECT_GT(let_through, 20) << "the yard was to crush somebody";
    EXPECT_GT(rides, 3000) << "somebody was to ride";
}

}  // namespace
}  // namespace zoned::motion::platforms_test
