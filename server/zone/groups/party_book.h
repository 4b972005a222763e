// PartyBook: the parties of a world, their invitations, and those who will come back.
#pragma once

#include "server/zone/groups/party.h"
#include "shared/core/state_hash.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::zone {

/// The player of an avatar; none: it is not that of a player who is here.
using PlayerLookup = std::function<std::optional<PartyPlayer>(EntityId avatar)>;

/// One book for all zones. Zones read it while they run, and the world writes it between the halves
/// of a tick, in an order that depends on nothing but the items of the tick.
class PartyBook {
  public:
    explicit PartyBook(PartySettings settings) : settings_(settings) {}

    // ---- for rules ----

    /// None: the player is in no party.
    [[nodiscard]] PartyId party_of(EntityId avatar) const;
    /// Null: there is no such party, or it has ended.
    [[nodiscard]] const Party* find(PartyId party) const;
    /// Appends the parties that an answer of a player is due to, by the inviter's client.
    void invitations_of(EntityId guest, std::vector<PartyId>& out) const;

    [[nodiscard]] const PartySettings& settings() const { return settings_; }

    // ---- for the world, in each tick: begin, then what has happened in it ----

    /// Forgets the changes of the last tick, and ends what is over.
    void begin(Tick now);
    void apply(const PartyOrder& order, const PlayerLookup& player_of);
    /// A player came into the world: one that was away has its place back.
    void join(const PartyPlayer& player);
    /// A client left the world for good.
    void leave(ClientId client);
    /// The avatar of a client is in another zone.
    void move(ClientId client, ZoneId zone);

    /// Since begin(), in their order.
    [[nodiscard]] std::span<const PartyChange> changes() const { return changes_; }

    /// True where the changes of this tick are for a zone.
    [[nodiscard]] bool tells(ZoneId zone) const;

    [[nodiscard]] std::span<const Party> parties() const { return parties_; }

    [[nodiscard]] std::size_t invitations() const { return invitations_.size(); }

    /// Orders that were refused so far.
    [[nodiscard]] std::uint64_t refused() const { return refused_; }

    /// The newest tick in which something has happened.
    [[nodiscard]] Tick changed() const { return changed_; }

    /// Chains all that has happened.
    [[nodiscard]] std::uint64_t digest() const { return digest_.value(); }

    /// The first thing that cannot be; empty: all is well. For tests, and for saved books, whose
    /// bytes may be damaged.
    [[nodiscard]] std::string unsound() const;

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t digest = digest_.value();
        archive(parties_, invitations_, changes_, next_party_, refused_, changed_, digest, now_);
        if constexpr (Archive::kReads) {
            take_over(digest);
            std::string wrong = unsound();
            if (!wrong.empty()) {
                archive.fail(std::move(wrong));
            }
        }
    }

  private:
    struct Invitation {
        PartyId party;
        Tick until = 0;
        bool open = true;  ///< false: declined, and nobody is asked again until then
    };

    /// The guest's avatar, then the inviter.
    using InvitationKey = std::pair<EntityId, ClientId>;
    using Invitations = std::map<InvitationKey, Invitation>;

    Party* found(PartyId party);
    [[nodiscard]] std::size_t place_of(const Party& party, EntityId avatar) const;
    /// The party that a player leads; null, and the order is refused: it leads none.
    Party* led_by(const PartyOrder& order, const std::optional<PartyPlayer>& by);

    void invite(const PartyOrder& order, const PlayerLookup& player_of);
    void accept(const PartyOrder& order, const PlayerLookup& player_of);
    void decline(const PartyOrder& order);
    void quit(const PartyOrder& order);
    void kick(const PartyOrder& order, const PlayerLookup& player_of);
    void promote(const PartyOrder& order, const PlayerLookup& player_of);
    void disband(const PartyOrder& order, const PlayerLookup& player_of);
    void set_value(const PartyOrder& order);

    [[nodiscard]] PartyRefusal not_to_invite(const PartyPlayer& by, const PartyPlayer& guest) const;
    [[nodiscard]] Invitations::iterator open_invitation(EntityId guest, PartyId party);
    Party& begin_party(const PartyPlayer& founder);
    void add_member(Party& party, const PartyPlayer& player);
    void remove_member(PartyId party, EntityId avatar, PartyEvent event, EntityId other);
    /// A member that is here leads, if any is. True: another one than before.
    bool choose_leader(Party& party);
    /// The place of an invitation in its party is free again.
    void close(Invitations::iterator invitation, PartyEvent event);
    void withdraw_invitations_to(EntityId guest);
    /// Ends a party of fewer than two that nobody is invited to.
    void end_if_over(PartyId party);
    void end(PartyId party);

    void tell(PartyEvent event,
              const Party& party,
              const PartyMember& member,
              EntityId other = EntityId());
    void note(PartyChange change);
    void refuse(const PartyOrder& order, const std::optional<PartyPlayer>& by, PartyRefusal why);
    [[nodiscard]] ZoneId zone_for(const Party& party, const PartyMember& member) const;
    void expire_invitations();
    void expire_members();
    void find_next_due();
    void take_over(std::uint64_t digest);

    PartySettings settings_;
    std::vector<Party> parties_;  // ascending by id
    Invitations invitations_;
    std::vector<PartyChange> changes_;
    std::uint32_t next_party_ = 0;
    std::uint64_t refused_ = 0;
    Tick changed_ = 0;
    core::StateHash digest_;
    Tick now_ = 0;
    // These follow from the others.
    Tick next_due_ = 0;                        // nothing is over before
    std::map<EntityId, PartyId> seats_;        // of members
    std::map<ClientId, EntityId> avatars_;     // of members that are here
    std::map<ClientId, std::uint32_t> asked_;  // invitations from each player
};

}  // namespace zoned::zone
