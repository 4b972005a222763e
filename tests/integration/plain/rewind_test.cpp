// Rays through the past: a rewindable entity stands where it was, within the bounds.
#include "server/app/world/world.h"
#include "server/zone/viewers/lag_compensation.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <optional>

namespace zoned::app {
namespace {

constexpr ClientId kViewer(1);

/// A ball that flies from x = -2 over the border at x = 0, high above the ground, and its listener.
class Rewinding : public testing::Test {
  protected:
    void begin(int columns, bool rewindable = true) {
        config::Settings s = scenario::small_world(columns, 1, 100.0);
        s.types[scenario::kBall].rewindable = rewindable;
        s.rewind.most_ticks = 12;
        s.rewind.slack_m = 0.1F;
        plain_log() = std::make_shared<scenario::PlainLog>();
        world_.emplace(s, 1);
        mailbox::Join join;
        join.client = kViewer;
        join.name = "player";
        zone::SpawnDef ball;
        ball.type = scenario::kBall;
        const Vec3d origin = world_->zones()[0]->state().settings.region().origin();
        ball.position = (Vec3d(-2.0, 60.0, 10.0) - origin).cast<float>();
        ball.velocity = Vec3(4.0F, 0.0F, 0.0F);
        ball_ = world_->zones()[0]->spawn(ball);
        tick({join});
    }

    void tick(const std::vector<mailbox::InboxItem>& items = {}) {
        out_.clear();
        world_->tick(items, out_);
        const zone::ZoneState& z = viewers_zone();
        const world::Row row = z.entities.find(ball_);
        if (row != world::kNoRow) {
            was_[z.now] = z.entities.position[row];
        }
    }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            tick();
        }
    }

    zone::ZoneState& viewers_zone() {
        for (const auto& zone : world_->zones()) {
            if (!zone->state().clients.empty()) {
                return zone->state();
            }
        }
        return world_->zones()[0]->state();
    }

    /// Along z through a place of the viewer's zone.
    zone::SeenHit through(const Vec3& place, const zone::Seen& seen) {
        return zone::ray_cast_as_seen(viewers_zone(),
                                      kViewer,
                                      seen,
                                      place - Vec3(0.0F, 0.0F, 8.0F),
                                      Vec3::UnitZ(),
                                      20.0F,
                                      EntityId());
    }

    static zone::Seen past(Tick tick, float fraction = 0.0F) {
        zone::Seen seen;
        seen.view = zone::Seen::DisplayedTime::kPast;
        seen.tick = tick;
        seen.fraction = fraction;
        return seen;
    }

    std::optional<World> world_;
    std::vector<mailbox::OutboxItem> out_;
    std::map<Tick, Vec3> was_;
    EntityId ball_;
};

TEST_F(Rewinding, HitsWhereTheTargetWasAndNotWhereItIs) {
    begin(1);
    ticks(30);
    const Tick now = viewers_zone().now;
    const Vec3 then = was_.at(now - 9);
    ASSERT_GT((then - was_.at(now)).norm(), 2.0F);
    const zone::SeenHit hit = through(then, past(now - 9));
    EXPECT_EQ(hit.entity, ball_);
    EXPECT_FALSE(hit.cut);
    // The world within a step is that of the tick before.
    EXPECT_NEAR(hit.rewound_s, 8.0F / 30.0F, 1e-4F);
    EXPECT_NEAR(hit.distance, 8.0F - 0.5F, 1e-3F);
    EXPECT_FALSE(through(was_.at(now), past(now - 9)).hit);
    // Between two ticks: the middle of both places, which a ball's width cannot reach from either.
    const Vec3 middle = 0.5F * (then + was_.at(now - 8));
    EXPECT_NEAR(through(middle, past(now - 9, 0.5F)).distance, 8.0F - 0.5F, 1e-3F);
}

TEST_F(Rewinding, NeverGoesBehindTheBoundNorIntoTheFuture) {
    begin(1);
    ticks(40);
    const Tick now = viewers_zone().now;
    const Tick oldest = now - 1 - 12;
    constexpr Tick kLeast = std::numeric_limits<Tick>::min();
    constexpr Tick kMost = std::numeric_limits<Tick>::max();
    for (const Tick claimed : {oldest - 1, Tick{0}, Tick{-1}, kLeast}) {
        const zone::SeenHit hit = through(was_.at(oldest), past(claimed));
        EXPECT_EQ(hit.entity, ball_) << claimed;
        EXPECT_TRUE(hit.cut);
        EXPECT_NEAR(hit.rewound_s, 12.0F / 30.0F, 1e-4F);
        EXPECT_FALSE(through(was_.at(oldest - 8), past(claimed)).hit);
    }
    for (const Tick claimed : {now, now + 5, kMost}) {
        const zone::SeenHit hit = through(was_.at(now - 1), past(claimed));
        EXPECT_EQ(hit.entity, ball_) << claimed;
        EXPECT_TRUE(hit.cut);
        EXPECT_EQ(hit.rewound_s, 0.0F);
    }
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -7.0F}) {
        EXPECT_EQ(through(was_.at(now - 5), past(now - 5, bad)).entity, ball_);
    }
}

