// MatchBook: the queue, matches from the call to the end, honest and hostile players.
#include "server/zone/groups/match_book.h"

#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace zoned::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// duel: 2 x 1, 50 ticks; brawl: 2 x 3, two are enough after 20 ticks, in a crypt, backfill.
MatchSettings settings() {
    MatchSettings out;
    out.kinds.push_back({"duel", 2, 1, 1, "", 20, 50, false});
    out.kinds.push_back({"brawl", 2, 3, 2, "crypt", 20, 0, true});
    out.call_ticks = 15;
    out.grace_ticks = 5;
    return out;
}

InstanceSettings two_crypts() {
    InstanceSettings out;
    InstanceKind crypt;
    crypt.name = "crypt";
    crypt.copies = {{ZoneId(2), Vec3d::Zero()}, {ZoneId(3), Vec3d::Zero()}};
    crypt.entrances = {Vec3d::Zero()};
    crypt.close_ticks = 1000;
    out.kinds.push_back(crypt);
    return out;
}

/// Players 1..n with avatars 101..100+n in the first zone.
class Arena {
  public:
    [[nodiscard]] static EntityId avatar(std::uint32_t player) { return EntityId(100 + player); }

    void come(std::uint32_t player) {
        here[avatar(player)] = {avatar(player), ClientId(player), ZoneId(1), "", "p"};
    }

    void go(std::uint32_t player) {
        here.erase(avatar(player));
        leaving.push_back(player);
    }

    void queue(std::uint32_t player, const std::string& kind) {
        orders.push_back({MatchAct::kQueue, ZoneId(1), avatar(player), MatchId(), kind, 0, {}});
    }

    void unqueue(std::uint32_t player) {
        orders.push_back({MatchAct::kUnqueue, ZoneId(1), avatar(player), MatchId(), "", 0, {}});
    }

    void end(std::uint32_t match, std::vector<std::uint8_t> result = {}) {
        orders.push_back({MatchAct::kEnd,
                          ZoneId(1),
                          EntityId(),
                          MatchId(match),
                          "",
                          static_cast<std::uint16_t>(result.empty() ? 0 : 100),
                          std::move(result)});
    }

    /// Called players arrive in the same tick, unless they stay away.
    void walk(std::uint32_t player, std::uint16_t zone) {
        PartyPlayer& seat = here.at(avatar(player));
        seat.zone = ZoneId(zone);
        book.move(seat.client, seat.zone);
        instances.move(seat.client, seat.zone);
        parties.move(seat.client, seat.zone);
    }

    void tick(int count = 1) {
        for (int i = 0; i < count; ++i) {
            ++now;
            for (const EntityId called : std::exchange(arriving, {})) {
                if (const Match* const match = book.find(book.match_of(called));
                    match != nullptr && !stays.contains(called) && here.contains(called)) {
                    walk(called.value - 100, match->zone.value);
                }
            }
            const ZoneLookup zone_of = [this](ZoneId zone) {
                ZoneUse use;
                for (const auto& [id, player] : here) {
                    use.clients += player.zone == zone ? 1 : 0;
                }
                return use;
            };
            const PlayerLookup player_of = [this](EntityId of) -> std::optional<PartyPlayer> {
                const auto at = here.find(of);
                return at != here.end() ? std::optional(at->second) : std::nullopt;
            };
            parties.begin(now);
            for (const PartyOrder& order : std::exchange(party_orders, {})) {
                parties.apply(order, player_of);
            }
            instances.begin(now, zone_of);
            book.begin(now, &instances);
            for (const MatchOrder& order : std::exchange(orders, {})) {
                book.apply(order, player_of, &parties);
            }
            for (const std::uint32_t player : std::exchange(leaving, {})) {
                parties.leave(ClientId(player));
                instances.leave(ClientId(player));
                book.leave(ClientId(player));
            }
            book.form(&instances, zone_of);
            ASSERT_EQ(book.unsound(), "");
            for (const MatchChange& change : book.changes()) {
                if (change.event == MatchEvent::kCalled && change.zone == ZoneId(1)) {
                    arriving.push_back(change.player);
                }
            }
        }
    }

