#include "server/cluster/world_lease.h"

#include "server/cluster/directory.h"
#include "server/cluster/local_board.h"
#include "tests/unit/cluster/doubtful_board.h"

#include <gtest/gtest.h>

namespace zoned::cluster {

namespace {

using Mood = test::DoubtfulBoard::Mood;

class Leases : public ::testing::Test {
  protected:
    struct Server {
        test::DoubtfulBoard board;
        WorldLease lease;

        /// `life` is that of the state in its folder; with `fresh` it would begin anew.
        Server(Leases& test,
               const std::string& instance,
               const std::string& life = "",
               const std::string& fresh = "")
            : board(make_local_board(test.hub)),
              lease(board, {"castle", instance, 10.0, life, fresh}, [&test] {
                  return test.now_s;
              }) {}
    };

    std::shared_ptr<LocalHub> hub = make_local_hub();
    double now_s = 100.0;
    Server a{*this, "aaaaaaaaaaaaaaaa"};
    Server b{*this, "bbbbbbbbbbbbbbbb"};
};

}  // namespace

TEST_F(Leases, OneServerHasTheWorldAndTheOtherWaits) {
    EXPECT_EQ(a.lease.claim(), LeaseState::kHeld);
    EXPECT_TRUE(a.lease.valid());
    EXPECT_EQ(b.lease.claim(), LeaseState::kWaiting);
    EXPECT_EQ(b.lease.owner().instance(), "aaaaaaaaaaaaaaaa");
    EXPECT_FALSE(b.lease.valid());
    for (int i = 0; i < 50; ++i) {
        now_s += 2.0;
        EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
        EXPECT_EQ(b.lease.claim(), LeaseState::kWaiting);
    }
}

TEST_F(Leases, ASilentOwnerIsFollowedAfterItsLeaseAndNotBefore) {
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    const std::uint64_t before = a.lease.epoch();
    ASSERT_EQ(b.lease.claim(), LeaseState::kWaiting);
    a.board.mood = Mood::kCut;
    now_s += 9.99;
    EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
    EXPECT_EQ(b.lease.claim(), LeaseState::kWaiting);
    now_s += 0.02;
    EXPECT_FALSE(a.lease.valid()) << "judges by its own clock, without asking anybody";
    EXPECT_EQ(a.lease.renew(), LeaseState::kLapsed);
    EXPECT_EQ(b.lease.claim(), LeaseState::kWaiting) << "waits longer than the owner counts";
    now_s += 1.0;
    EXPECT_EQ(b.lease.claim(), LeaseState::kHeld);
    EXPECT_GT(b.lease.epoch(), before);
    a.board.mood = Mood::kGood;
    EXPECT_EQ(a.lease.renew(), LeaseState::kLost);
    EXPECT_EQ(a.lease.renew(), LeaseState::kLost) << "for good";
    EXPECT_EQ(b.lease.renew(), LeaseState::kHeld);
}

TEST_F(Leases, AnOwnerThatWasCutOffGoesOnWhereNobodyTookTheWorld) {
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    const std::uint64_t epoch = a.lease.epoch();
    a.board.mood = Mood::kCut;
    now_s += 60.0;
    EXPECT_EQ(a.lease.renew(), LeaseState::kLapsed);
    EXPECT_LT(a.lease.left_s(), -40.0);
    a.board.mood = Mood::kGood;
    EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
    EXPECT_EQ(a.lease.epoch(), epoch);
}

TEST_F(Leases, ALostAnswerLosesNoWorld) {
    a.board.mood = Mood::kLosesAnswer;
    EXPECT_EQ(a.lease.claim(), LeaseState::kWaiting);
    a.board.mood = Mood::kGood;
    EXPECT_EQ(a.lease.claim(), LeaseState::kHeld) << "it finds its own claim";
    a.board.mood = Mood::kLosesAnswer;
    now_s += 3.0;
    EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
    a.board.mood = Mood::kGood;
    now_s += 3.0;
    EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
    EXPECT_EQ(a.lease.renew(), LeaseState::kHeld);
    EXPECT_NEAR(a.lease.left_s(), 10.0, 1e-9);
}

TEST_F(Leases, AWorldThatWasGivenBackIsFreeAtOnce) {
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    ASSERT_EQ(b.lease.claim(), LeaseState::kWaiting);
    a.lease.release();
    EXPECT_FALSE(a.lease.valid());
    EXPECT_EQ(b.lease.claim(), LeaseState::kHeld);
    a.lease.release();
    EXPECT_EQ(b.lease.renew(), LeaseState::kHeld) << "what is another's is not given back";
}

TEST_F(Leases, TheNextProcessOfAStateFolderNeedNotWait) {
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    const std::uint64_t epoch = a.lease.epoch();
    Server again{*this, "aaaaaaaaaaaaaaaa"};
    EXPECT_EQ(again.lease.claim(), LeaseState::kHeld);
    EXPECT_GT(again.lease.epoch(), epoch);
}

TEST_F(Leases, AWorldKeepsItsLifeAsLongAsEachServerGoesOnFromTheOneBefore) {
    Server first{*this, "aaaaaaaaaaaaaaaa", "", "life 1"};
    ASSERT_EQ(first.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(first.lease.life(), "life 1");
    ASSERT_EQ(first.lease.renew(), LeaseState::kHeld);
    Server again{*this, "aaaaaaaaaaaaaaaa", "life 1", "life 2"};
    ASSERT_EQ(again.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(again.lease.life(), "life 1");
    again.lease.release();
    Server later{*this, "aaaaaaaaaaaaaaaa", "life 1", "life 3"};
    ASSERT_EQ(later.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(later.lease.life(), "life 1") << "nobody had it in between";
}

TEST_F(Leases, AServerThatGoesOnFromNothingEndsTheLifeOfAWorld) {
    Server first{*this, "aaaaaaaaaaaaaaaa", "", "life 1"};
    ASSERT_EQ(first.lease.claim(), LeaseState::kHeld);
    first.lease.release();
    Server other{*this, "bbbbbbbbbbbbbbbb", "", "life 2"};
    ASSERT_EQ(other.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(other.lease.life(), "life 2");
    other.lease.release();
    Server again{*this, "aaaaaaaaaaaaaaaa", "life 1", "life 3"};
    ASSERT_EQ(again.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(again.lease.life(), "life 3") << "what it kept is not the world any more";
    Server mute{*this, "aaaaaaaaaaaaaaaa", "", "life 4"};
    ASSERT_EQ(mute.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(mute.lease.life(), "life 4") << "its folder has lost its state";
}

TEST_F(Leases, ALostAnswerDoesNotChangeALife) {
    Server first{*this, "aaaaaaaaaaaaaaaa", "", "life 1"};
    ASSERT_EQ(first.lease.claim(), LeaseState::kHeld);
    for (const auto& [kept, life] : {std::pair{"life 1", "life 1"}, std::pair{"", "fresh"}}) {
        Server again{*this, "aaaaaaaaaaaaaaaa", kept, "fresh"};
        again.board.mood = Mood::kLosesAnswer;
        ASSERT_EQ(again.lease.claim(), LeaseState::kWaiting);
        again.board.mood = Mood::kGood;
        ASSERT_EQ(again.lease.claim(), LeaseState::kHeld);
        EXPECT_EQ(again.lease.life(), life);
    }
}

TEST_F(Leases, AWorldThatTheBoardHasForgottenKeepsItsLife) {
    Server alone{*this, "aaaaaaaaaaaaaaaa", "life 1", "life 2"};
    ASSERT_EQ(alone.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(alone.lease.life(), "life 1");
}

TEST_F(Leases, AnEntryThatNobodyCanReadIsNobodys) {
    ASSERT_TRUE(a.board.put_if("world.castle", 0, "\xFF\xFF").ok());
    EXPECT_EQ(b.lease.claim(), LeaseState::kHeld);
}

TEST_F(Leases, TheDirectoryShowsWhoIsAlive) {
    Directory directory(b.board);
    EXPECT_EQ(directory.list(now_s), "");
    EXPECT_FALSE(directory.find("castle", now_s));
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(directory.list(now_s), "");
    auto found = directory.find("castle", now_s);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->alive());
    EXPECT_FALSE(found->open()) << "it does not listen yet";
    a.lease.describe([](auto& entry) {
        entry.set_tcp_port(7777);
        entry.mutable_load()->set_sessions(3);
    });
    a.lease.renew();
    EXPECT_EQ(directory.list(now_s), "");
    found = directory.find("castle", now_s + 9.0);
    EXPECT_TRUE(found->open());
    EXPECT_EQ(found->entry.load().sessions(), 3U);
    EXPECT_EQ(found->entry.epoch(), a.lease.epoch());
    EXPECT_FALSE(directory.find("castle", now_s + 11.0)->alive());
    a.lease.release();
    EXPECT_EQ(directory.list(now_s), "");
    EXPECT_FALSE(directory.find("castle", now_s)->alive());
    EXPECT_EQ(directory.all(now_s).size(), 1U);
}

TEST_F(Leases, TheDirectoryLooksAfterTheWorldsThatItKnows) {
    Directory directory(b.board);
    directory.know("castle");
    directory.know("tower");
    EXPECT_EQ(directory.look(now_s), "");
    EXPECT_TRUE(directory.all(now_s).empty()) << "nobody ever had them";
    ASSERT_EQ(a.lease.claim(), LeaseState::kHeld);
    EXPECT_EQ(directory.look(now_s), "");
    ASSERT_TRUE(directory.find("castle", now_s));
    EXPECT_FALSE(directory.find("tower", now_s));
    now_s += 9.0;
    a.lease.renew();
    EXPECT_EQ(directory.look(now_s), "");
    EXPECT_TRUE(directory.find("castle", now_s + 9.0)->alive());
    b.board.stale = BoardEntry{"", 1};
    EXPECT_EQ(directory.look(now_s), "");
    EXPECT_TRUE(directory.find("castle", now_s)->alive()) << "an older answer says nothing";
    b.board.stale.reset();
    b.board.mood = Mood::kCut;
    EXPECT_EQ(directory.look(now_s), "cut");
    EXPECT_TRUE(directory.find("castle", now_s)->alive()) << "what was known stays known";
}

}  // namespace zoned::cluster
