// PartyBook: parties by the orders of players, honest and hostile.
#include "server/zone/groups/party_book.h"

#include "server/zone/groups/rules_parties.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace zoned::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr PartySettings kSmall{3, 4, 10, 20};

/// Players 1..n, whose avatars are 101..100+n; odd ones have an account.
class Players {
  public:
    explicit Players(const PartySettings& settings = kSmall) : book(settings) {}

    [[nodiscard]] static EntityId avatar(std::uint32_t player) { return EntityId(100 + player); }

    void come(std::uint32_t player, std::uint16_t zone = 1) {
        const bool known = player % 2 == 1;
        PartyPlayer& seat = here[avatar(player)];
        seat = {avatar(player),
                ClientId(player),
                ZoneId(zone),
                known ? "account" + std::to_string(player) : "",
                "p" + std::to_string(player)};
        book.join(seat);
    }

    void go(std::uint32_t player) {
        here.erase(avatar(player));
        book.leave(ClientId(player));
    }

    /// With another client and avatar: the same account.
    void come_back(std::uint32_t player, std::uint32_t as) {
        PartyPlayer& seat = here[avatar(as)];
        seat = {avatar(as),
                ClientId(as),
                ZoneId(2),
                "account" + std::to_string(player),
                "p" + std::to_string(player)};
        book.join(seat);
    }

    void order(const PartyOrder& order) {
        book.apply(order, [this](EntityId of) -> std::optional<PartyPlayer> {
            const auto at = here.find(of);
            return at != here.end() ? std::optional(at->second) : std::nullopt;
        });
    }

    void invite(std::uint32_t by, std::uint32_t guest) {
        order({PartyAct::kInvite, ZoneId(1), avatar(by), avatar(guest), PartyId(), "", {}});
    }

    void answer(PartyAct act, std::uint32_t guest, PartyId party) {
        order({act, ZoneId(1), avatar(guest), EntityId(), party, "", {}});
    }

    void act(PartyAct act, std::uint32_t by, std::uint32_t other = 0) {
        order({act,
               ZoneId(1),
               avatar(by),
               other != 0 ? avatar(other) : EntityId(),
               PartyId(),
               "",
               {}});
    }

    void tick(Tick ticks = 1) {
        for (Tick t = 0; t < ticks; ++t) {
            book.begin(++now);
            EXPECT_EQ(book.unsound(), "");
        }
    }

    /// "joined 2", "refused 3 full" since the last tick.
    [[nodiscard]] std::vector<std::string> told() const {
        std::vector<std::string> lines;
        for (const PartyChange& change : book.changes()) {
            std::string line(kPartyEventNames[static_cast<std::size_t>(change.event)]);
            line += " " + std::to_string(change.player.value - 100);
            if (change.event == PartyEvent::kRefused) {
                line += " ";
                line += kPartyRefusalNames[static_cast<std::size_t>(change.refusal)];
            }
            lines.push_back(line);
        }
        return lines;
    }

    [[nodiscard]] std::vector<std::uint32_t> members(PartyId party) const {
        std::vector<std::uint32_t> out;
        if (const Party* of = book.find(party)) {
            for (const PartyMember& member : of->members) {
                out.push_back(member.player.avatar.value - 100);
            }
        }
        return out;
    }

    PartyBook book;
    std::map<EntityId, PartyPlayer> here;
    Tick now = 100;
};

constexpr PartyId kFirst{1};

class Parties : public ::testing::Test {
  protected:
    Parties() {
        for (std::uint32_t p = 1; p <= 8; ++p) {
            players.come(p);
        }
        players.tick();
    }

    /// Party 1 of 1, 2 and 3, led by 1.
    void form() {
        players.invite(1, 2);
        players.invite(1, 3);
        players.answer(PartyAct::kAccept, 2, kFirst);
        players.answer(PartyAct::kAccept, 3, kFirst);
        players.tick();
    }

    Players players;
};

