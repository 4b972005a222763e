#include "server/cluster/accounts.h"

#include "server/cluster/local_board.h"
#include "tests/unit/cluster/doubtful_board.h"

#include <gtest/gtest.h>

namespace zoned::cluster {

namespace {

using Owner = AccountClaim::Owner;
using Mood = test::DoubtfulBoard::Mood;
using Outcome = SettledWrite::Outcome;

class AccountsOfARealm : public ::testing::Test {
  protected:
    static std::vector<proto::cluster::Record> records(const std::string& value) {
        proto::cluster::Record record;
        record.set_scope(2);
        record.set_character("hero");
        record.set_key("bag");
        record.set_value(value);
        return {record};
    }

    SettledWrite gift(const AccountClaim& claim, const std::string& value = "gold") {
        return castle.give(claim.entry, claim.revision, 1, "meadow", "gate", records(value));
    }

    std::shared_ptr<LocalHub> hub = make_local_hub();
    test::DoubtfulBoard board_a{make_local_board(hub)};
    test::DoubtfulBoard board_b{make_local_board(hub)};
    Accounts castle{board_a, "castle"};
    Accounts meadow{board_b, "meadow"};
};

}  // namespace

TEST_F(AccountsOfARealm, TheFirstWorldThatAnAccountLogsInToHasIt) {
    const AccountClaim first = castle.claim("ann", 1, true);
    EXPECT_EQ(first.owner, Owner::kHere);
    EXPECT_EQ(first.entry.account(), "ann");
    const AccountClaim other = meadow.claim("ann", 2, true);
    EXPECT_EQ(other.owner, Owner::kElsewhere);
    EXPECT_EQ(other.entry.world(), "castle");
    EXPECT_GT(castle.claim("ann", 1, true).revision, first.revision) << "each login writes";
    EXPECT_EQ(castle.claim("ann", 1, false).owner, Owner::kHere);
}

/// A board of several servers answers at times with what was before.
TEST_F(AccountsOfARealm, AnAnswerOfYesterdayLetsNobodyIn) {
    const AccountClaim here = castle.claim("ann", 1, true);
    board_a.stale = *board_a.get(Accounts::key_of("ann"));
    SettledWrite given = gift(here);
    ASSERT_EQ(given.attempt(board_b), Outcome::kDone);
    EXPECT_EQ(castle.claim("ann", 1, true).owner, Owner::kAgain);
    board_a.stale.reset();
    EXPECT_EQ(castle.claim("ann", 1, true).owner, Owner::kElsewhere);
}

TEST_F(AccountsOfARealm, AnAccountGoesToAnotherWorldWithItsRecords) {
    const AccountClaim here = castle.claim("ann", 1, true);
    SettledWrite given = gift(here);
    ASSERT_EQ(given.attempt(board_a), Outcome::kDone);
    EXPECT_EQ(castle.claim("ann", 1, true).owner, Owner::kElsewhere);

    const AccountClaim arriving = meadow.claim("ann", 2, true);
    ASSERT_EQ(arriving.owner, Owner::kArriving);
    ASSERT_EQ(arriving.entry.records_size(), 1);
    EXPECT_EQ(arriving.entry.records(0).value(), "gold");
    EXPECT_EQ(arriving.entry.arrival(), "gate");
    EXPECT_EQ(arriving.entry.from_world(), "castle");
    EXPECT_EQ(arriving.entry.hops(), 1U);
    EXPECT_EQ(meadow.claim("ann", 2, true).owner, Owner::kArriving)
        << "until it is said that the store has them";
    SettledWrite accepted = meadow.accept(arriving, 2, false);
    ASSERT_EQ(accepted.attempt(board_b), Outcome::kDone);

    const AccountClaim login = meadow.claim("ann", 2, true);
    EXPECT_EQ(login.owner, Owner::kHere);
    EXPECT_EQ(login.entry.arrival(), "gate");
    EXPECT_EQ(login.entry.records_size(), 0);
    EXPECT_EQ(meadow.claim("ann", 2, true).entry.arrival(), "") << "it appears there once";
}

TEST_F(AccountsOfARealm, AServerThatLostItsWorldCanGiveNothingAway) {
    const AccountClaim old = castle.claim("ann", 1, true);
    // Another server of the world has it now, and the account logs in there.
    EXPECT_EQ(castle.claim("ann", 5, true).owner, Owner::kHere);
    SettledWrite late = gift(old);
    EXPECT_EQ(late.attempt(board_a), Outcome::kOvertaken);
    EXPECT_EQ(meadow.claim("ann", 2, true).owner, Owner::kElsewhere);
}

TEST_F(AccountsOfARealm, AGiftWhoseAnswerWasLostIsNotGivenTwice) {
    const AccountClaim here = castle.claim("ann", 1, true);
    SettledWrite given = gift(here);
    board_a.mood = Mood::kLosesAnswer;
    EXPECT_EQ(given.attempt(board_a), Outcome::kAgain);
    board_a.mood = Mood::kCut;
    EXPECT_EQ(given.attempt(board_a), Outcome::kAgain);
    board_a.mood = Mood::kGood;
    EXPECT_EQ(given.attempt(board_a), Outcome::kDone) << "it finds its own value";
    EXPECT_EQ(meadow.claim("ann", 2, true).entry.hops(), 1U);
}

TEST_F(AccountsOfARealm, AGiftWhoseAnswerWasLostAndThatWasTakenUpIsKnownToBeGone) {
    const AccountClaim here = castle.claim("ann", 1, true);
    SettledWrite given = gift(here);
    board_a.mood = Mood::kLosesAnswer;
    EXPECT_EQ(given.attempt(board_a), Outcome::kAgain);
    board_a.mood = Mood::kGood;
    ASSERT_EQ(meadow.accept(meadow.claim("ann", 2, true), 2, true).attempt(board_b),
              Outcome::kDone);
    ASSERT_EQ(given.attempt(board_a), Outcome::kOvertaken);
    proto::cluster::AccountEntry present;
    ASSERT_TRUE(present.ParseFromString(given.present.value));
    EXPECT_EQ(present.world(), "meadow");
}

TEST_F(AccountsOfARealm, ABoardOutOfReachGivesNobodyAnything) {
    board_a.mood = Mood::kCut;
    const AccountClaim claim = castle.claim("ann", 1, true);
    EXPECT_EQ(claim.owner, Owner::kAgain);
    EXPECT_EQ(claim.trouble, "cut");
}

TEST_F(AccountsOfARealm, AnyNameOfAnAccountMakesAKey) {
    EXPECT_EQ(Accounts::key_of("ann"), "account.616e6e");
    EXPECT_EQ(Accounts::key_of("*.>\xC3\xA4"), "account.2a2e3ec3a4");
    EXPECT_EQ(castle.claim("*.>", 1, true).owner, Owner::kHere);
    EXPECT_EQ(meadow.claim("ann", 1, true).owner, Owner::kHere);
}

}  // namespace zoned::cluster
