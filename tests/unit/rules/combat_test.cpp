#include "tests/unit/rules/fake_zone.h"
#include "shared/core/state_hash.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

/// Two players 10 m apart along x; the eye is 0.7 m above the centre, hits reach 0.9 m around it.
struct Duel : ::testing::Test {
    FakeZone zone;
    EntityId shooter = zone.join(1, Vec3::Zero());
    EntityId target = zone.join(2, Vec3(10.0F, 0.0F, 0.0F));

    void shoot() {
        zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(3.0F, 0.0F, 0.0F));
        zone.tick(8);  // 0.25 s
    }

    /// Five shots of 20.
    void kill() {
        for (int i = 0; i < 5; ++i) {
            shoot();
        }
    }

    /// The newest ledger that went to a client.
    [[nodiscard]] sandbox::Ledger ledger(std::uint32_t client) const {
        sandbox::Ledger newest;
        for (const Sent& s : zone.of_kind(sandbox::EVENT_LEDGER)) {
            if (s.client == ClientId(client)) {
                newest = FakeZone::parse<sandbox::Ledger>(s);
            }
        }
        return newest;
    }

    /// The client's claim on the newest ledger: so many deaths, and all else alike.
    void agree(std::uint32_t client, EntityId avatar, std::uint32_t more_deaths = 0) {
        const sandbox::Ledger held = ledger(client);
        core::StateHash digest;
        digest.add(held.deaths() + more_deaths);
        digest.add(held.kills());
        digest.add(held.trades());
        for (const std::uint32_t item : held.items()) {
            digest.add(item);
        }
        sandbox::Agree word;
        word.set_serial(held.serial());
        word.set_digest(digest.value());
        zone.command(client, avatar, sandbox::COMMAND_AGREE, word);
    }

    [[nodiscard]] EventId kill_event() const {
        return zone.of_kind(sandbox::EVENT_KILL).front().id;
    }
};

TEST_F(Duel, TakesDamageAndTellsThoseAroundTheTarget) {
    shoot();
    EXPECT_EQ(zone.health(target), 80u);
    const std::vector<Sent> hits = zone.of_kind(sandbox::EVENT_HIT);
    ASSERT_EQ(hits.size(), 1u);
    EXPECT_EQ(hits[0].channel, Channel::kViewers);
    EXPECT_EQ(hits[0].source, target);
    const auto hit = FakeZone::parse<sandbox::Hit>(hits[0]);
    EXPECT_EQ(hit.shooter(), shooter.value);
    EXPECT_EQ(hit.target(), target.value);
    EXPECT_EQ(hit.damage(), 20u);
    EXPECT_EQ(hit.health_left(), 80u);
}

TEST_F(Duel, MissesBeyondTheRangeAndToTheSide) {
    zone.position(target) = Vec3(101.0F, 0.0F, 0.0F);
    shoot();
    zone.position(target) = Vec3(10.0F, 0.0F, 2.0F);
    shoot();
    EXPECT_EQ(zone.health(target), 100u);
    EXPECT_EQ(zone.game.stats().shots, 2u);
}

TEST_F(Duel, DoesNotShootThroughWalls) {
    zone.wall_x = 5.0F;
    shoot();
    EXPECT_EQ(zone.health(target), 100u);
}

TEST_F(Duel, DeniesShotsDuringTheCooldown) {
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    zone.tick(7);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "too fast");
    EXPECT_EQ(zone.health(target), 80u);
    zone.tick(1);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.health(target), 60u);
}

TEST_F(Duel, DeniesDirectionsThatAreNoDirections) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, inf, -inf, 0.0F}) {
        zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(bad, 0.0F, 0.0F));
    }
    EXPECT_EQ(zone.game.stats().malformed, 4u);
    EXPECT_EQ(zone.denial(), "malformed");
    EXPECT_EQ(zone.game.stats().shots, 0u);
}

TEST_F(Duel, AcceptsTheLargestFiniteDirection) {
    const float most = std::numeric_limits<float>::max();
    zone.position(target) = Vec3(10.0F, 10.7F, 10.0F);  // along (1, 1, 1) from the eye
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(most, most, most));
    EXPECT_EQ(zone.health(target), 80u);
}

TEST_F(Duel, GivesPropsAnImpulse) {
    const EntityId ball = zone.put(kBall, Vec3(5.0F, 0.5F, 0.0F));
    shoot();
    // 5 N s on 2 kg.
    EXPECT_NEAR(zone.velocity(ball).x(), 2.5F, 1e-5F);
    EXPECT_EQ(zone.health(target), 100u);
}

