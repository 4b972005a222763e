// MatchBook: the matches of a world, and those who wait for one.
#pragma once

#include "server/zone/groups/instance_book.h"
#include "server/zone/groups/match.h"
#include "server/zone/groups/party_book.h"
#include "shared/core/state_hash.h"

#include <bit>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::zone {

/// One book for all zones, as the parties' is (party_book.h).
class MatchBook {
  public:
    explicit MatchBook(MatchSettings settings) : settings_(std::move(settings)) {}

    // ---- for rules ----

    /// Null: there is no such match, or it has ended.
    [[nodiscard]] const Match* find(MatchId match) const;
    /// The match of a player that is in one and not lost; none: in no match.
    [[nodiscard]] MatchId match_of(EntityId avatar) const;

    [[nodiscard]] bool waits(EntityId avatar) const { return waiting_.contains(avatar); }

    [[nodiscard]] bool has_kind(std::string_view name) const;
    [[nodiscard]] const MatchKind& kind_of(const Match& match) const;

    // ---- for the world, in this order ----

    /// Forgets the changes of the last tick, and matches that have ended. `instances` may be null,
    /// and so may `parties` below.
    void begin(Tick now, InstanceBook* instances);
    void apply(const MatchOrder& order, const PlayerLookup& player_of, const PartyBook* parties);
    void move(ClientId client, ZoneId zone);
    void leave(ClientId client);
    /// Makes matches of those who wait, and ends what is over. Instances are opened and ended.
    void form(InstanceBook* instances, const ZoneLookup& zone_of);

    [[nodiscard]] std::span<const MatchChange> changes() const { return changes_; }

    [[nodiscard]] bool tells(ZoneId zone) const;

    [[nodiscard]] std::span<const Match> matches() const { return matches_; }

    [[nodiscard]] std::size_t tickets() const { return tickets_.size(); }

    [[nodiscard]] std::uint64_t refused() const { return refused_; }

    [[nodiscard]] Tick changed() const { return changed_; }

    [[nodiscard]] std::uint64_t digest() const { return digest_.value(); }

    [[nodiscard]] std::string unsound() const;

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t digest = digest_.value();
        archive(matches_, tickets_, changes_, next_match_, next_ticket_, refused_, changed_);
        archive(digest, now_, look_at_);
        if constexpr (Archive::kReads) {
            take_over(digest);
            std::string wrong = unsound();
            if (!wrong.empty()) {
                archive.fail(std::move(wrong));
            }
        }
    }

  private:
    /// A player or a party that waits.
    struct Ticket {
        std::uint64_t number = 0;
        std::uint16_t kind = 0;
        Tick since = 0;
        std::vector<MatchPlayer> players;
    };

    void queue(const MatchOrder& order, const PlayerLookup& player_of, const PartyBook* parties);
    void end_by_rules(const MatchOrder& order);
    [[nodiscard]] MatchRefusal not_to_wait(const Ticket& ticket, const MatchKind& kind) const;
    void remove_ticket(std::size_t place, bool tells);
    void form_kind(std::uint16_t kind, InstanceBook* instances, const ZoneLookup& zone_of);
    /// True: a match came about of tickets of a kind, from the `first` on.
    bool form_from(const std::vector<std::size_t>& of_kind,
                   std::size_t first,
                   InstanceBook* instances,
                   const ZoneLookup& zone_of);
    void begin_match(std::uint16_t kind,
                     const std::vector<std::size_t>& places,
                     const std::vector<std::uint16_t>& teams,
                     InstanceId instance,
                     ZoneId zone);
    void fill_places(Match& match);
    void call(Match& match, const Ticket& ticket, std::uint16_t team);
    void follow(Match& match, InstanceBook* instances);
    void lose(Match& match, MatchPlayer& player);
    void come(Match& match, MatchPlayer& player);
    void end(Match& match, std::uint16_t event, std::vector<std::uint8_t> result);

    void tell(MatchEvent event, const Match& match, const MatchPlayer* player);
    void tell_waiting(MatchEvent event, const Ticket& ticket);
    void refuse(const MatchOrder& order, ZoneId zone, MatchRefusal why);
    void note(MatchChange change);
    void take_over(std::uint64_t digest);

    MatchSettings settings_;
    std::vector<Match> matches_;   // ascending by id
    std::vector<Ticket> tickets_;  // ascending by number
    std::vector<MatchChange> changes_;
    std::uint32_t next_match_ = 0;
    std::uint64_t next_ticket_ = 0;
    std::uint64_t refused_ = 0;
    Tick changed_ = 0;
    core::StateHash digest_;
    Tick now_ = 0;
    Tick look_at_ = 0;  // when form() looks at the queue anew; 0: not before it changes
    // These follow from the others.
    std::map<EntityId, std::uint64_t> waiting_;  // number of the ticket
    std::map<EntityId, MatchId> playing_;
    std::map<ClientId, EntityId> avatars_;  // of both
};

}  // namespace zoned::zone