TEST_F(Parties, BeginWithAnInvitationAndGrowByAnswers) {
    players.invite(1, 2);
    EXPECT_THAT(players.told(), ElementsAre("joined 1", "invited 2"));
    EXPECT_EQ(players.book.party_of(Players::avatar(1)), kFirst);
    EXPECT_FALSE(players.book.party_of(Players::avatar(2)));
    std::vector<PartyId> invitations;
    players.book.invitations_of(Players::avatar(2), invitations);
    EXPECT_THAT(invitations, ElementsAre(kFirst));
    players.answer(PartyAct::kAccept, 2, kFirst);
    players.tick();
    EXPECT_THAT(players.members(kFirst), ElementsAre(1, 2));
    EXPECT_EQ(players.book.invitations(), 0u);
}

TEST_F(Parties, EndWhereNobodyComes) {
    players.invite(1, 2);
    players.tick();
    players.answer(PartyAct::kDecline, 2, kFirst);
    EXPECT_THAT(players.told(), ElementsAre("declined 2", "left 1", "ended 1"));
    EXPECT_TRUE(players.book.parties().empty());
    players.invite(3, 4);
    players.tick(10);
    EXPECT_THAT(players.told(), ElementsAre("expired 4", "left 3", "ended 3"));
}

TEST_F(Parties, AskNobodyAgainSoonWhoHasDeclined) {
    players.invite(1, 2);
    players.answer(PartyAct::kDecline, 2, kFirst);
    players.tick(9);
    players.invite(1, 2);
    EXPECT_THAT(players.told(), ElementsAre("refused 1 declined"));
    players.tick();
    players.invite(1, 2);
    EXPECT_THAT(players.told(), ElementsAre("joined 1", "invited 2"));
}

TEST_F(Parties, HoldNoMoreThanTheirSize) {
    form();
    players.invite(1, 4);
    EXPECT_THAT(players.told(), ElementsAre("refused 1 full"));
    players.tick();
    // Two guests, one place.
    players.act(PartyAct::kKick, 1, 3);
    players.invite(1, 4);
    players.invite(1, 5);
    players.answer(PartyAct::kAccept, 4, kFirst);
    players.tick();
    players.answer(PartyAct::kAccept, 5, kFirst);
    EXPECT_THAT(players.told(), ElementsAre("refused 5 full"));
    EXPECT_THAT(players.members(kFirst), ElementsAre(1, 2, 4));
}

TEST_F(Parties, AreLedByOneWhoMayAskKickAndPass) {
    form();
    players.invite(2, 4);
    players.act(PartyAct::kKick, 2, 3);
    players.act(PartyAct::kPromote, 3, 2);
    players.act(PartyAct::kDisband, 3);
    EXPECT_THAT(players.told(),
                ElementsAre("refused 2 not_leader",
                            "refused 2 not_leader",
                            "refused 3 not_leader",
                            "refused 3 not_leader"));
    players.tick();
    players.act(PartyAct::kPromote, 1, 3);
    EXPECT_THAT(players.told(), ElementsAre("leads 3"));
    EXPECT_THAT(players.members(kFirst), ElementsAre(3, 1, 2));
    players.tick();
    players.act(PartyAct::kKick, 3, 1);
    EXPECT_THAT(players.told(), ElementsAre("kicked 1"));
    players.tick();
    players.act(PartyAct::kLeave, 3);
    EXPECT_THAT(players.told(), ElementsAre("left 3", "leads 2", "left 2", "ended 2"));
}

TEST_F(Parties, PassToTheNextWhoIsHere) {
    form();
    players.go(3);
    players.tick();
    players.act(PartyAct::kLeave, 1);
    EXPECT_THAT(players.told(), ElementsAre("left 1", "leads 2"));
    EXPECT_THAT(players.members(kFirst), ElementsAre(2, 3));
}

TEST_F(Parties, KeepThePlaceOfAnAccountAndOfNobodyElse) {
    form();
    players.go(1);
    EXPECT_THAT(players.told(), ElementsAre("leads 2", "away 1"));
    EXPECT_THAT(players.members(kFirst), ElementsAre(2, 1, 3));
    players.tick(19);
    EXPECT_THAT(players.told(), IsEmpty());
    players.come_back(3, 9);  // who is here already
    EXPECT_THAT(players.told(), IsEmpty());
    players.come_back(1, 10);
    EXPECT_THAT(players.told(), ElementsAre("back 10"));
    EXPECT_THAT(players.members(kFirst), ElementsAre(2, 10, 3));
    EXPECT_EQ(players.book.find(kFirst)->members[1].player.zone, ZoneId(2));
    EXPECT_FALSE(players.book.party_of(Players::avatar(1)));
    players.tick();
    players.go(2);  // without an account
    EXPECT_THAT(players.told(), ElementsAre("left 2", "leads 10"));
    players.go(3);
    players.tick(20);
    EXPECT_THAT(players.told(), ElementsAre("left 3", "left 10", "ended 10"));
}