TEST_F(Duel, AsksTheKilledClientFirst) {
    kill();
    const std::vector<Sent> kills = zone.of_kind(sandbox::EVENT_KILL);
    ASSERT_EQ(kills.size(), 1u);
    EXPECT_EQ(kills[0].channel, Channel::kClient);
    EXPECT_EQ(kills[0].client, ClientId(2));
    EXPECT_TRUE(kills[0].event.confirm);
    EXPECT_FALSE(zone.hidden(target));
    EXPECT_TRUE(zone.game.busy());
}

TEST_F(Duel, AnnouncesTheKillOnceTheKilledClientConfirms) {
    kill();
    zone.game.on_confirm(zone, ClientId(2), kill_event());
    const std::vector<Sent> kills = zone.of_kind(sandbox::EVENT_KILL);
    ASSERT_EQ(kills.size(), 3u);
    EXPECT_EQ(kills[2].client, ClientId(1));  // the killer's side confirms as well
    EXPECT_TRUE(kills[2].event.confirm);
    EXPECT_EQ(kills[1].channel, Channel::kViewers);
    EXPECT_EQ(kills[1].source, target);
    EXPECT_FALSE(kills[1].event.confirm);
    EXPECT_EQ(FakeZone::parse<sandbox::Kill>(kills[1]).killer(), shooter.value);
    EXPECT_EQ(FakeZone::parse<sandbox::Kill>(kills[1]).killed(), target.value);
    EXPECT_TRUE(zone.hidden(target));
    EXPECT_EQ(zone.game.stats().kills_unconfirmed, 0u);
}

TEST_F(Duel, AnnouncesTheKillAfterThreeSecondsWithoutAWord) {
    kill();
    zone.tick(90 - 8 - 1);  // eight ticks have passed since the last shot
    EXPECT_FALSE(zone.hidden(target));
    zone.tick(2);
    EXPECT_TRUE(zone.hidden(target));
    EXPECT_EQ(zone.game.stats().kills_unconfirmed, 1u);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_KILL).size(), 3u);
    zone.game.on_confirm(zone, ClientId(2), kill_event());  // too late
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_KILL).size(), 3u);
    EXPECT_EQ(zone.game.stats().stray_confirms, 1u);
}

TEST_F(Duel, IgnoresConfirmsOfOthersAndOfOtherEvents) {
    kill();
    zone.game.on_confirm(zone, ClientId(1), kill_event());
    zone.game.on_confirm(zone, ClientId(99), kill_event());
    zone.game.on_confirm(zone, ClientId(2), EventId(12345));
    EXPECT_FALSE(zone.hidden(target));
    EXPECT_EQ(zone.game.stats().stray_confirms, 3u);
}

TEST_F(Duel, LeavesTheDyingAloneAndLetsThemDoNothing) {
    kill();
    shoot();
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_HIT).size(), 5u);
    zone.command(2, target, sandbox::COMMAND_SHOOT, shot(-1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "dead");
    EXPECT_EQ(zone.health(shooter), 100u);
}

