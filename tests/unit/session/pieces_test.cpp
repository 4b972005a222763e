#include "server/session/host/session_table.h"
#include "server/session/input_gate.h"
#include "server/session/login/display_names.h"
#include "server/session/login/nonce_set.h"
#include "server/session/login/secrets.h"
#include "server/session/login/ticket.h"
#include "shared/core/hex.h"
#include "shared/core/rng.h"
#include "shared/core/token_bucket.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace zoned::session {
namespace {

motion::InputCommand at(Tick tick) {
    motion::InputCommand command;
    command.tick = tick;
    return command;
}

std::vector<Tick> passed(InputGate& gate,
                         const std::vector<motion::InputCommand>& commands,
                         Tick now,
                         RejectCounters& rejects) {
    InputGate::PassedCommands out;
    gate.filter(commands, now, 32, rejects, out);
    std::vector<Tick> ticks;
    for (const auto& c : out) {
        ticks.push_back(c.tick);
    }
    return ticks;
}

TEST(InputGate, LetsEachTickThroughOnceAndDropsRepetitionsSilently) {
    InputGate gate;
    RejectCounters rejects;
    EXPECT_EQ(passed(gate, {at(100), at(101), at(103)}, 99, rejects),
              (std::vector<Tick>{100, 101, 103}));
    EXPECT_EQ(passed(gate, {at(101), at(102), at(103), at(104)}, 100, rejects),
              (std::vector<Tick>{102, 104}));
    EXPECT_EQ(passed(gate, {at(100), at(101)}, 109, rejects), (std::vector<Tick>{}));
    EXPECT_TRUE(rejects.by_name().empty());
}

TEST(InputGate, RefusesTicksOutsideTheWindow) {
    InputGate gate;
    RejectCounters rejects;
    EXPECT_EQ(passed(gate, {at(91), at(92)}, 100, rejects), (std::vector<Tick>{92}));
    EXPECT_EQ(rejects.of(Reject::kInputLate), 1U);
    EXPECT_EQ(rejects.of(Reject::kInputMissed), 1U);
    EXPECT_EQ(passed(gate, {at(132), at(133)}, 100, rejects), (std::vector<Tick>{132}));
    EXPECT_EQ(rejects.of(Reject::kInputAhead), 1U);
}

TEST(InputGate, CountsACommandWhoseTickIsOverOnce) {
    InputGate gate;
    RejectCounters rejects;
    EXPECT_EQ(passed(gate, {at(99), at(100), at(101)}, 100, rejects).size(), 3U);
    EXPECT_EQ(rejects.of(Reject::kInputMissed), 2U);
    EXPECT_TRUE(passed(gate, {at(99), at(100), at(101)}, 102, rejects).empty());
    EXPECT_EQ(rejects.of(Reject::kInputMissed), 2U);
}

TEST(InputGate, RefusesValuesThatNoClientMaySend) {
    InputGate gate;
    RejectCounters rejects;
    motion::InputCommand move = at(100);
    move.move_x = -128;
    motion::InputCommand pitch = at(101);
    pitch.pitch = 16385;
    EXPECT_EQ(passed(gate, {move, pitch, at(102)}, 100, rejects), (std::vector<Tick>{102}));
    EXPECT_EQ(rejects.of(Reject::kInputRange), 2U);
}

TEST(InputGate, LetsNoTickThroughTwiceInALongRandomRun) {
    InputGate gate;
    RejectCounters rejects;
    core::Rng rng(5);
    std::vector<int> times(3000, 0);
    for (Tick now = 0; now < 2900; ++now) {
        for (int k = 0; k < 4; ++k) {
            const Tick first = std::max<Tick>(0, now - 15 + rng.below(60));
            std::vector<motion::InputCommand> commands;
            for (Tick t = first; t < first + 1 + rng.below(8); ++t) {
                commands.push_back(at(t));
            }
            for (const Tick t : passed(gate, commands, now, rejects)) {
                EXPECT_GE(t, now - kInputLateTicks);
                EXPECT_LE(t, now + 32);
                ++times.at(static_cast<std::size_t>(t));
            }
        }
    }
    EXPECT_EQ(*std::max_element(times.begin(), times.end()), 1);
    // About eighteen commands a tick are offered, so hardly a tick may be missing.
    EXPECT_GT(std::count(times.begin(), times.end(), 1), 2800);
}

TEST(TokenBucket, AllowsTheBurstThenTheRate) {
    core::TokenBucket bucket(10.0, 5.0);
    int taken = 0;
    for (int i = 0; i < 100; ++i) {
        taken += bucket.take(1.0) ? 1 : 0;
    }
    EXPECT_EQ(taken, 5);
    for (int i = 1; i <= 1000; ++i) {
        taken += bucket.take(1.0 + i * 0.01) ? 1 : 0;
    }
    // Ten seconds at ten a second, one more or less by rounding.
    EXPECT_NEAR(taken, 105, 1);
    EXPECT_FALSE(bucket.take(0.0));
}

TEST(NonceSet, ForgetsOnlyWhatExpiredAndTakesNoMoreThanItsCapacity) {
    NonceSet set(2);
    const TicketNonce a = random_nonce();
    const TicketNonce b = random_nonce();
    set.insert(a, 100);
    set.insert(b, 200);
    EXPECT_FALSE(set.has_room(99));
    EXPECT_TRUE(set.contains(a));
    EXPECT_TRUE(set.has_room(100));
    EXPECT_FALSE(set.contains(a));
    EXPECT_TRUE(set.contains(b));
}

TEST(Names, AcceptsCleanUtf8Only) {
    for (const char* good : {"a", "Zoë", "日本", "a b", "\xF0\x9F\x98\x80"}) {
        EXPECT_TRUE(is_valid_name(good)) << good;
    }
    for (const char* bad : {"",
                            "\xC3",              // cut off
                            "\xC0\x80",          // longer than need be
                            "\xED\xA0\x80",      // surrogate
                            "\xF4\x90\x80\x80",  // beyond U+10FFFF
                            "\x80",
                            "\xFF",
                            "a\x7F",
                            "\xC2\x85"}) {  // a control character of C1
        EXPECT_FALSE(is_valid_name(bad)) << bad;
    }
    EXPECT_EQ(printable("a\nb\xFF", 3), "a?b...");
}

TEST(Secrets, ReadsBackTheHexFormOfAKey) {
    const KeyPair pair = generate_key_pair();
    const auto back = parse_key_hex(" " + core::to_hex(pair.public_key) + "\n");
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, pair.public_key);
    EXPECT_FALSE(parse_key_hex(""));
    EXPECT_FALSE(parse_key_hex("abcd"));
    EXPECT_FALSE(parse_key_hex(std::string(64, 'g')));
}