TEST_F(Parties, ReturnToALeaderWhereAllWereAway) {
    form();
    players.act(PartyAct::kKick, 1, 2);
    players.go(1);
    players.go(3);
    players.tick();
    EXPECT_EQ(players.book.parties().size(), 1u);
    players.come_back(1, 11);
    EXPECT_THAT(players.told(), ElementsAre("back 11", "leads 11"));
}

TEST_F(Parties, RefuseForgeriesAndStrangers) {
    players.answer(PartyAct::kAccept, 2, PartyId(99));
    players.answer(PartyAct::kAccept, 2, PartyId());
    players.answer(PartyAct::kDecline, 2, kFirst);
    players.invite(1, 1);
    players.invite(1, 77);
    players.invite(77, 1);
    players.act(PartyAct::kLeave, 5);
    players.act(PartyAct::kKick, 5, 6);
    players.act(PartyAct::kPromote, 88, 6);
    EXPECT_THAT(players.told(),
                ElementsAre("refused 2 not_invited",
                            "refused 2 not_invited",
                            "refused 2 not_invited",
                            "refused 1 oneself",
                            "refused 1 no_player",
                            "refused 77 no_player",
                            "refused 5 no_party",
                            "refused 5 no_party",
                            "refused 88 no_player"));
    EXPECT_EQ(players.book.refused(), 9u);
    players.tick();
    form();
    players.invite(5, 6);
    players.tick();
    players.answer(PartyAct::kAccept, 7, PartyId(2));  // of 6
    players.answer(PartyAct::kAccept, 6, kFirst);      // which has not asked
    players.act(PartyAct::kKick, 1, 5);
    players.act(PartyAct::kPromote, 1, 5);
    players.act(PartyAct::kKick, 1, 1);
    players.invite(5, 2);
    players.invite(5, 6);
    EXPECT_THAT(players.told(),
                ElementsAre("refused 7 not_invited",
                            "refused 6 not_invited",
                            "refused 1 not_a_member",
                            "refused 1 not_a_member",
                            "refused 1 oneself",
                            "refused 5 in_a_party",
                            "refused 5 invited"));
}

TEST_F(Parties, AreNoMoreThanTheWorldHolds) {
    for (std::uint32_t p = 1; p <= 4; ++p) {
        players.invite(p, 8);
    }
    players.tick();
    players.invite(5, 6);
    EXPECT_THAT(players.told(), ElementsAre("refused 5 too_many"));
    // The guest takes one, and the others end.
    players.answer(PartyAct::kAccept, 8, PartyId(2));
    EXPECT_EQ(players.book.parties().size(), 1u);
    EXPECT_EQ(players.book.invitations(), 0u);
}

TEST(PartyLimits, EndAFloodOfInvitations) {
    Players players({5, 100, 1000, 20});
    for (std::uint32_t p = 1; p <= 40; ++p) {
        players.come(p);
    }
    players.tick();
    for (std::uint32_t p = 2; p <= 40; ++p) {
        players.invite(1, p);
    }
    EXPECT_EQ(players.book.invitations(), kMostInvitationsFrom);
    EXPECT_EQ(players.book.refused(), 39u - kMostInvitationsFrom);
    // Declining makes no room for more.
    for (std::uint32_t p = 2; p <= 40; ++p) {
        players.answer(PartyAct::kDecline, p, kFirst);
    }
    players.tick();
    for (std::uint32_t p = 2; p <= 40; ++p) {
        players.invite(1, p);
    }
    EXPECT_TRUE(players.book.parties().empty());
    for (std::uint32_t p = 2; p <= 40; ++p) {
        players.invite(p, 1);
    }
    std::vector<PartyId> to_one;
    players.book.invitations_of(Players::avatar(1), to_one);
    EXPECT_EQ(to_one.size(), kMostInvitationsTo);
}