    void party(std::uint32_t leader, const std::vector<std::uint32_t>& members) {
        for (const std::uint32_t member : members) {
            party_orders.push_back(
                {PartyAct::kInvite, ZoneId(1), avatar(leader), avatar(member), PartyId(), "", {}});
        }
        tick();
        const PartyId id = parties.party_of(avatar(leader));
        for (const std::uint32_t member : members) {
            party_orders.push_back(
                {PartyAct::kAccept, ZoneId(1), avatar(member), EntityId(), id, "", {}});
        }
        tick();
    }

    [[nodiscard]] std::vector<std::string> told() const {
        std::vector<std::string> lines;
        for (const MatchChange& change : book.changes()) {
            std::string line(kMatchEventNames[static_cast<std::size_t>(change.event)]);
            if (change.player) {
                line += " " + std::to_string(change.player.value - 100);
            }
            if (change.event == MatchEvent::kCalled || change.event == MatchEvent::kCame) {
                line += " team " + std::to_string(change.team);
            }
            if (change.event == MatchEvent::kRefused) {
                line += " ";
                line += kMatchRefusalNames[static_cast<std::size_t>(change.refusal)];
            }
            lines.push_back(line);
        }
        return lines;
    }

    MatchBook book{settings()};
    InstanceBook instances{two_crypts()};
    PartyBook parties{PartySettings{4, 100, 100, 0}};
    std::map<EntityId, PartyPlayer> here;
    std::vector<MatchOrder> orders;
    std::vector<PartyOrder> party_orders;
    std::vector<std::uint32_t> leaving;
    std::vector<EntityId> arriving;
    std::set<EntityId> stays;
    Tick now = 100;
};

class Matches : public ::testing::Test {
  protected:
    Matches() {
        for (std::uint32_t p = 1; p <= 12; ++p) {
            arena.come(p);
        }
        arena.tick();
    }

    Arena arena;
};

TEST_F(Matches, BeginWithThoseWhoWaitAndEndWithTheirTime) {
    arena.queue(1, "duel");
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("queued 1"));
    EXPECT_TRUE(arena.book.waits(Arena::avatar(1)));
    arena.queue(2, "duel");
    arena.queue(3, "duel");
    arena.tick();
    EXPECT_THAT(arena.told(),
                ElementsAre("queued 2", "queued 3", "called 1 team 0", "called 2 team 1"));
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("came 1 team 0", "came 2 team 1", "began"));
    EXPECT_EQ(arena.book.match_of(Arena::avatar(2)), MatchId(1));
    arena.tick(49);
    EXPECT_THAT(arena.told(), IsEmpty());
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("time_up"));
    arena.tick(5);
    EXPECT_THAT(arena.told(), ElementsAre("ended"));
    EXPECT_FALSE(arena.book.match_of(Arena::avatar(2)));
    arena.queue(2, "duel");
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("queued 2", "called 3 team 0", "called 2 team 1"));
}

TEST_F(Matches, DifferInTheirDigestByAResultAlone) {
    std::set<std::uint64_t> digests;
    for (const std::uint8_t result : {7, 8}) {
        Arena one;
        for (const std::uint32_t player : {1U, 2U}) {
            one.come(player);
            one.queue(player, "duel");
        }
        one.tick(2);
        one.end(1, {result});
        one.tick();
        digests.insert(one.book.digest());
    }
    EXPECT_EQ(digests.size(), 2U);
}

TEST_F(Matches, EndByRulesWithAResult) {
    arena.queue(1, "duel");
    arena.queue(2, "duel");
    arena.tick(2);
    arena.end(1, {7, 8});
    arena.tick();
    ASSERT_THAT(arena.told(), ElementsAre("ended"));
    EXPECT_THAT(arena.book.changes()[0].result, ElementsAre(7, 8));
    EXPECT_EQ(arena.book.changes()[0].result_event, 100);
    arena.end(1, {9});
    arena.end(99);
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("refused no_match", "refused no_match"));
    arena.tick(2);
    EXPECT_TRUE(arena.book.matches().empty());
}

