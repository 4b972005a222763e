#include "server/zone/groups/rules_parties.h"

#include "server/zone/groups/party_book.h"

#include <algorithm>

namespace zoned::zone {

PartyId RulesParties::of(EntityId player) const {
    return book_->party_of(player);
}

const Party* RulesParties::find(PartyId party) const {
    return book_->find(party);
}

void RulesParties::invitations_of(EntityId player, std::vector<PartyId>& out) const {
    book_->invitations_of(player, out);
}

std::optional<std::span<const std::uint8_t>> RulesParties::value(PartyId party,
                                                                 std::string_view key) const {
    if (const Party* const of = find(party)) {
        for (const auto& [name, value] : of->values) {
            if (name == key) {
                return value;
            }
        }
    }
    return std::nullopt;
}

bool RulesParties::give(PartyAct act, EntityId by, EntityId other, PartyId party) {
    if (orders_->size() >= kMostPartyOrders) {
        return false;
    }
    PartyOrder& order = orders_->emplace_back();
    order.act = act;
    order.zone = zone_;
    order.by = by;
    order.other = other;
    order.party = party;
    return true;
}

bool RulesParties::invite(EntityId by, EntityId guest) {
    return give(PartyAct::kInvite, by, guest);
}

bool RulesParties::accept(EntityId guest, PartyId party) {
    return give(PartyAct::kAccept, guest, EntityId(), party);
}

bool RulesParties::decline(EntityId guest, PartyId party) {
    return give(PartyAct::kDecline, guest, EntityId(), party);
}

bool RulesParties::leave(EntityId member) {
    return give(PartyAct::kLeave, member, EntityId());
}

bool RulesParties::kick(EntityId leader, EntityId member) {
    return give(PartyAct::kKick, leader, member);
}

bool RulesParties::promote(EntityId leader, EntityId member) {
    return give(PartyAct::kPromote, leader, member);
}

bool RulesParties::disband(EntityId leader) {
    return give(PartyAct::kDisband, leader, EntityId());
}

bool RulesParties::set_value(PartyId party,
                             std::string_view key,
                             std::span<const std::uint8_t> value) {
    if (key.empty() || key.size() > kMostPartyKeyBytes || value.size() > kMostPartyValueBytes ||
        !give(PartyAct::kSetValue, EntityId(), EntityId(), party)) {
        return false;
    }
    orders_->back().key = key;
    orders_->back().value.assign(value.begin(), value.end());
    return true;
}

}  // namespace zoned::zone