TEST(PartyLimits, EndAFloodOfOrdersAndOfValues) {
    std::vector<PartyOrder> orders;
    PartyBook book(kSmall);
    RulesParties rules(ZoneId(3), orders);
    rules.open(book);
    std::size_t taken = 0;
    for (int i = 0; i < 3000; ++i) {
        taken += rules.invite(EntityId(1), EntityId(2)) ? 1U : 0U;
    }
    EXPECT_EQ(taken, kMostPartyOrders);
    EXPECT_EQ(orders.size(), kMostPartyOrders);
    EXPECT_EQ(orders.front().zone, ZoneId(3));
    orders.clear();
    const std::vector<std::uint8_t> large(kMostPartyValueBytes + 1);
    EXPECT_FALSE(rules.set_value(kFirst, "key", large));
    EXPECT_FALSE(rules.set_value(kFirst, "", {}));
    EXPECT_FALSE(rules.set_value(kFirst, std::string(kMostPartyKeyBytes + 1, 'x'), {}));
    EXPECT_TRUE(orders.empty());
}

TEST_F(Parties, ShareValues) {
    form();
    const auto set = [&](const std::string& key, std::vector<std::uint8_t> value) {
        players.order({PartyAct::kSetValue,
                       ZoneId(1),
                       EntityId(),
                       EntityId(),
                       kFirst,
                       key,
                       std::move(value)});
    };
    std::vector<PartyOrder> orders;
    RulesParties rules(ZoneId(1), orders);
    rules.open(players.book);
    const std::uint64_t before = players.book.digest();
    set("b", {1});
    set("a", {2, 3});
    EXPECT_NE(players.book.digest(), before);
    EXPECT_THAT(*rules.value(kFirst, "a"), ElementsAre(2, 3));
    set("a", {4});
    set("b", {});
    EXPECT_THAT(*rules.value(kFirst, "a"), ElementsAre(4));
    EXPECT_FALSE(rules.value(kFirst, "b"));
    EXPECT_FALSE(rules.value(PartyId(9), "a"));
    for (int i = 0; i < 30; ++i) {
        set("k" + std::to_string(i), {1});
    }
    EXPECT_EQ(players.book.find(kFirst)->values.size(), kMostPartyValues);
    EXPECT_EQ(players.book.refused(), 15u);
    EXPECT_EQ(players.book.unsound(), "");
}

/// The book, saved and loaded into another.
PartyBook copy_of(PartyBook& book, std::string& wrong) {
    std::vector<std::uint8_t> bytes;
    core::FieldWriter writer(bytes);
    book.serialize(writer);
    PartyBook copy(book.settings());
    core::FieldReader reader(bytes);
    copy.serialize(reader);
    wrong = reader.wrong();
    return copy;
}

/// Any order for any player, many of which are not there or may not.
PartyOrder random_order(core::Rng& rng, std::uint32_t players) {
    PartyOrder order;
    order.act = static_cast<PartyAct>(rng.below(8));
    order.zone = ZoneId(1);
    order.by = Players::avatar(1 + rng.below(players + 2));
    order.other = Players::avatar(1 + rng.below(players + 2));
    order.party = PartyId(rng.below(40));
    order.key = std::string(1, static_cast<char>('a' + rng.below(20)));
    order.value.assign(rng.below(3), 7);
    return order;
}

/// A book is whole, by its readers alone.
void expect_whole(const Players& players) {
    std::set<EntityId> seen;
    for (const Party& party : players.book.parties()) {
        ASSERT_FALSE(party.members.empty());
        ASSERT_LE(party.members.size(), players.book.settings().size);
        bool any_here = false;
        for (const PartyMember& member : party.members) {
            ASSERT_TRUE(seen.insert(member.player.avatar).second) << "in two parties";
            ASSERT_EQ(players.book.party_of(member.player.avatar), party.id);
            ASSERT_EQ(member.is_away(), !players.here.contains(member.player.avatar));
            any_here = any_here || !member.is_away();
        }
        ASSERT_EQ(players.book.party_of(party.leader()), party.id);
        ASSERT_TRUE(!any_here || !party.members.front().is_away());
    }
    for (const auto& [avatar, player] : players.here) {
        const PartyId party = players.book.party_of(avatar);
        ASSERT_TRUE(!party || seen.contains(avatar)) << "of a party that does not know it";
        std::vector<PartyId> invitations;
        players.book.invitations_of(avatar, invitations);
        ASSERT_LE(invitations.size(), kMostInvitationsTo);
        for (const PartyId to : invitations) {
            ASSERT_NE(players.book.find(to), nullptr);
        }
    }
}