TEST_F(Duel, RespawnsWhereTheClientJoined) {
    zone.position(target) = Vec3(12.0F, 0.0F, 0.0F);
    kill();
    zone.game.on_confirm(zone, ClientId(2), kill_event());
    zone.tick(149);
    EXPECT_TRUE(zone.hidden(target));
    zone.tick(2);
    EXPECT_FALSE(zone.hidden(target));
    EXPECT_EQ(zone.position(target), Vec3(10.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.health(target), 100u);
    zone.tick(1);
    const std::vector<Sent> respawns = zone.of_kind(sandbox::EVENT_RESPAWN);
    ASSERT_EQ(respawns.size(), 1u);
    EXPECT_EQ(respawns[0].source, target);
    agree(1, shooter);
    agree(2, target);
    EXPECT_FALSE(zone.game.busy());
    shoot();
    EXPECT_EQ(zone.health(target), 80u);
}

TEST_F(Duel, TellsBothSidesWhatTheDecisionMadeUntilTheyAgree) {
    kill();
    zone.game.on_confirm(zone, ClientId(2), kill_event());
    EXPECT_EQ(ledger(2).deaths(), 1u);
    EXPECT_EQ(ledger(1).kills(), 1u);
    const std::uint64_t first = ledger(2).serial();
    zone.tick_seconds(1.2F);
    EXPECT_EQ(ledger(2).serial(), first + 2) << "again every half second";
    agree(2, target);
    zone.tick_seconds(3.0F);
    EXPECT_EQ(ledger(2).serial(), first + 2) << "not after it has agreed";
    EXPECT_EQ(zone.game.find(target)->deaths, 1u) << "told often, decided once";
    zone.tick_seconds(20.0F);
    EXPECT_EQ(zone.game.stats().ledgers_given_up, 1u) << "who never answers is not asked for ever";
    EXPECT_FALSE(zone.game.busy());
}

TEST_F(Duel, ResetsAClientThatHoldsSomethingElse) {
    kill();
    zone.game.on_confirm(zone, ClientId(2), kill_event());
    agree(2, target, 1);
    EXPECT_EQ(zone.game.stats().ledgers_diverged, 1u);
    EXPECT_TRUE(ledger(2).reset());
    EXPECT_EQ(zone.resets, std::vector<ClientId>{ClientId(2)});
    agree(2, target);
    EXPECT_EQ(zone.game.stats().ledgers_agreed, 1u);
    sandbox::Agree old;
    old.set_serial(1);
    zone.command(2, target, sandbox::COMMAND_AGREE, old);
    EXPECT_EQ(zone.game.stats().ledgers_diverged, 1u) << "a word on an older one says nothing";
}

TEST_F(Duel, WaitsForTheTickOfAShotAndBelievesNoAbsurdNumbers) {
    sandbox::Shoot later = shot(3.0F, 0.0F, 0.0F);
    later.set_tick(zone.now() + 4);
    later.mutable_seen()->set_tick(zone.now() - 2);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, later);
    zone.tick(4);
    EXPECT_EQ(zone.game.stats().shots, 0u);
    zone.tick(2);
    EXPECT_EQ(zone.game.stats().shots_as_seen, 1u);
    EXPECT_EQ(zone.health(target), 80u);
    const std::vector<Sent> told = zone.of_kind(sandbox::EVENT_SHOT);
    ASSERT_EQ(told.size(), 2u);
    EXPECT_EQ(told[0].client, ClientId(1));
    EXPECT_EQ(told[1].client, ClientId(2));
    EXPECT_EQ(FakeZone::parse<sandbox::Shot>(told[0]).hit(), target.value);
    zone.tick(20);
    constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
    sandbox::Shoot bad = shot(3.0F, 0.0F, 0.0F);
    bad.mutable_seen()->add_sighting()->set_x(kMost);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, bad);
    bad = shot(3.0F, 0.0F, 0.0F);
    for (int i = 0; i < 9; ++i) {
        bad.mutable_seen()->add_sighting();
    }
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, bad);
    EXPECT_EQ(zone.game.stats().malformed, 2u);
    // The farthest tick is brought to within a second of now.
    bad = shot(3.0F, 0.0F, 0.0F);
    bad.set_tick(kMost);
    bad.mutable_seen()->set_tick(kMost);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, bad);
    zone.tick(32);
    EXPECT_EQ(zone.game.stats().shots_as_seen, 2u);
}

TEST_F(Duel, CountsAKillThatIsDodgedByLeaving) {
    kill();
    zone.game.on_leave(zone, ClientId(2), target);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_KILL).size(), 3u);
    EXPECT_EQ(zone.game.stats().kills, 1u);
    EXPECT_FALSE(zone.exists(target));
    agree(1, shooter);
    EXPECT_FALSE(zone.game.busy());
}

TEST(Npc, DiesAtOnceAndComesBackToItsFirstPlace) {
    FakeZone zone;
    const EntityId guard = zone.put(kGuard, Vec3(10.0F, 0.0F, 0.0F));
    zone.tick();  // the survey
    const EntityId shooter = zone.join(1, Vec3::Zero());
    zone.position(guard) = Vec3(20.0F, 0.0F, 0.0F);
    for (int i = 0; i < 5; ++i) {
        zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
        zone.tick(8);
    }
    ASSERT_EQ(zone.of_kind(sandbox::EVENT_KILL).size(), 2u);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_KILL)[1].client, ClientId(1));
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_KILL)[0].channel, Channel::kViewers);
    EXPECT_TRUE(zone.hidden(guard));
    zone.tick_seconds(5.1F);
    EXPECT_FALSE(zone.hidden(guard));
    EXPECT_EQ(zone.position(guard), Vec3(10.0F, 0.0F, 0.0F));
}