TEST_F(Rewinding, BelievesAClientOnlyAsFarAsItIsExplained) {
    begin(1);
    ticks(30);
    const Tick now = viewers_zone().now;
    const Vec3 then = was_.at(now - 6);
    // Half a metre is the ball's radius; 0.1 m of slack and 0.5 m of the bound at that distance.
    const float allowed = 0.1F + viewers_zone().replicator.bound_m(kViewer, ball_);
    ASSERT_GT(allowed, 0.1F);
    for (const float off : {0.9F * allowed, 5.0F, 1e15F}) {
        const zone::SeenEntity claim{ball_, then + Vec3(off, 0.0F, 0.0F), -1};
        zone::Seen seen = past(now - 6);
        seen.entities = {&claim, 1};
        const float reached = std::min(off, allowed);
        EXPECT_TRUE(through(then + Vec3(reached + 0.45F, 0.0F, 0.0F), seen).hit) << off;
        const zone::SeenHit beyond = through(then + Vec3(reached + 0.55F, 0.0F, 0.0F), seen);
        EXPECT_FALSE(beyond.hit) << off;
        EXPECT_EQ(through(then, seen).doubted, off > allowed);
    }
    const zone::SeenEntity nowhere{ball_, Vec3::Constant(NAN), -1};
    zone::Seen seen = past(now - 6);
    seen.entities = {&nowhere, 1};
    EXPECT_EQ(through(then, seen).entity, ball_);
    EXPECT_TRUE(through(then, seen).doubted);
}

TEST_F(Rewinding, HitsNothingAcrossAJumpNorWhatIsHidden) {
    begin(1);
    ticks(30);
    const Tick before = viewers_zone().now;
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.teleport(ball_, Vec3(20.0F, 60.0F, 10.0F));
    };
    tick();
    plain_log()->each_tick = {};
    ticks(3);
    const Tick now = viewers_zone().now;
    EXPECT_FALSE(through(was_.at(before), past(before)).hit);
    EXPECT_FALSE(through(was_.at(now), past(before)).hit);
    EXPECT_TRUE(through(was_.at(now - 1), past(now - 1)).hit);
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.hide(ball_);
    };
    tick();
    EXPECT_FALSE(through(was_.at(now - 1), past(now - 1)).hit);
}

TEST_F(Rewinding, RemembersAcrossABorder) {
    begin(2);
    ticks(12);
    const auto owner = [&] {
        return world_->zones()[0]->owns(ball_) ? world_->zones()[0]->state().settings.id
                                               : world_->zones()[1]->state().settings.id;
    };
    const ZoneId home = viewers_zone().settings.id;
    ASSERT_NE(owner(), home) << "it begins in the zone beside the viewer's";
    while (owner() != home && viewers_zone().now < 60) {
        tick();
    }
    ASSERT_EQ(owner(), home);
    const Tick now = viewers_zone().now;
    for (const Tick back : {1, 4, 8}) {
        const zone::SeenHit hit = through(was_.at(now - back), past(now - back));
        EXPECT_EQ(hit.entity, ball_) << back;
        EXPECT_NEAR(hit.distance, 8.0F - 0.5F, 2e-3F);
    }
}

TEST_F(Rewinding, RemembersNothingThatNoTypeAsksFor) {
    begin(1, false);
    ticks(20);
    EXPECT_TRUE(viewers_zone().history.empty());
    EXPECT_FALSE(viewers_zone().report.plan.has(zone::Pass::kHistory));
    begin(1, true);
    ticks(20);
    EXPECT_TRUE(viewers_zone().report.plan.has(zone::Pass::kHistory));
    // The ball alone: no other type asks for it.
    EXPECT_EQ(viewers_zone().history.recorded(viewers_zone().now), 1u);
    mailbox::Leave leave;
    leave.client = kViewer;
    tick({leave});
    tick();
    EXPECT_FALSE(viewers_zone().report.plan.has(zone::Pass::kHistory)) << "nobody could shoot";
}

/// Poses are kept of what is heard and of players' own characters, however few of all that.
/// `balls` are rewindable, `crates` not.
void expect_history_of_heard(int balls, int crates) {
    config::Settings s = scenario::small_world(1, 1, 400.0);
    s.types[scenario::kBall].rewindable = true;
    s.types[scenario::kPlayer].rewindable = true;
    s.rewind.most_ticks = 12;
    for (int k = 0; k < balls + crates; ++k) {
        config::InitialEntity thing;
        thing.type = k < balls ? scenario::kBall : scenario::kCrate;
        // Balls up to the edge of the world, crates near the player.
        thing.position =
            k < balls ? Vec3d(190.0 * k / balls, 0.5, 5.0) : Vec3d(1.5 * (k - balls), 0.5, -5.0);
        thing.asleep = true;
        s.initial.push_back(thing);
    }
    plain_log() = std::make_shared<scenario::PlainLog>();
    World world(s, 1);
    mailbox::Join join;
    join.client = kViewer;
    join.name = "player";
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < 20; ++t) {
        out.clear();
        world.tick(
            t == 0 ? std::vector<mailbox::InboxItem>{join} : std::vector<mailbox::InboxItem>(),
            out);
        const zone::ZoneState& state = world.zones()[0]->state();
        const world::Entities& e = state.entities;
        std::size_t wanted = 0;
        for (world::Row row = 0; row < e.size(); ++row) {
            const bool kept = (*state.settings.types)[e.type[row]].rewindable &&
                              (e.client[row] || state.replicator.heard(e.id[row]));
            wanted += kept ? 1U : 0U;
            EXPECT_EQ(state.history.at(e.id[row], state.now, 0.0F).has_value(), kept) << row;
        }
        EXPECT_EQ(state.history.recorded(state.now), wanted);
        if (t > 3) {
            EXPECT_GT(wanted, 3U);
            EXPECT_LT(wanted, static_cast<std::size_t>(balls));
        }
    }
}

TEST(PosesOfThePast, AreThoseOfHeardOnesWhereMostAreFarAway) {
    expect_history_of_heard(60, 2);
}

TEST(PosesOfThePast, AreThoseOfHeardOnesWhereMuchElseIsHeard) {
    expect_history_of_heard(20, 25);
}

}  // namespace
}  // namespace zoned::app
