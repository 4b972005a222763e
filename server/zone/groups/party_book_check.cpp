// Checks a saved book of parties, and derives the rest from it.
#include "server/zone/groups/party_book.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

namespace zoned::zone {

void PartyBook::take_over(std::uint64_t digest) {
    digest_ = std::bit_cast<core::StateHash>(digest);
    seats_.clear();
    avatars_.clear();
    asked_.clear();
    for (const Party& party : parties_) {
        for (const PartyMember& member : party.members) {
            seats_[member.player.avatar] = party.id;
            if (!member.is_away()) {
                avatars_[member.player.client] = member.player.avatar;
            }
        }
    }
    for (const auto& [key, invitation] : invitations_) {
        ++asked_[key.second];
    }
    find_next_due();
}

std::string PartyBook::unsound() const {
    std::set<EntityId> avatars;
    std::map<PartyId, std::uint32_t> invited;
    for (const auto& [key, invitation] : invitations_) {
        invited[invitation.party] += invitation.open ? 1 : 0;
        if (invitation.open && find(invitation.party) == nullptr) {
            return "an invitation is to a party that there is not";
        }
        if (invitation.open && party_of(key.first) == invitation.party) {
            return "a member is invited";
        }
    }
    PartyId before;
    for (const Party& party : parties_) {
        if (party.id <= before || party.id.value > next_party_) {
            return "parties are in no order";
        }
        before = party.id;
        if (party.members.empty() || party.members.size() > settings_.size) {
            return "a party has no members, or too many";
        }
        if (party.invited != invited[party.id]) {
            return "a party has more or fewer invitations than it counts";
        }
        if (party.members.size() == 1 && party.invited == 0) {
            return "a party of one invites nobody";
        }
        if (party.values.size() > kMostPartyValues || !std::ranges::is_sorted(party.values)) {
            return "a party's values are too many, or in no order";
        }
        const bool any_here = std::ranges::any_of(
            party.members, [](const PartyMember& member) { return !member.is_away(); });
        if (any_here && party.members.front().is_away()) {
            return "a leader is away while others are here";
        }
        for (const PartyMember& member : party.members) {
            if (!avatars.insert(member.player.avatar).second) {
                return "a player is in two parties";
            }
            if (member.is_away() == static_cast<bool>(member.player.client)) {
                return "a member is here and away";
            }
        }
    }
    const bool asks_on = std::ranges::any_of(
        asked_, [](const auto& from) { return from.second > kMostInvitationsFrom; });
    return asks_on ? "a player asks too many" : "";
}

}  // namespace zoned::zone
