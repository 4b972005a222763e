#include "server/zone/groups/party_book.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::zone {

namespace {

constexpr Tick kNever = std::numeric_limits<Tick>::max();

void count_down(std::map<ClientId, std::uint32_t>& counts, ClientId client) {
    const auto at = counts.find(client);
    if (at != counts.end() && --at->second == 0) {
        counts.erase(at);
    }
}

void chain(core::StateHash& hash, const std::string& text) {
    hash.add_bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace

// ---- for rules ----

PartyId PartyBook::party_of(EntityId avatar) const {
    const auto at = seats_.find(avatar);
    return at != seats_.end() ? at->second : PartyId();
}

const Party* PartyBook::find(PartyId party) const {
    const auto at = std::ranges::lower_bound(parties_, party, {}, &Party::id);
    return at != parties_.end() && at->id == party ? &*at : nullptr;
}

void PartyBook::invitations_of(EntityId guest, std::vector<PartyId>& out) const {
    for (auto it = invitations_.lower_bound({guest, ClientId()});
         it != invitations_.end() && it->first.first == guest;
         ++it) {
        if (it->second.open) {
            out.push_back(it->second.party);
        }
    }
}

bool PartyBook::tells(ZoneId zone) const {
    return std::ranges::any_of(changes_,
                               [&](const PartyChange& change) { return change.zone == zone; });
}

// ---- for the world ----

void PartyBook::begin(Tick now) {
    now_ = now;
    changes_.clear();
    if (now < next_due_) {
        return;
    }
    expire_invitations();
    expire_members();
    find_next_due();
}

void PartyBook::apply(const PartyOrder& order, const PlayerLookup& player_of) {
    switch (order.act) {
        case PartyAct::kInvite:
            return invite(order, player_of);
        case PartyAct::kAccept:
            return accept(order, player_of);
        case PartyAct::kDecline:
            return decline(order);
        case PartyAct::kLeave:
            return quit(order);
        case PartyAct::kKick:
            return kick(order, player_of);
        case PartyAct::kPromote:
            return promote(order, player_of);
        case PartyAct::kDisband:
            return disband(order, player_of);
        case PartyAct::kSetValue:
            return set_value(order);
    }
}

void PartyBook::join(const PartyPlayer& player) {
    if (player.account.empty()) {
        return;
    }
    for (Party& party : parties_) {
        const auto member = std::ranges::find_if(party.members, [&](const PartyMember& m) {
            return m.is_away() && m.player.account == player.account &&
                   m.player.name == player.name;
        });
        if (member == party.members.end()) {
            continue;
        }
        seats_.erase(member->player.avatar);
        member->player = player;
        member->away_since = 0;
        seats_[player.avatar] = party.id;
        avatars_[player.client] = player.avatar;
        tell(PartyEvent::kBack, party, *member);
        choose_leader(party);
        return;
    }
}

void PartyBook::leave(ClientId client) {
    const auto of_client = avatars_.find(client);
    if (of_client == avatars_.end()) {
        return;
    }
    const EntityId avatar = of_client->second;
    const PartyId id = party_of(avatar);
    Party& party = *found(id);
    PartyMember& member = party.members[place_of(party, avatar)];
    if (member.player.account.empty() || settings_.rejoin_ticks == 0) {
        remove_member(id, avatar, PartyEvent::kLeft, EntityId());
        end_if_over(id);
        return;
    }
    member.away_since = now_;
    member.player.client = ClientId();
    avatars_.erase(of_client);
    next_due_ = std::min(next_due_, now_ + settings_.rejoin_ticks);
    // The zone of the new leader hears of it.
    choose_leader(party);
    tell(PartyEvent::kAway, party, party.members[place_of(party, avatar)]);
}

void PartyBook::move(ClientId client, ZoneId zone) {
    const auto of_client = avatars_.find(client);
    if (of_client != avatars_.end()) {
        Party& party = *found(party_of(of_client->second));
        party.members[place_of(party, of_client->second)].player.zone = zone;
    }
}

// ---- orders ----

PartyRefusal PartyBook::not_to_invite(const PartyPlayer& by, const PartyPlayer& guest) const {
    if (by.avatar == guest.avatar) {
        return PartyRefusal::kOneself;
    }
    if (party_of(guest.avatar)) {
        return PartyRefusal::kInAParty;
    }
    const Party* party = find(party_of(by.avatar));
    if (party != nullptr && party->leader() != by.avatar) {
        return PartyRefusal::kNotLeader;
    }
    if (party != nullptr && party->members.size() >= settings_.size) {
        return PartyRefusal::kFull;
    }
    const auto earlier = invitations_.find({guest.avatar, by.client});
    if (earlier != invitations_.end()) {
        return earlier->second.open ? PartyRefusal::kInvited : PartyRefusal::kDeclined;
    }
    const auto asked = asked_.find(by.client);
    std::uint32_t to_guest = 0;
    for (auto it = invitations_.lower_bound({guest.avatar, ClientId()});
         it != invitations_.end() && it->first.first == guest.avatar;
         ++it) {
        if (it->second.open && party != nullptr && it->second.party == party->id) {
            return PartyRefusal::kInvited;  // by a leader before this one
        }
        to_guest += it->second.open ? 1 : 0;
    }
    const bool too_many = (asked != asked_.end() && asked->second >= kMostInvitationsFrom) ||
                          to_guest >= kMostInvitationsTo ||
                          (party == nullptr && parties_.size() >= settings_.most);
    return too_many ? PartyRefusal::kTooMany : PartyRefusal::kNone;
}

void PartyBook::invite(const PartyOrder& order, const PlayerLookup& player_of) {
    const std::optional<PartyPlayer> by = player_of(order.by);
    const std::optional<PartyPlayer> guest = player_of(order.other);
    if (!by || !guest) {
        return refuse(order, by, PartyRefusal::kNoPlayer);
    }
    const PartyRefusal why_not = not_to_invite(*by, *guest);
    if (why_not != PartyRefusal::kNone) {
        return refuse(order, by, why_not);
    }
    Party* const own = found(party_of(by->avatar));
    Party& party = own != nullptr ? *own : begin_party(*by);
    const Tick until = now_ + settings_.invitation_ticks;
    invitations_[{guest->avatar, by->client}] = {party.id, until, true};
    ++asked_[by->client];
    ++party.invited;
    next_due_ = std::min(next_due_, until);
    PartyChange change;
    change.event = PartyEvent::kInvited;
    change.zone = guest->zone;
    change.party = party.id;
    change.player = guest->avatar;
    change.other = by->avatar;
    change.client = guest->client;
    change.name = guest->name;
    note(std::move(change));
}

void PartyBook::accept(const PartyOrder& order, const PlayerLookup& player_of) {
    const std::optional<PartyPlayer> by = player_of(order.by);
    const auto invitation = open_invitation(order.by, order.party);
    if (!by) {
        return refuse(order, by, PartyRefusal::kNoPlayer);
    }
    if (party_of(order.by)) {
        return refuse(order, by, PartyRefusal::kInAParty);
    }
    if (invitation == invitations_.end()) {
        return refuse(order, by, PartyRefusal::kNotInvited);
    }
    Party& party = *found(order.party);
    if (party.members.size() >= settings_.size) {
        return refuse(order, by, PartyRefusal::kFull);
    }
    --party.invited;
    count_down(asked_, invitation->first.second);
    invitations_.erase(invitation);
    add_member(party, *by);
    withdraw_invitations_to(order.by);
}

void PartyBook::decline(const PartyOrder& order) {
    const auto invitation = open_invitation(order.by, order.party);
    if (invitation == invitations_.end()) {
        return refuse(order, std::nullopt, PartyRefusal::kNotInvited);
    }
    invitation->second.until = now_ + settings_.invitation_ticks;
    next_due_ = std::min(next_due_, invitation->second.until);
    close(invitation, PartyEvent::kDeclined);
    end_if_over(order.party);
}

void PartyBook::quit(const PartyOrder& order) {
    const PartyId party = party_of(order.by);
    if (!party) {
        return refuse(order, std::nullopt, PartyRefusal::kNoParty);
    }
    remove_member(party, order.by, PartyEvent::kLeft, EntityId());
    end_if_over(party);
}

Party* PartyBook::led_by(const PartyOrder& order, const std::optional<PartyPlayer>& by) {
    Party* const party = by ? found(party_of(by->avatar)) : nullptr;
    if (party == nullptr) {
        refuse(order, by, by ? PartyRefusal::kNoParty : PartyRefusal::kNoPlayer);
        return nullptr;
    }
    if (party->leader() != by->avatar) {
        refuse(order, by, PartyRefusal::kNotLeader);
        return nullptr;
    }
    return party;
}

void PartyBook::kick(const PartyOrder& order, const PlayerLookup& player_of) {
    const std::optional<PartyPlayer> by = player_of(order.by);
    const Party* const party = led_by(order, by);
    if (party == nullptr) {
        return;
    }
    if (order.by == order.other) {
        return refuse(order, by, PartyRefusal::kOneself);
    }
    if (party_of(order.other) != party->id) {
        return refuse(order, by, PartyRefusal::kNotAMember);
    }
    const PartyId id = party->id;
    remove_member(id, order.other, PartyEvent::kKicked, order.by);
    end_if_over(id);
}

void PartyBook::promote(const PartyOrder& order, const PlayerLookup& player_of) {
    const std::optional<PartyPlayer> by = player_of(order.by);
    Party* const party = led_by(order, by);
    if (party == nullptr) {
        return;
    }
    if (order.by == order.other) {
        return refuse(order, by, PartyRefusal::kOneself);
    }
    if (party_of(order.other) != party->id) {
        return refuse(order, by, PartyRefusal::kNotAMember);
    }
    const auto member =
        party->members.begin() + static_cast<std::ptrdiff_t>(place_of(*party, order.other));
    if (member->is_away()) {
        return refuse(order, by, PartyRefusal::kAway);
    }
    std::rotate(party->members.begin(), member, member + 1);
    tell(PartyEvent::kLeads, *party, party->members.front(), order.by);
}

void PartyBook::disband(const PartyOrder& order, const PlayerLookup& player_of) {
    if (const Party* const party = led_by(order, player_of(order.by))) {
        end(party->id);
    }
}

void PartyBook::set_value(const PartyOrder& order) {
    Party* const party = found(order.party);
    if (party == nullptr) {
        return refuse(order, std::nullopt, PartyRefusal::kNoParty);
    }
    const auto at = std::ranges::lower_bound(
        party->values, order.key, {}, [](const auto& value) { return value.first; });
    const bool there = at != party->values.end() && at->first == order.key;
    if (order.value.empty()) {
        if (there) {
            party->values.erase(at);
        }
    } else if (there) {
        at->second = order.value;
    } else if (party->values.size() >= kMostPartyValues) {
        return refuse(order, std::nullopt, PartyRefusal::kTooMany);
    } else {
        party->values.insert(at, {order.key, order.value});
    }
    changed_ = now_;
    digest_.add(order.party.value);
    chain(digest_, order.key);
    digest_.add_bytes(order.value);
}

// ---- what they are made of ----

Party* PartyBook::found(PartyId party) {
    return const_cast<Party*>(std::as_const(*this).find(party));
}

std::size_t PartyBook::place_of(const Party& party, EntityId avatar) const {
    const auto at = std::ranges::find_if(
        party.members, [&](const PartyMember& m) { return m.player.avatar == avatar; });
    ZONED_ASSERT(at != party.members.end(), "seats name members");
    return static_cast<std::size_t>(at - party.members.begin());
}

PartyBook::Invitations::iterator PartyBook::open_invitation(EntityId guest, PartyId party) {
    auto it = invitations_.lower_bound({guest, ClientId()});
    while (it != invitations_.end() && it->first.first == guest &&
           (it->second.party != party || !it->second.open)) {
        ++it;
    }
    return it != invitations_.end() && it->first.first == guest ? it : invitations_.end();
}

Party& PartyBook::begin_party(const PartyPlayer& founder) {
    Party& party = parties_.emplace_back();
    party.id = PartyId(++next_party_);
    add_member(party, founder);
    return party;
}

void PartyBook::add_member(Party& party, const PartyPlayer& player) {
    party.members.push_back({player, 0});
    seats_[player.avatar] = party.id;
    avatars_[player.client] = player.avatar;
    tell(PartyEvent::kJoined, party, party.members.back());
    choose_leader(party);
}

void PartyBook::remove_member(PartyId id, EntityId avatar, PartyEvent event, EntityId other) {
    Party& party = *found(id);
    const std::size_t place = place_of(party, avatar);
    // The zone to tell may be that of another member.
    tell(event, party, party.members[place], other);
    avatars_.erase(party.members[place].player.client);
    seats_.erase(avatar);
    party.members.erase(party.members.begin() + static_cast<std::ptrdiff_t>(place));
    if (party.members.empty()) {
        end(id);
    } else if (place == 0) {
        if (!choose_leader(party) && !party.members.front().is_away()) {
            tell(PartyEvent::kLeads, party, party.members.front(), avatar);
        }
    }
}

bool PartyBook::choose_leader(Party& party) {
    const auto here = std::ranges::find_if(
        party.members, [](const PartyMember& member) { return !member.is_away(); });
    if (here == party.members.end() || here == party.members.begin()) {
        return false;
    }
    const EntityId before = party.leader();
    std::rotate(party.members.begin(), here, here + 1);
    tell(PartyEvent::kLeads, party, party.members.front(), before);
    return true;
}

void PartyBook::close(Invitations::iterator invitation, PartyEvent event) {
    Party& party = *found(invitation->second.party);
    --party.invited;
    invitation->second.open = false;
    PartyChange change;
    change.event = event;
    change.zone = zone_for(party, party.members.front());
    change.party = party.id;
    change.player = invitation->first.first;
    change.other = party.leader();
    note(std::move(change));
}

void PartyBook::withdraw_invitations_to(EntityId guest) {
    std::vector<PartyId> others;
    for (auto it = invitations_.lower_bound({guest, ClientId()});
         it != invitations_.end() && it->first.first == guest;) {
        if (!it->second.open) {
            ++it;
            continue;
        }
        others.push_back(it->second.party);
        close(it, PartyEvent::kDeclined);
        count_down(asked_, it->first.second);
        it = invitations_.erase(it);
    }
    for (const PartyId party : others) {
        end_if_over(party);
    }
}

void PartyBook::end_if_over(PartyId id) {
    const Party* const party = find(id);
    if (party != nullptr && party->members.size() < 2 && party->invited == 0) {
        end(id);
    }
}

void PartyBook::end(PartyId id) {
    Party& party = *found(id);
    for (auto it = invitations_.begin(); party.invited > 0 && it != invitations_.end();) {
        if (it->second.party == id && it->second.open) {
            --party.invited;
            count_down(asked_, it->first.second);
            it = invitations_.erase(it);
        } else {
            ++it;
        }
    }
    PartyChange ended;
    ended.event = PartyEvent::kEnded;
    ended.party = id;
    ended.zone = ZoneId(1);
    if (party.members.empty()) {
        // remove_member() has told of the last one just now.
        ended.zone = changes_.back().zone;
        ended.player = changes_.back().player;
        ended.name = changes_.back().name;
    }
    for (const PartyMember& member : party.members) {
        tell(PartyEvent::kLeft, party, member);
        avatars_.erase(member.player.client);
        seats_.erase(member.player.avatar);
        ended.zone = changes_.back().zone;
        ended.player = member.player.avatar;
        ended.name = member.player.name;
    }
    note(std::move(ended));
    parties_.erase(parties_.begin() + (&party - parties_.data()));
}

// ---- what rules are told ----

ZoneId PartyBook::zone_for(const Party& party, const PartyMember& member) const {
    if (!member.is_away()) {
        return member.player.zone;
    }
    const PartyMember& leader = party.members.front();
    return leader.is_away() ? ZoneId(1) : leader.player.zone;
}

void PartyBook::tell(PartyEvent event,
                     const Party& party,
                     const PartyMember& member,
                     EntityId other) {
    PartyChange change;
    change.event = event;
    change.zone = zone_for(party, member);
    change.party = party.id;
    change.player = member.player.avatar;
    change.other = other;
    change.client = member.player.client;
    change.name = member.player.name;
    note(std::move(change));
}

void PartyBook::note(PartyChange change) {
    changed_ = now_;
    digest_.add(static_cast<std::uint8_t>(change.event));
    digest_.add(static_cast<std::uint8_t>(change.refusal));
    digest_.add(change.zone.value);
    digest_.add(change.party.value);
    digest_.add(change.player.value);
    digest_.add(change.other.value);
    digest_.add(change.client.value);
    changes_.push_back(std::move(change));
}

void PartyBook::refuse(const PartyOrder& order,
                       const std::optional<PartyPlayer>& by,
                       PartyRefusal why) {
    ++refused_;
    PartyChange change;
    change.event = PartyEvent::kRefused;
    change.refusal = why;
    change.party = order.party ? order.party : party_of(order.by);
    change.player = order.by;
    change.other = order.other;
    if (by) {
        change.zone = by->zone;
        change.client = by->client;
        change.name = by->name;
    } else {
        change.zone = order.zone;
    }
    note(std::move(change));
}

// ---- what is over ----

void PartyBook::expire_invitations() {
    std::vector<PartyId> lonely;
    for (auto it = invitations_.begin(); it != invitations_.end();) {
        if (it->second.until > now_) {
            ++it;
            continue;
        }
        if (it->second.open) {
            lonely.push_back(it->second.party);
            close(it, PartyEvent::kExpired);
        }
        count_down(asked_, it->first.second);
        it = invitations_.erase(it);
    }
    for (const PartyId party : lonely) {
        end_if_over(party);
    }
}

void PartyBook::expire_members() {
    std::vector<std::pair<PartyId, EntityId>> gone;
    for (const Party& party : parties_) {
        for (const PartyMember& member : party.members) {
            if (member.is_away() && member.away_since + settings_.rejoin_ticks <= now_) {
                gone.emplace_back(party.id, member.player.avatar);
            }
        }
    }
    for (const auto& [party, avatar] : gone) {
        if (find(party) != nullptr && party_of(avatar) == party) {
            remove_member(party, avatar, PartyEvent::kLeft, EntityId());
            end_if_over(party);
        }
    }
}

void PartyBook::find_next_due() {
    next_due_ = kNever;
    for (const auto& [key, invitation] : invitations_) {
        next_due_ = std::min(next_due_, invitation.until);
    }
    for (const Party& party : parties_) {
        for (const PartyMember& member : party.members) {
            if (member.is_away()) {
                next_due_ = std::min(next_due_, member.away_since + settings_.rejoin_ticks);
            }
        }
    }
}

}  // namespace zoned::zone
