// RulesParties: the parties of the world as rules see them, and what rules ask of them.
#pragma once

#include "server/zone/groups/party.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::zone {

class PartyBook;

/// Players are named by their avatars, in whatever zone they are. Orders take effect behind this
/// tick, in all zones at once; Rules::on_party tells what has become of them. False: refused at
/// once, because a text is too long or this zone has given kMostPartyOrders in this tick.
class RulesParties {
  public:
    RulesParties(ZoneId zone, std::vector<PartyOrder>& orders) : zone_(zone), orders_(&orders) {}

    /// From now on rules see this book, which must outlive them.
    void open(const PartyBook& book) { book_ = &book; }

    [[nodiscard]] const PartyBook* book() const { return book_; }

    /// None: the player is in no party.
    [[nodiscard]] PartyId of(EntityId player) const;
    /// Null: there is no such party, or it has ended. Good during the call.
    [[nodiscard]] const Party* find(PartyId party) const;
    /// Appends the parties that invite a player.
    void invitations_of(EntityId player, std::vector<PartyId>& out) const;
    /// Shared by the members; none: nothing is kept there.
    [[nodiscard]] std::optional<std::span<const std::uint8_t>> value(PartyId party,
                                                                     std::string_view key) const;

    /// A player in no party founds one. In a party only the leader invites.
    bool invite(EntityId by, EntityId guest);
    bool accept(EntityId guest, PartyId party);
    bool decline(EntityId guest, PartyId party);
    bool leave(EntityId member);
    bool kick(EntityId leader, EntityId member);
    bool promote(EntityId leader, EntityId member);
    bool disband(EntityId leader);
    /// An empty value takes the key away. At most kMostPartyValues.
    bool set_value(PartyId party, std::string_view key, std::span<const std::uint8_t> value);

  private:
    bool give(PartyAct act, EntityId by, EntityId other, PartyId party = PartyId());

    ZoneId zone_;
    std::vector<PartyOrder>* orders_;
    const PartyBook* book_ = nullptr;
};

}  // namespace zoned::zone