TEST(Shot, ReachesCharactersAndPropsOfAnotherZone) {
    FakeZone a(1);
    FakeZone b(2, Vec3d(100.0, 0.0, 0.0));
    const EntityId shooter = a.join(1, Vec3(40.0F, 0.0F, 0.0F));
    const EntityId target = b.join(2, Vec3(-50.0F, 0.0F, 0.0F));   // at 50 in a
    const EntityId ball = b.put(kBall, Vec3(-60.0F, 0.0F, 5.0F));  // at (40, 5) in a
    a.show_ghost(b, target);
    a.show_ghost(b, ball);
    a.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    a.tick(8);
    a.command(1, shooter, sandbox::COMMAND_SHOOT, shot(0.0F, 0.0F, 1.0F));
    EXPECT_EQ(b.health(target), 100u);
    deliver(a, b);
    EXPECT_EQ(b.health(target), 80u);
    EXPECT_EQ(FakeZone::parse<sandbox::Hit>(b.of_kind(sandbox::EVENT_HIT).at(0)).shooter(),
              shooter.value);
    EXPECT_NEAR(b.velocity(ball).z(), 2.5F, 1e-5F);
}

TEST(Bite, HurtsPlayersInReachOfARunningGuardWithinItsCooldown) {
    FakeZone zone(1, Vec3d::Zero(), {{"bite_type", "guard"}, {"bite_damage", "10"}});
    const EntityId player = zone.join(1, Vec3::Zero());
    const EntityId guard = zone.put(kGuard, Vec3(1.4F, 0.0F, 0.0F));
    zone.tick_seconds(2.0F);
    EXPECT_EQ(zone.health(player), 100u);  // it does not run
    zone.set_stance(guard, world::Stance::kRunning);
    zone.tick_seconds(4.0F);
    // One bite a second, up to 8 ticks late each: three or four.
    EXPECT_LE(zone.health(player), 70u);
    EXPECT_GE(zone.health(player), 60u);
    const std::uint32_t before = zone.health(player);
    zone.position(guard) = Vec3(1.6F, 0.0F, 0.0F);
    zone.tick_seconds(4.0F);
    EXPECT_EQ(zone.health(player), before);
}

TEST(Outcomes, AreToldOfFightsBetweenPlayersAndNpcsAlone) {
    FakeZone zone(
        1, Vec3d::Zero(), {{"bite_type", "guard"}, {"bite_damage", "100"}, {"confirm_s", "0.5"}});
    const EntityId hunter = zone.join(1, Vec3::Zero());
    zone.put(kGuard, Vec3(10.0F, 0.0F, 0.0F));
    const auto shoot = [&] {
        for (int i = 0; i < 5; ++i) {
            zone.command(1, hunter, sandbox::COMMAND_SHOOT, shot(3.0F, 0.0F, 0.0F));
            zone.tick(8);
        }
    };
    shoot();
    EXPECT_EQ(zone.outcomes, (std::vector<bool>{true})) << "a player has beaten a guard";
    // Players among themselves report nothing to difficulty.
    const EntityId other = zone.join(2, Vec3(5.0F, 0.0F, 0.0F));
    shoot();
    zone.tick_seconds(1.0F);
    ASSERT_EQ(zone.game.find(other)->life, Life::kDead);
    EXPECT_EQ(zone.outcomes.size(), 1U);
    const EntityId biter = zone.put(kGuard, Vec3(-1.0F, 0.0F, 0.0F));
    zone.set_stance(biter, world::Stance::kRunning);
    zone.tick_seconds(2.0F);
    ASSERT_EQ(zone.game.find(hunter)->life, Life::kDead);
    EXPECT_EQ(zone.outcomes, (std::vector<bool>{true, false})) << "told once, when it is decided";
}

TEST(Outcomes, AreToldAcrossABorderByWhoOwnsTheLoser) {
    FakeZone a(1, Vec3d(-50.0, 0.0, 0.0));
    FakeZone b(2, Vec3d(50.0, 0.0, 0.0));
    const EntityId hunter = a.join(1, Vec3(45.0F, 0.0F, 0.0F));
    const EntityId guard = b.put(kGuard, Vec3(-45.0F, 0.0F, 0.0F));
    a.show_ghost(b, guard);
    b.show_ghost(a, hunter);
    for (int i = 0; i < 5; ++i) {
        a.command(1, hunter, sandbox::COMMAND_SHOOT, shot(3.0F, 0.0F, 0.0F));
        deliver(a, b);
        a.tick(8);
        b.tick(8);
    }
    ASSERT_TRUE(b.hidden(guard));
    EXPECT_TRUE(a.outcomes.empty());
    EXPECT_EQ(b.outcomes, (std::vector<bool>{true}));
}

}  // namespace
}  // namespace zoned::rules::test