TEST(PartyChance, NeverBreaksABookAndCopiesGoOnAlike) {
    constexpr std::uint32_t kPlayers = 30;
    std::map<PartyEvent, int> events;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        core::Rng rng(seed);
        Players players({4, 12, 15, 25});
        std::optional<Players> copy;
        for (int step = 0; step < 3000; ++step) {
            const auto each = [&](auto&& work) {
                work(players);
                if (copy) {
                    work(*copy);
                }
            };
            const std::uint32_t player = 1 + rng.below(kPlayers);
            const std::uint32_t chance = rng.below(20);
            if (chance < 2) {
                each([&](Players& p) {
                    p.here.contains(Players::avatar(player)) ? p.go(player) : p.come(player);
                });
            } else if (chance == 2) {
                each([&](Players& p) { p.book.move(ClientId(player), ZoneId(2)); });
            } else if (chance < 6) {
                each([](Players& p) { p.tick(); });
            } else {
                PartyOrder order = random_order(rng, kPlayers);
                std::vector<PartyId> invitations;
                players.book.invitations_of(order.by, invitations);
                if (!invitations.empty() && rng.below(2) == 0) {
                    order.party =
                        invitations[rng.below(static_cast<std::uint32_t>(invitations.size()))];
                }
                const Party* const own = players.book.find(players.book.party_of(order.by));
                if (own != nullptr && rng.below(2) == 0) {
                    order.by = own->leader();
                    order.other = own->members.back().player.avatar;
                }
                each([&](Players& p) { p.order(order); });
            }
            ASSERT_EQ(players.book.unsound(), "") << "seed " << seed << " step " << step;
            expect_whole(players);
            if (::testing::Test::HasFatalFailure()) {
                FAIL() << "seed " << seed << " step " << step;
            }
            if (step == 1500) {
                std::string wrong;
                copy.emplace(players.book.settings());
                copy->book = copy_of(players.book, wrong);
                copy->here = players.here;
                copy->now = players.now;
                ASSERT_EQ(wrong, "");
            }
            if (copy) {
                ASSERT_EQ(copy->book.digest(), players.book.digest()) << step;
                ASSERT_EQ(copy->told(), players.told()) << step;
            }
            for (const PartyChange& change : players.book.changes()) {
                ++events[change.event];
            }
        }
    }
    for (std::size_t event = 0; event < std::size(kPartyEventNames); ++event) {
        EXPECT_GT(events[static_cast<PartyEvent>(event)], 100) << kPartyEventNames[event];
    }
}

TEST(PartyChance, DamagedBooksAreRefusedOrWhole) {
    Players players;
    for (std::uint32_t p = 1; p <= 8; ++p) {
        players.come(p);
    }
    players.tick();
    players.invite(1, 2);
    players.answer(PartyAct::kAccept, 2, kFirst);
    players.invite(1, 3);
    players.invite(4, 5);
    players.tick();
    std::vector<std::uint8_t> bytes;
    core::FieldWriter writer(bytes);
    players.book.serialize(writer);
    core::Rng rng(4);
    std::size_t refused = 0;
    constexpr std::size_t kTries = 5000;
    for (std::size_t i = 0; i < kTries; ++i) {
        std::vector<std::uint8_t> damaged = bytes;
        damaged[rng.below(static_cast<std::uint32_t>(damaged.size()))] ^=
            static_cast<std::uint8_t>(1U << rng.below(8));
        PartyBook book(kSmall);
        core::FieldReader reader(damaged);
        book.serialize(reader);
        if (!reader.good()) {
            ++refused;
            continue;
        }
        EXPECT_EQ(book.unsound(), "");
        book.begin(players.now + 1000);  // and it goes on
    }
    EXPECT_GT(refused, kTries / 4);
}

}  // namespace
}  // namespace zoned::zone
