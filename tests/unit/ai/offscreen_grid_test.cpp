// build: computes
// The off-screen grid holds suspended agents by their squares; the event queue gives their next
// changes by tick.
#include "server/ai/agent/offscreen_grid.h"

#include "server/ai/agent/agent_event_queue.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

namespace zoned::ai {
namespace {

using namespace test;

/// The entries that the queue should return at `now`, by a pass over all planned ones.
std::set<std::uint32_t> due_of(const std::map<std::uint32_t, Tick>& planned, Tick now) {
    std::set<std::uint32_t> due;
    for (const auto& [slot, at] : planned) {
        if (at <= now) {
            due.insert(slot);
        }
    }
    return due;
}

TEST(AgentEventQueue, HandsOutWhatALookAtAllThatWasPlannedFinds) {
    constexpr std::uint32_t kSlots = 300;
    core::Rng rng(5);
    AgentEventQueue queue;
    queue.grow(kSlots);
    std::map<std::uint32_t, Tick> planned;
    std::size_t taken = 0;
    Tick now = 0;
    for (int step = 0; step < 20'000; ++step) {
        // Now and then the queue is not asked for longer than its year.
        now += rng.below(500) == 0 ? 9'000 : 1;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t slot = rng.below(kSlots);
            const std::uint32_t kind = rng.below(10);
            if (kind == 0) {
                queue.cancel(slot);
                planned.erase(slot);
                continue;
            }
            // Overdue entries, entries of a later year, and entries due soon.
            const Tick at = kind == 1   ? std::max<Tick>(0, now - rng.below(50))
                            : kind == 2 ? now + 4'000 + rng.below(20'000)
                                        : now + rng.below(100);
            queue.schedule(slot, at);
            planned[slot] = at;
        }
        std::set<std::uint32_t> due;
        queue.take_due(now, [&](std::uint32_t slot, Tick at) {
            EXPECT_EQ(at, planned.at(slot));
            due.insert(slot);
        });
        ASSERT_EQ(due, due_of(planned, now)) << "at tick " << now;
        for (const std::uint32_t slot : due) {
            EXPECT_EQ(queue.at(slot), kNever);
            planned.erase(slot);
        }
        taken += due.size();
    }
    EXPECT_GT(taken, 20'000U);
}

TEST(AgentEventQueue, NeverIsNoEvent) {
    AgentEventQueue queue;
    queue.grow(2);
    queue.schedule(0, 7);
    queue.schedule(0, kNever);
    queue.schedule(1, 7);
    std::vector<std::uint32_t> due;
    queue.take_due(10, [&](std::uint32_t slot, Tick /*at*/) { due.push_back(slot); });
    EXPECT_EQ(due, std::vector<std::uint32_t>{1});
}

/// A walk of the kinds that there are: on, to a halt, from one direction to another, and by
/// characters that take long to turn.
PathSegment some_segment(core::Rng& rng, Tick since) {
    const auto heading = [&rng] {
        const float turn = rng.range(0.0F, 6.28F);
        return Vec2(std::cos(turn), std::sin(turn));
    };
    const float speed = rng.below(5) == 0 ? 0.0F : rng.range(0.5F, 9.0F);
    const float acceleration =
        rng.below(2) == 0 ? 0.0F
                          : (rng.below(3) == 0 ? rng.range(0.1F, 1.0F) : rng.range(1.0F, 20.0F));
    PathSegment segment = segment_from(Vec2(rng.range(-200.0F, 200.0F), rng.range(-200.0F, 200.0F)),
                                       heading() * rng.range(0.0F, 9.0F),
                                       heading(),
                                       speed,
                                       acceleration,
                                       since);
    segment.length = speed > 0.0F && rng.below(4) != 0 ? rng.range(1.0F, 700.0F) : 0.0F;
    // Without a length it is a step with a herd.
    segment.goal =
        segment.from +
        segment.direction * (segment.length > 0.0F ? segment.length : rng.range(0.5F, 20.0F));
    return segment;
}

/// After that it walks on.
Tick end_of_step(const PathSegment& segment) {
    return segment.since +
           static_cast<Tick>((segment.goal - segment.from).norm() / (segment.speed * kDt)) + 2;
}

/// Whether the slot is in a square that comes as near to `at`, or may be anywhere.
bool is_near(const OffscreenGrid& cells, OffscreenGrid::Slot slot, const Vec2& at, float near_m) {
    bool found = false;
    const auto look = [&](OffscreenGrid::Slot s) {
        found = found || s == slot;
    };
    std::vector<OffscreenGrid::Cell> around;
    OffscreenGrid::within(std::span(&at, 1), near_m, around);
    for (const OffscreenGrid::Cell cell : around) {
        cells.visit(cell, look);
    }
    cells.visit_anywhere(look);
    return found;
}

/// Each piece is followed until the walker leaves it. A place some hundred metres from the origin
/// is rounded by less than 1 mm.
TEST(OffscreenGrid, HoldWhoComesThroughWhereverThatIs) {
    constexpr std::uint32_t kSlots = 50;
    const Vec2 everywhere = Vec2::Constant(std::numeric_limits<float>::infinity());
    core::Rng rng(6);
    OffscreenGrid cells;
    cells.grow(kSlots);
    std::array<PathSegment, kSlots> segments;
    std::array<Vec2, kSlots> placed;
    std::size_t looks = 0;
    std::size_t anywhere = 0;
    for (int step = 0; step < 4'000; ++step) {
        const std::uint32_t slot = rng.below(kSlots);
        PathSegment& segment = segments[slot];
        segment = some_segment(rng, 1'000);
        Tick now = 1'001;
        // From piece to piece: a walker that leaves one is put into the next.
        for (int piece = 0; piece < 3; ++piece) {
            placed[slot] = position_at(segment, now - 1, kDt);
            // Half of them have no event at the end of their segment.
            cells.put(slot, segment, placed[slot], kDt, slot % 2 == 0);
            const bool goes_on = slot % 2 == 0;
            const Tick left =
                OffscreenGrid::left_at(segment, placed[slot], everywhere, kDt, goes_on);
            ASSERT_GT(left, now - 2);
            const bool ends = !goes_on && segment.speed > 0.0F;
            const Tick last = !ends                   ? kNever
                              : segment.length > 0.0F ? arrival_of(segment, kDt) + 1
                                                      : end_of_step(segment);
            const Tick end = std::min({left, now + 4'000, last});
            for (; now < end; now += 1 + rng.below(20)) {
                const Vec2 at = position_at(segment, now - 1, kDt);
                ASSERT_TRUE(is_near(cells, slot, at, OffscreenGrid::kAside_m + 1e-3F))
                    << "step " << step << " at tick " << now << ", " << at.transpose();
                ++looks;
            }
            now = std::max(end, now) + 1;
        }
        bool is_anywhere = false;
        cells.visit_anywhere(
            [&](OffscreenGrid::Slot s) { is_anywhere = is_anywhere || s == slot; });
        anywhere += is_anywhere ? 1U : 0U;
        if (rng.below(4) == 0) {
            cells.take(slot);
            for (std::uint32_t cell = 0; cell < 128U * 128U; cell += 1 + rng.below(40)) {
                cells.visit(cell, [&](OffscreenGrid::Slot s) { EXPECT_NE(s, slot); });
            }
            EXPECT_FALSE(is_near(cells, slot, placed[slot], 200.0F));
        }
    }
    EXPECT_GT(looks, 100'000U);
    EXPECT_LT(anywhere, 400U) << "few turn so slowly";
    EXPECT_GT(anywhere, 0U) << "some do";
}

TEST(OffscreenGrid, AreTheSameFromWhereverOnThePieceTheyAreAsked) {
    core::Rng rng(7);
    const Vec2 everywhere = Vec2::Constant(std::numeric_limits<float>::infinity());
    int asked = 0;
    for (int i = 0; i < 2'000; ++i) {
        const PathSegment segment = some_segment(rng, 1'000);
        const Vec2 start = position_at(segment, 1'000, kDt);
        const Tick left = OffscreenGrid::left_at(segment, start, everywhere, kDt);
        const Tick later = std::min<Tick>(left - 2, 1'000 + rng.below(500));
        if (later <= 1'000) {
            continue;
        }
        const Vec2 at = position_at(segment, later, kDt);
        EXPECT_EQ(OffscreenGrid::left_at(segment, at, everywhere, kDt), left);
        ++asked;
    }
    EXPECT_GT(asked, 1'000);
}

TEST(OffscreenGrid, WithinFindsTheSquareOfEveryPlaceInReach) {
    core::Rng rng(8);
    std::vector<OffscreenGrid::Cell> found;
    for (int i = 0; i < 2'000; ++i) {
        const std::vector<Vec2> viewers = {
            Vec2(rng.range(-3'000.0F, 3'000.0F), rng.range(-3'000.0F, 3'000.0F)),
            Vec2(rng.range(-300.0F, 300.0F), rng.range(-300.0F, 300.0F))};
        const float radius = rng.range(1.0F, 150.0F);
        OffscreenGrid::within(viewers, radius, found);
        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
        for (int k = 0; k < 20; ++k) {
            const float turn = rng.range(0.0F, 6.28F);
            const float way = rng.range(0.0F, 0.999F) * radius;
            const Vec2 at = viewers[rng.below(2)] + way * Vec2(std::cos(turn), std::sin(turn));
            EXPECT_TRUE(std::binary_search(found.begin(), found.end(), OffscreenGrid::cell_at(at)));
        }
    }
}

/// The tick is the first in whose step the walker is found beyond the piece or outside, or the tick
/// before. A place some hundred metres from the origin is rounded by 3e-5 m, less than a step.
TEST(OffscreenGrid, AreLeftWhenTheWalkerIsBeyond) {
    core::Rng rng(9);
    const float infinity = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 2'000; ++i) {
        PathSegment segment;
        const float turn = rng.range(0.0F, 6.28F);
        segment.from = Vec2(rng.range(-200.0F, 200.0F), rng.range(-200.0F, 200.0F));
        segment.direction = i % 10 == 0 ? Vec2(0.0F, 1.0F) : Vec2(std::cos(turn), std::sin(turn));
        segment.length = 1'000.0F;
        segment.speed = rng.range(0.5F, 8.0F);
        segment.since = 1'000;
        const Tick now = 1'001 + rng.below(100);
        const Vec2 half = i % 2 == 0 ? Vec2(infinity, infinity) : Vec2(150.0F, 170.0F);
        const auto within = [&](const Vec2& at, int axis) {
            return std::abs(at[axis]) <= half[axis];
        };
        const Vec2 start = position_at(segment, now - 1, kDt);
        const Tick left = OffscreenGrid::left_at(segment, start, half, kDt);
        Tick outside = now;
        const auto same = [&](Tick tick) {
            const Vec2 at = position_at(segment, tick - 1, kDt);
            return (at - segment.from).norm() < OffscreenGrid::kPiece_m &&
                   (within(at, 0) || !within(start, 0)) && (within(at, 1) || !within(start, 1));
        };
        while (same(outside)) {
            ++outside;
        }
        EXPECT_LE(std::abs(left - outside), 1) << "of " << outside - now << " ticks";
    }
    EXPECT_EQ(OffscreenGrid::left_at(PathSegment{}, Vec2::Zero(), Vec2(infinity, infinity), kDt),
              kNever);
}

/// Wanderers on a plain of 600 m, half of them pressed together, and a player who crosses it.
class Plain {
  public:
    static constexpr std::uint32_t kPeople = 400;
    static constexpr float kSeen_m = 40.0F;

    Plain() {
        Brain brain = single(ActionKind::kWander, 80.0F);
        brain.states[0].speed_factor = 0.9F;
        field.settings.brains = {brain};
        field.settings.viewer_range_m = kSeen_m;
        field.wall = nullptr;
        compile(field.settings, kDt);
        core::Rng rng(4);
        for (std::uint32_t id = 1; id <= kPeople; ++id) {
            const float half = id % 2 == 0 ? 300.0F : 40.0F;
            field.add_npc(
                id, kGuard, 0, Vec3(rng.range(-half, half), 0.9F, rng.range(-half, half)));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
        field.add_player(900, Vec3(-290.0F, 0.9F, 10.0F));
        field.run(5.0F);
    }

    /// The player runs on; entities that it can see and that are not simulated.
    std::uint32_t ghosts_seen() {
        field.position(900).x() += field.types[kPlayer].character.speed * kDt;
        field.step();
        std::uint32_t seen = 0;
        for (std::uint32_t id = 1; id <= kPeople; ++id) {
            const bool suspended = field.agents.find(EntityId(id))->tier == Tier::kSuspended;
            seen += suspended && field.distance(id, 900) <= kSeen_m ? 1U : 0U;
        }
        return seen;
    }

    Field field;
};

TEST(OffscreenLook, WhoIsSeenIsSimulated) {
    Plain plain;
    std::size_t fewest = Plain::kPeople;
    std::size_t most = 0;
    for (int tick = 0; tick < 3'600; ++tick) {
        ASSERT_EQ(plain.ghosts_seen(), 0U) << "at tick " << tick;
        fewest = std::min(fewest, plain.field.agents.active().size());
        most = std::max(most, plain.field.agents.active().size());
    }
    // On its path it met the crowd of 200, and few other agents.
    EXPECT_GT(most, 150U);
    EXPECT_LT(fewest, 60U);
}

TEST(OffscreenLook, TheCheckFindsOneWhoWasSettledElsewhere) {
    Plain plain;
    for (Slot slot = 0; slot < plain.field.agents.slots(); ++slot) {
        Agent& agent = plain.field.agents.at(slot);
        if (agent.tier == Tier::kSuspended) {
            const Vec2 aside(1'500.0F, 1'500.0F);
            agent.segment.from += aside;
            agent.placed += aside;
            plain.field.agents.settle(slot, kNever, kDt);
            agent.segment.from -= aside;
            agent.placed -= aside;
        }
    }
    std::uint32_t seen = 0;
    for (int tick = 0; tick < 600; ++tick) {
        seen += plain.ghosts_seen();
    }
    EXPECT_GT(seen, 0U);
}

}  // namespace
}  // namespace zoned::ai