TEST_F(Matches, TakePartiesAsAWholeByTheirLeader) {
    arena.party(1, {2, 3});
    arena.queue(2, "brawl");
    arena.queue(1, "duel");
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("refused 2 not_leader", "refused 1 too_large"));
    arena.queue(4, "brawl");
    arena.queue(5, "brawl");
    arena.queue(1, "brawl");
    arena.queue(6, "brawl");
    arena.tick();
    std::map<std::uint32_t, std::uint16_t> team;
    for (const MatchPlayer& player : arena.book.matches()[0].players) {
        team[player.avatar.value - 100] = player.team;
    }
    ASSERT_EQ(team.size(), 6u);
    EXPECT_EQ(team[1], team[2]);
    EXPECT_EQ(team[1], team[3]);
    EXPECT_NE(team[1], team[4]);
    EXPECT_EQ(arena.instances.open().size(), 1u);
    EXPECT_EQ(arena.book.matches()[0].zone, ZoneId(2));
}

TEST_F(Matches, WaitForMoreAndThenBeginWithFewer) {
    for (const std::uint32_t player : {1U, 2U, 3U, 4U}) {
        arena.queue(player, "brawl");
    }
    arena.tick(20);
    EXPECT_TRUE(arena.book.matches().empty());
    arena.tick();
    EXPECT_EQ(arena.book.matches().size(), 1u);
    // Later ones fill its places.
    arena.tick(3);
    arena.queue(5, "brawl");
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("queued 5", "called 5 team 0"));
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("came 5 team 0"));
    arena.go(5);
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("lost 5"));
}

TEST_F(Matches, WaitForAFreeInstance) {
    for (std::uint32_t player = 1; player <= 12; ++player) {
        arena.queue(player, "brawl");
    }
    arena.tick();
    EXPECT_EQ(arena.book.matches().size(), 2u);
    for (std::uint32_t player = 13; player <= 18; ++player) {
        arena.come(player);
        arena.queue(player, "brawl");
    }
    arena.tick(60);
    EXPECT_EQ(arena.book.matches().size(), 2u);
    EXPECT_EQ(arena.book.tickets(), 6u);
    arena.end(1);
    arena.tick(2);
    for (std::uint32_t player = 1; player <= 6; ++player) {
        arena.walk(player, 1);  // taken back
    }
    arena.tick(40);
    EXPECT_EQ(arena.book.matches().size(), 2u);
    EXPECT_EQ(arena.book.tickets(), 0u);
}

TEST_F(Matches, LoseThoseWhoDoNotComeOrWalkAway) {
    arena.stays.insert(Arena::avatar(3));
    for (std::uint32_t player = 1; player <= 6; ++player) {
        arena.queue(player, "brawl");
    }
    arena.tick(10);
    EXPECT_EQ(arena.book.matches()[0].began, 0);
    arena.tick(6);
    EXPECT_THAT(arena.told(), ElementsAre("lost 3", "began"));
    arena.walk(4, 1);
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("lost 4"));
    for (const std::uint32_t player : {1U, 2U, 5U, 6U}) {
        arena.go(player);
    }
    arena.tick(2);
    EXPECT_THAT(arena.told(), ElementsAre("ended"));
    EXPECT_TRUE(arena.instances.open().empty() || arena.instances.open()[0].ends);
}

TEST_F(Matches, RefuseForgeriesAndStrangers) {
    arena.queue(1, "duel");
    arena.queue(1, "brawl");
    arena.queue(77, "duel");
    arena.queue(2, "chess");
    arena.unqueue(2);
    arena.tick();
    EXPECT_THAT(arena.told(),
                ElementsAre("queued 1",
                            "refused 1 waiting",
                            "refused 77 no_player",
                            "refused 2 no_kind",
                            "refused 2 not_waiting"));
    arena.queue(2, "duel");
    arena.tick(2);
    arena.queue(2, "duel");
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("refused 2 playing"));
    EXPECT_EQ(arena.book.refused(), 5u);
    arena.queue(3, "duel");
    arena.tick();
    arena.unqueue(3);
    arena.tick();
    EXPECT_THAT(arena.told(), ElementsAre("unqueued 3"));
    EXPECT_FALSE(arena.book.waits(Arena::avatar(3)));
}

