// Doors: timetables, and how characters meet doors that are there at some ticks only.
#include "shared/motion/doors.h"

#include "shared/core/rng.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace zoned::motion::doors_test {
namespace {

constexpr float kDt = 1.0F / 30.0F;
constexpr CharacterLimits kLimits;
constexpr float kStand = kLimits.radius + kLimits.half_segment;

Timetable table(Tick period, Tick shift, std::vector<Timetable::OpenSpan> open) {
    Timetable t;
    t.period = period;
    t.shift = shift;
    t.open = std::move(open);
    return t;
}

TEST(Timetables, OpenAsTheirSpansSayAtAnyTick) {
    core::Rng rng(7, 1);
    for (int round = 0; round < 200; ++round) {
        const auto period = static_cast<Tick>(1 + rng.below(40));
        // Spans from random edges; a bit for each tick of a period says the same.
        std::vector<bool> open(static_cast<std::size_t>(period));
        std::vector<Timetable::OpenSpan> spans;
        for (Tick t = 0; t < period; ++t) {
            open[static_cast<std::size_t>(t)] = rng.below(2) == 0;
            if (!open[static_cast<std::size_t>(t)]) {
                continue;
            }
            // Now and then two spans that touch.
            if (!spans.empty() && spans.back().to == t && rng.below(4) != 0) {
                spans.back().to = t + 1;
            } else {
                spans.push_back({t, t + 1});
            }
        }
        const auto shift = static_cast<Tick>(rng.below(static_cast<std::uint32_t>(period)));
        const Timetable times = table(period, shift, spans);
        const auto expected = [&](Tick tick) {
            const Tick phase = ((tick + shift) % period + period) % period;
            return open[static_cast<std::size_t>(phase)];
        };
        for (Tick tick = -100; tick < 100; ++tick) {
            ASSERT_EQ(times.open_at(tick), expected(tick));
            Tick next = tick + 1;
            while (next <= tick + period && expected(next) == expected(tick)) {
                ++next;
            }
            ASSERT_EQ(times.next_change(tick), next > tick + period ? Timetable::kNever : next);
        }
    }
}

TEST(Timetables, BearTheLargestTicks) {
    const Timetable times = table(7, 6, {{0, 3}});
    for (const Tick tick : {INT64_MAX, INT64_MAX - 1, INT64_MIN + 1, INT64_MIN + 2}) {
        const Tick phase = ((tick % 7 + 6) % 7 + 7) % 7;
        EXPECT_EQ(times.open_at(tick), phase < 3);
    }
    EXPECT_TRUE(times.open_at(kAllDoorsOpen)) << "in place of a tick: nothing is shut";
}

/// A wall along z at x = 0 with a doorway of `width` m; the door is shut outside [100, 200).
StaticGeometry walled(float width, float thickness) {
    std::vector<StaticBox> walls(2);
    for (int side = 0; side < 2; ++side) {
        walls[static_cast<std::size_t>(side)].half_extents = Vec3(0.5F * thickness, 2.0F, 10.0F);
        walls[static_cast<std::size_t>(side)].centre =
            Vec3(0.0F, 2.0F, (side == 0 ? 1.0F : -1.0F) * (10.0F + 0.5F * width));
    }
    Door door;
    door.box.half_extents = Vec3(0.5F * thickness, 2.0F, 0.5F * width);
    door.box.centre = Vec3(0.0F, 2.0F, 0.0F);
    door.times = table(1000, 0, {{100, 200}});
    return StaticGeometry(walls, 0.0F, kStaticCell_m, {}, {door});
}

CharacterState standing_at(float x, float z) {
    CharacterState state;
    state.position = Vec3(x, kStand, z);
    state.grounded = true;
    return state;
}

InputCommand go(int x, int z) {
    InputCommand command;
    command.move_x = static_cast<std::int8_t>(x);
    command.move_z = static_cast<std::int8_t>(z);
    return command;
}

TEST(Doors, StopWhoeverComesWhileTheyAreShutAndLetThroughWhileTheyAreOpen) {
    const StaticGeometry world = walled(1.2F, 0.2F);
    CharacterState state = standing_at(-2.0F, 0.0F);
    for (Tick tick = 0; tick < 100; ++tick) {
        state = apply_input(state, go(127, 0), kLimits, world, kDt, tick);
    }
    // In front of the door's face, with the skin that is kept to all boxes.
    EXPECT_NEAR(state.position.x(), -0.1F - kLimits.radius - kSkin, 1e-4F);
    for (Tick tick = 100; tick < 130; ++tick) {
        state = apply_input(state, go(127, 0), kLimits, world, kDt, tick);
    }
    EXPECT_GT(state.position.x(), 2.0F);
    CharacterState free = standing_at(-2.0F, 0.0F);
    for (int i = 0; i < 60; ++i) {
        free = apply_input(free, go(127, 0), kLimits, world, kDt);
    }
    EXPECT_GT(free.position.x(), 2.0F) << "without a tick no door is there";
}

TEST(Doors, AreAsSolidAsBoxes) {
    // The same wall as a box: the same bits, while the door is shut.
    const StaticGeometry doors = walled(1.2F, 0.2F);
    const std::vector<std::uint32_t> all{0};
    const StaticGeometry boxes = doors.with_shut(all);
    ASSERT_EQ(boxes.boxes().size(), 3U);
    const StaticGeometry none = doors.with_shut({});
    ASSERT_EQ(none.boxes().size(), 2U);
    core::Rng rng(3, 1);
    CharacterState a = standing_at(-2.0F, 0.0F);
    CharacterState b = a;
    CharacterState c = a;
    CharacterState d = a;
    for (Tick tick = 0; tick < 600; ++tick) {
        const InputCommand command =
            go(static_cast<int>(rng.below(255)) - 127, static_cast<int>(rng.below(255)) - 127);
        a = apply_input(a, command, kLimits, doors, kDt, 300);
        b = apply_input(b, command, kLimits, boxes, kDt, 300);
        ASSERT_EQ(a.position, b.position);
        ASSERT_EQ(a.velocity, b.velocity);
        c = apply_input(c, command, kLimits, doors, kDt, 150);
        d = apply_input(d, command, kLimits, none, kDt, 150);
        ASSERT_EQ(c.position, d.position);
    }
}

TEST(Doors, PushOutWhoStandsInThemAtWalkingSpeedByTheShortestWay) {
    const StaticGeometry world = walled(1.2F, 0.2F);
    for (const float x : {-0.3F, -0.05F, 0.02F, 0.4F}) {
        CharacterState state = standing_at(x, 0.1F);
        for (Tick tick = 150; tick < 200; ++tick) {
            const CharacterState next = apply_input(state, {}, kLimits, world, kDt, tick);
            EXPECT_EQ(next.position, state.position) << "it stands still in an open door";
        }
        float fastest = 0.0F;
        for (Tick tick = 200; tick < 220; ++tick) {
            const CharacterState next = apply_input(state, {}, kLimits, world, kDt, tick);
            fastest = std::max(fastest, (next.position - state.position).norm() / kDt);
            state = next;
        }
        const float side = x < 0.0F ? -1.0F : 1.0F;
        EXPECT_NEAR(state.position.x(), side * (0.1F + kLimits.radius), 2.0F * kSkin);
        EXPECT_LE(fastest, kLimits.speed * 1.01F);
        const CharacterState last = apply_input(state, {}, kLimits, world, kDt, 220);
        EXPECT_EQ(last.position, state.position) << "and stands still again beside it";
        EXPECT_TRUE(last.grounded);
    }
}

TEST(DoorCourses, HoldFromTheirTickOnAndReplaceThoseAfterThem) {
    DoorCourses courses(2);
    EXPECT_FALSE(courses.open_at(0, 5).has_value()) << "as the timetable says";
    EXPECT_TRUE(courses.announce(0, {10, true}, 0));
    EXPECT_TRUE(courses.announce(0, {20, false}, 0));
    EXPECT_TRUE(courses.announce(0, {20, false}, 0)) << "twice changes nothing";
    EXPECT_FALSE(courses.open_at(0, 9).has_value());
    EXPECT_EQ(courses.open_at(0, 10), true);
    EXPECT_EQ(courses.open_at(0, 19), true);
    EXPECT_EQ(courses.open_at(0, 20), false);
    EXPECT_FALSE(courses.open_at(1, 20).has_value());
    ASSERT_EQ(courses.from(0, 12).size(), 2U) << "the one that holds, and the next";
    EXPECT_TRUE(courses.announce(0, {15, false}, 0));
    EXPECT_EQ(courses.open_at(0, 17), false);
    EXPECT_EQ(courses.from(0, 15).size(), 1U) << "the one for tick 20 was replaced";
}

TEST(DoorCourses, ForgetTheOldestAndRefuseMoreAheadThanTheyKeep) {
    constexpr Tick kMost = DoorCourses::kMostCourses;
    DoorCourses courses(1);
    for (Tick t = 1; t <= kMost; ++t) {
        EXPECT_TRUE(courses.announce(0, {t, t % 2 == 0}, 0)) << t;
    }
    EXPECT_FALSE(courses.announce(0, {kMost + 1, true}, 0)) << "the first must be kept";
    EXPECT_EQ(courses.open_at(0, kMost + 1), true) << "a refused one changes nothing";
    EXPECT_FALSE(courses.announce(0, {kMost + 1, true}, 1)) << "the first holds now";
    EXPECT_TRUE(courses.announce(0, {kMost + 1, true}, 2));
    EXPECT_FALSE(courses.open_at(0, 1).has_value()) << "forgotten";
    for (Tick t = 2; t <= kMost; ++t) {
        EXPECT_EQ(courses.open_at(0, t), t % 2 == 0);
    }
}

TEST(Doors, ThatRulesMoveAreAsTheirCoursesSay) {
    Door bridge;
    bridge.box.centre = Vec3(0.0F, 3.9F, 0.0F);
    bridge.box.half_extents = Vec3(2.0F, 0.1F, 2.0F);
    bridge.times = table(1, 0, {});
    bridge.by_rules = 3;  // of the world
    const auto courses = std::make_shared<DoorCourses>(4);
    const StaticGeometry untold({}, 0.0F, kStaticCell_m, {}, {bridge});
    const StaticGeometry told = untold.with_courses(courses);
    courses->announce(3, {10, true}, 0);
    EXPECT_TRUE(told.shut_at(0, 9));
    EXPECT_FALSE(told.shut_at(0, 10));
    EXPECT_TRUE(untold.shut_at(0, 10)) << "copies share the boxes, not what they were told";
    EXPECT_FALSE(told.shut_at(0, kAllDoorsOpen));
    EXPECT_EQ(told.next_turn(4), 5) << "a course may come in any tick";
    CharacterState state = standing_at(0.0F, 0.0F);
    state.position.y() = 4.0F + kStand + kSkin;
    for (Tick tick = 0; tick < 60; ++tick) {
        state = apply_input(state, go(0, 0), kLimits, told, kDt, tick);
        if (tick < 10) {
            ASSERT_NEAR(state.position.y(), 4.0F + kStand, 2.0F * kSkin);
        }
    }
    EXPECT_FLOAT_EQ(state.position.y(), kStand);
}

TEST(Doors, DropWhoStandsOnThemWhenTheyOpen) {
    // A bridge, over ground four metres below.
    Door bridge;
    bridge.box.centre = Vec3(0.0F, 3.9F, 0.0F);
    bridge.box.half_extents = Vec3(2.0F, 0.1F, 2.0F);
    bridge.times = table(1000, 0, {{100, 200}});
    const StaticGeometry world({}, 0.0F, kStaticCell_m, {}, {bridge});
    CharacterState state = standing_at(0.0F, 0.0F);
    state.position.y() = 4.0F + kStand + kSkin;
    for (Tick tick = 0; tick < 100; ++tick) {
        state = apply_input(state, go(0, 0), kLimits, world, kDt, tick);
        ASSERT_NEAR(state.position.y(), 4.0F + kStand, 2.0F * kSkin);
    }
    for (Tick tick = 100; tick < 160; ++tick) {
        state = apply_input(state, go(0, 0), kLimits, world, kDt, tick);
    }
    EXPECT_FLOAT_EQ(state.position.y(), kStand);
}

TEST(Doors, NeverLeaveAnyoneInAWall) {
    // Doors that shut and open about walkers in a narrow yard: no walker ever ends up in a wall, or
    // in a door that has been shut for a while.
    core::Rng rng(11, 1);
    std::vector<StaticBox> walls;
    std::vector<Door> doors;
    for (int i = 0; i < 12; ++i) {
        StaticBox box;
        box.centre = Vec3(rng.range(-6.0F, 6.0F), 1.0F, rng.range(-6.0F, 6.0F));
        box.half_extents = Vec3(rng.range(0.1F, 1.5F), 2.0F, 0.15F);
        box.orientation = orientation_from_yaw(static_cast<std::uint16_t>(rng.below(65536)));
        if (i < 6) {
            walls.push_back(box);
        } else {
            const auto from = static_cast<Tick>(rng.below(50));
            doors.push_back({box, table(90, 0, {{from, from + 40}})});
        }
    }
    const StaticGeometry world(walls, 0.0F, kStaticCell_m, {}, doors);
    const StaticGeometry bare(walls, 0.0F);
    for (int walker = 0; walker < 20; ++walker) {
        CharacterState state = standing_at(7.0F, rng.range(-7.0F, 7.0F));
        InputCommand command;
        for (Tick tick = 0; tick < 900; ++tick) {
            if (rng.below(10) == 0) {
                command = go(static_cast<int>(rng.below(255)) - 127,
                             static_cast<int>(rng.below(255)) - 127);
            }
            if (state.position.head<1>().norm() > 7.0F || std::abs(state.position.z()) > 7.0F) {
                command = go(state.position.x() > 0.0F ? -127 : 127,
                             state.position.z() > 0.0F ? -127 : 127);
            }
            state = apply_input(state, command, kLimits, world, kDt, tick);
            const CapsuleSweep alone(
                bare, {kLimits.radius, kLimits.half_segment}, {state.position, state.position});
            ASSERT_LT((alone.parted(state.position) - state.position).norm(), 0.005F)
                << "walker " << walker << " at tick " << tick;
        }
    }
}

}  // namespace
}  // namespace zoned::motion::doors_test