TEST(Secrets, DerivesThePublicKeyOfTheFirstVectorOfRfc8032) {
    const auto secret =
        parse_key_hex("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60");
    ASSERT_TRUE(secret);
    EXPECT_EQ(core::to_hex(public_key_of(*secret)),
              "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a");
}

TEST(Ticket, RefusesToSignClaimsOutOfRange) {
    const KeyPair pair = generate_key_pair();
    TicketClaims claims;
    claims.account = "a";
    claims.rights = 1;
    claims.expires_s = 10;
    EXPECT_TRUE(create_ticket(claims, pair.private_key));
    TicketClaims bad = claims;
    bad.account.clear();
    EXPECT_FALSE(create_ticket(bad, pair.private_key));
    bad = claims;
    bad.name = std::string(33, 'x');
    EXPECT_FALSE(create_ticket(bad, pair.private_key));
    bad = claims;
    bad.expires_s = 0;
    EXPECT_FALSE(create_ticket(bad, pair.private_key));
}

TEST(RejectCounters, NamesEveryReason) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(Reject::kCount); ++i) {
        EXPECT_STRNE(reject_name(static_cast<Reject>(i)), "");
    }
    EXPECT_STREQ(reject_name(Reject::kOutAuditNoRight), "out_audit_no_right");
    EXPECT_STREQ(reject_name(Reject::kNotAuthentic), "not_authentic");
    EXPECT_STREQ(reject_name(Reject::kCommandGap), "command_gap");
}

}  // namespace
}  // namespace zoned::session