TEST(MatchChance, NeverBreaksABookAndCopiesGoOnAlike) {
    constexpr std::uint32_t kPlayers = 40;
    std::map<MatchEvent, int> events;
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
        core::Rng rng(seed);
        Arena arena;
        std::optional<Arena> copy;
        for (int step = 0; step < 2000; ++step) {
            const std::uint32_t player = 1 + rng.below(kPlayers);
            const std::uint32_t chance = rng.below(40);
            const std::uint32_t number = 1 + rng.below(30);
            const bool known = arena.here.contains(Arena::avatar(player));
            for (Arena* a : {&arena, copy ? &*copy : nullptr}) {
                if (a == nullptr) {
                    continue;
                }
                if (!known) {
                    a->come(player);
                } else if (chance == 0 || chance > 36) {
                    a->go(player);
                } else if (chance < 12) {
                    a->queue(player, chance < 4 ? "duel" : "brawl");
                } else if (chance == 12) {
                    a->unqueue(player);
                } else if (chance == 13) {
                    a->walk(player, static_cast<std::uint16_t>(1 + number % 3));
                } else if (chance == 14 && !a->book.matches().empty()) {
                    a->end(a->book.matches()[number % a->book.matches().size()].id.value,
                           {static_cast<std::uint8_t>(number)});
                } else if (chance == 15) {
                    a->party_orders.push_back({PartyAct::kInvite,
                                               ZoneId(1),
                                               Arena::avatar(player),
                                               Arena::avatar(number),
                                               PartyId(),
                                               "",
                                               {}});
                } else if (chance == 16) {
                    a->party_orders.push_back({PartyAct::kAccept,
                                               ZoneId(1),
                                               Arena::avatar(player),
                                               EntityId(),
                                               PartyId(number),
                                               "",
                                               {}});
                }
                a->tick();
                if (::testing::Test::HasFatalFailure()) {
                    FAIL() << "seed " << seed << " step " << step;
                }
            }
            // Players of matches that are over are taken back.
            for (const MatchChange& change : arena.book.changes()) {
                ++events[change.event];
            }
            if (step == 1000) {
                std::vector<std::uint8_t> bytes;
                core::FieldWriter writer(bytes);
                arena.book.serialize(writer);
                copy.emplace(arena);
                copy->book = MatchBook(settings());
                core::FieldReader reader(bytes);
                copy->book.serialize(reader);
                ASSERT_EQ(reader.wrong(), "");
            }
            if (copy) {
                ASSERT_EQ(copy->book.digest(), arena.book.digest()) << step;
                ASSERT_EQ(copy->told(), arena.told()) << step;
            }
        }
    }
    for (std::size_t event = 0; event < std::size(kMatchEventNames); ++event) {
        EXPECT_GT(events[static_cast<MatchEvent>(event)], 50) << kMatchEventNames[event];
    }
}

TEST(MatchChance, DamagedBooksAreRefusedOrWhole) {
    Arena arena;
    for (std::uint32_t p = 1; p <= 9; ++p) {
        arena.come(p);
        arena.queue(p, p < 7 ? "brawl" : "duel");
    }
    arena.tick(3);
    std::vector<std::uint8_t> bytes;
    core::FieldWriter writer(bytes);
    arena.book.serialize(writer);
    core::Rng rng(4);
    std::size_t refused = 0;
    for (int i = 0; i < 5000; ++i) {
        std::vector<std::uint8_t> damaged = bytes;
        damaged[rng.below(static_cast<std::uint32_t>(damaged.size()))] ^=
            static_cast<std::uint8_t>(1U << rng.below(8));
        MatchBook book(settings());
        core::FieldReader reader(damaged);
        book.serialize(reader);
        refused += reader.good() ? 0 : 1;
        if (reader.good()) {
            EXPECT_EQ(book.unsound(), "");
            book.begin(arena.now + 1000, nullptr);
        }
    }
    EXPECT_GT(refused, 500u);
}

}  // namespace
}  // namespace zoned::zone
