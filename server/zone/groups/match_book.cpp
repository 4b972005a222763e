#include "server/zone/groups/match_book.h"

#include "server/zone/groups/team_choice.h"

#include <algorithm>
#include <optional>
#include <set>

namespace zoned::zone {

namespace {

/// Where no instance was free, another look comes after so many ticks.
constexpr Tick kRetryTicks = 30;

bool plays(const MatchPlayer& player) {
    return !player.lost;
}

}  // namespace

// ---- for rules ----

const Match* MatchBook::find(MatchId match) const {
    const auto at = std::ranges::lower_bound(matches_, match, {}, &Match::id);
    return at != matches_.end() && at->id == match && at->ended == 0 ? &*at : nullptr;
}

MatchId MatchBook::match_of(EntityId avatar) const {
    const auto at = playing_.find(avatar);
    return at != playing_.end() ? at->second : MatchId();
}

bool MatchBook::has_kind(std::string_view name) const {
    return std::ranges::find(settings_.kinds, name, &MatchKind::name) != settings_.kinds.end();
}

const MatchKind& MatchBook::kind_of(const Match& match) const {
    return settings_.kinds[match.kind];
}

bool MatchBook::tells(ZoneId zone) const {
    return std::ranges::any_of(changes_,
                               [&](const MatchChange& change) { return change.zone == zone; });
}

// ---- for the world ----

void MatchBook::begin(Tick now, InstanceBook* instances) {
    now_ = now;
    changes_.clear();
    // Its result is on its way in the tick in which its end is told.
    std::erase_if(matches_,
                  [&](const Match& match) { return match.ended != 0 && match.ended + 1 < now; });
    for (Match& match : matches_) {
        if (match.ended == 0) {
            follow(match, instances);
        }
    }
}

void MatchBook::apply(const MatchOrder& order,
                      const PlayerLookup& player_of,
                      const PartyBook* parties) {
    switch (order.act) {
        case MatchAct::kQueue:
            return queue(order, player_of, parties);
        case MatchAct::kUnqueue: {
            const auto waiting = waiting_.find(order.player);
            if (waiting == waiting_.end()) {
                return refuse(order, order.zone, MatchRefusal::kNotWaiting);
            }
            const auto ticket = std::ranges::find(tickets_, waiting->second, &Ticket::number);
            return remove_ticket(static_cast<std::size_t>(ticket - tickets_.begin()), true);
        }
        case MatchAct::kEnd:
            return end_by_rules(order);
    }
}

void MatchBook::end_by_rules(const MatchOrder& order) {
    const Match* const match = find(order.match);
    if (match == nullptr) {
        return refuse(order, order.zone, MatchRefusal::kNoMatch);
    }
    end(const_cast<Match&>(*match), order.event, order.result);
}

MatchRefusal MatchBook::not_to_wait(const Ticket& ticket, const MatchKind& kind) const {
    if (ticket.players.size() > kind.size) {
        return MatchRefusal::kTooLarge;
    }
    for (const MatchPlayer& player : ticket.players) {
        if (waiting_.contains(player.avatar)) {
            return MatchRefusal::kWaiting;
        }
        if (playing_.contains(player.avatar)) {
            return MatchRefusal::kPlaying;
        }
    }
    return tickets_.size() < kMostTickets ? MatchRefusal::kNone : MatchRefusal::kTooMany;
}

void MatchBook::queue(const MatchOrder& order,
                      const PlayerLookup& player_of,
                      const PartyBook* parties) {
    const std::optional<PartyPlayer> by = player_of(order.player);
    if (!by) {
        return refuse(order, order.zone, MatchRefusal::kNoPlayer);
    }
    const auto kind = std::ranges::find(settings_.kinds, order.kind, &MatchKind::name);
    if (kind == settings_.kinds.end()) {
        return refuse(order, by->zone, MatchRefusal::kNoKind);
    }
    Ticket ticket;
    const Party* const party =
        parties != nullptr ? parties->find(parties->party_of(order.player)) : nullptr;
    if (party == nullptr) {
        ticket.players.push_back({by->avatar, by->client, by->zone});
    } else if (party->leader() != order.player) {
        return refuse(order, by->zone, MatchRefusal::kNotLeader);
    } else {
        for (const PartyMember& member : party->members) {
            if (!member.is_away()) {
                const PartyPlayer& p = member.player;
                ticket.players.push_back({p.avatar, p.client, p.zone});
            }
        }
    }
    const MatchRefusal why_not = not_to_wait(ticket, *kind);
    if (why_not != MatchRefusal::kNone) {
        return refuse(order, by->zone, why_not);
    }
    ticket.number = ++next_ticket_;
    ticket.kind = static_cast<std::uint16_t>(kind - settings_.kinds.begin());
    ticket.since = now_;
    for (const MatchPlayer& player : ticket.players) {
        waiting_[player.avatar] = ticket.number;
        avatars_[player.client] = player.avatar;
    }
    tell_waiting(MatchEvent::kQueued, ticket);
    tickets_.push_back(std::move(ticket));
    look_at_ = now_;
}

void MatchBook::remove_ticket(std::size_t place, bool tells) {
    const Ticket& ticket = tickets_[place];
    if (tells) {
        tell_waiting(MatchEvent::kUnqueued, ticket);
    }
    for (const MatchPlayer& player : ticket.players) {
        waiting_.erase(player.avatar);
        avatars_.erase(player.client);
    }
    tickets_.erase(tickets_.begin() + static_cast<std::ptrdiff_t>(place));
}

void MatchBook::move(ClientId client, ZoneId zone) {
    const auto avatar = avatars_.find(client);
    if (avatar == avatars_.end()) {
        return;
    }
    const auto follow_in = [&](std::vector<MatchPlayer>& players) {
        for (MatchPlayer& player : players) {
            if (player.client == client && !player.lost) {
                player.zone = zone;
            }
        }
    };
    if (const auto waiting = waiting_.find(avatar->second); waiting != waiting_.end()) {
        follow_in(std::ranges::find(tickets_, waiting->second, &Ticket::number)->players);
    } else {
        const MatchId match = playing_.at(avatar->second);
        follow_in(std::ranges::find(matches_, match, &Match::id)->players);
    }
}

void MatchBook::leave(ClientId client) {
    const auto of_client = avatars_.find(client);
    if (of_client == avatars_.end()) {
        return;
    }
    const EntityId avatar = of_client->second;
    if (const auto waiting = waiting_.find(avatar); waiting != waiting_.end()) {
        const auto ticket = std::ranges::find(tickets_, waiting->second, &Ticket::number);
        remove_ticket(static_cast<std::size_t>(ticket - tickets_.begin()), true);
        look_at_ = now_;
        return;
    }
    Match& match = *std::ranges::find(matches_, playing_.at(avatar), &Match::id);
    for (MatchPlayer& player : match.players) {
        if (player.avatar == avatar && !player.lost) {
            lose(match, player);
        }
    }
}

// ---- those who wait ----

void MatchBook::form(InstanceBook* instances, const ZoneLookup& zone_of) {
    for (Match& match : matches_) {
        if (match.ended == 0 && kind_of(match).backfill && !match.over && !tickets_.empty()) {
            fill_places(match);
        }
        if (match.ended == now_ && match.instance && instances != nullptr) {
            instances->close(match.instance);
        }
    }
    if (look_at_ == 0 || now_ < look_at_) {
        return;
    }
    look_at_ = 0;
    for (std::uint16_t kind = 0; kind < settings_.kinds.size(); ++kind) {
        form_kind(kind, instances, zone_of);
    }
}

void MatchBook::form_kind(std::uint16_t kind, InstanceBook* instances, const ZoneLookup& zone_of) {
    std::vector<std::size_t> of_kind;
    std::size_t first = 0;
    do {
        of_kind.clear();
        for (std::size_t i = 0; i < tickets_.size(); ++i) {
            if (tickets_[i].kind == kind) {
                of_kind.push_back(i);
            }
        }
        // Each ticket in turn is the one that must play, so that nobody holds up all others.
        while (first < of_kind.size() && !form_from(of_kind, first, instances, zone_of)) {
            ++first;
        }
    } while (first < of_kind.size());
}

bool MatchBook::form_from(const std::vector<std::size_t>& of_kind,
                          std::size_t first,
                          InstanceBook* instances,
                          const ZoneLookup& zone_of) {
    const Ticket& longest = tickets_[of_kind[first]];
    const MatchKind& kind = settings_.kinds[longest.kind];
    const std::vector<std::size_t> places(of_kind.begin() + static_cast<std::ptrdiff_t>(first),
                                          of_kind.end());
    std::vector<std::uint32_t> sizes;
    for (const std::size_t place : places) {
        sizes.push_back(static_cast<std::uint32_t>(tickets_[place].players.size()));
    }
    const Tick relaxes = longest.since + kind.wait_ticks;
    auto teams = choose_teams(sizes, {kind.teams, kind.size, kind.size});
    if (!teams && kind.least < kind.size) {
        if (now_ >= relaxes) {
            teams = choose_teams(sizes, {kind.teams, kind.size, kind.least});
        } else {
            look_at_ = look_at_ == 0 ? relaxes : std::min(look_at_, relaxes);
        }
    }
    if (!teams) {
        return false;
    }
    InstanceId instance;
    ZoneId zone = longest.players.front().zone;
    if (!kind.instance.empty()) {
        const Instance* const opened =
            instances != nullptr ? instances->try_open(kind.instance, zone_of) : nullptr;
        if (opened == nullptr) {
            look_at_ = look_at_ == 0 ? now_ + kRetryTicks : std::min(look_at_, now_ + kRetryTicks);
            return false;
        }
        instance = opened->id;
        zone = opened->zone;
    }
    begin_match(longest.kind, places, *teams, instance, zone);
    return true;
}

void MatchBook::begin_match(std::uint16_t kind,
                            const std::vector<std::size_t>& places,
                            const std::vector<std::uint16_t>& teams,
                            InstanceId instance,
                            ZoneId zone) {
    Match& match = matches_.emplace_back();
    match.id = MatchId(++next_match_);
    match.kind = kind;
    match.instance = instance;
    match.zone = zone;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (teams[i] != kNoTeam) {
            call(match, tickets_[places[i]], teams[i]);
        }
    }
    for (std::size_t i = places.size(); i-- > 0;) {
        if (teams[i] != kNoTeam) {
            tickets_.erase(tickets_.begin() + static_cast<std::ptrdiff_t>(places[i]));
        }
    }
}

void MatchBook::call(Match& match, const Ticket& ticket, std::uint16_t team) {
    match.called = now_;
    for (MatchPlayer player : ticket.players) {
        player.team = team;
        waiting_.erase(player.avatar);
        playing_[player.avatar] = match.id;
        match.players.push_back(player);
        tell(MatchEvent::kCalled, match, &match.players.back());
    }
}

void MatchBook::fill_places(Match& match) {
    const MatchKind& kind = kind_of(match);
    std::vector<std::uint32_t> players(kind.teams, 0);
    for (const MatchPlayer& player : match.players) {
        players[player.team] += plays(player) ? 1 : 0;
    }
    for (std::size_t i = 0; i < tickets_.size();) {
        const auto emptiest = std::ranges::min_element(players);
        const auto size = static_cast<std::uint32_t>(tickets_[i].players.size());
        if (tickets_[i].kind != match.kind || *emptiest + size > kind.size) {
            ++i;
            continue;
        }
        *emptiest += size;
        call(match, tickets_[i], static_cast<std::uint16_t>(emptiest - players.begin()));
        tickets_.erase(tickets_.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

// ---- those who play ----

void MatchBook::follow(Match& match, InstanceBook* instances) {
    if (match.instance) {
        const Instance* const instance =
            instances != nullptr ? instances->find(match.instance) : nullptr;
        if (instance == nullptr || instance->ends) {
            return end(match, 0, {});
        }
    }
    bool waits = false;
    bool any = false;
    for (MatchPlayer& player : match.players) {
        if (player.lost) {
            continue;
        }
        const bool there = !match.instance || player.zone == match.zone;
        if (there && !player.here) {
            come(match, player);
        } else if (!there && (player.here || now_ >= match.called + settings_.call_ticks)) {
            lose(match, player);
            continue;
        }
        waits = waits || !player.here;
        any = true;
    }
    if (!any) {
        return end(match, 0, {});
    }
    if (match.began == 0 && !waits) {
        match.began = now_;
        tell(MatchEvent::kBegan, match, nullptr);
    }
    const Tick limit = kind_of(match).limit_ticks;
    if (match.began == 0 || limit == 0 || now_ < match.began + limit) {
        return;
    }
    if (!match.over) {
        match.over = true;
        tell(MatchEvent::kTimeUp, match, nullptr);
    } else if (now_ >= match.began + limit + settings_.grace_ticks) {
        end(match, 0, {});
    }
}

void MatchBook::come(Match& match, MatchPlayer& player) {
    player.here = true;
    tell(MatchEvent::kCame, match, &player);
}

void MatchBook::lose(Match& match, MatchPlayer& player) {
    player.lost = true;
    playing_.erase(player.avatar);
    avatars_.erase(player.client);
    tell(MatchEvent::kLost, match, &player);
}

void MatchBook::end(Match& match, std::uint16_t event, std::vector<std::uint8_t> result) {
    match.ended = now_;
    for (const MatchPlayer& player : match.players) {
        if (plays(player)) {
            playing_.erase(player.avatar);
            avatars_.erase(player.client);
        }
    }
    MatchChange change;
    change.event = MatchEvent::kEnded;
    change.zone = match.zone;
    change.match = match.id;
    change.kind = kind_of(match).name;
    change.result_event = event;
    change.result = std::move(result);
    note(std::move(change));
    look_at_ = now_;
}

// ---- what rules are told ----

void MatchBook::tell(MatchEvent event, const Match& match, const MatchPlayer* player) {
    MatchChange change;
    change.event = event;
    change.zone = event == MatchEvent::kCalled ? player->zone : match.zone;
    change.match = match.id;
    change.kind = kind_of(match).name;
    if (player != nullptr) {
        change.player = player->avatar;
        change.team = player->team;
    }
    note(std::move(change));
}

void MatchBook::tell_waiting(MatchEvent event, const Ticket& ticket) {
    for (const MatchPlayer& player : ticket.players) {
        MatchChange change;
        change.event = event;
        change.zone = player.zone;
        change.kind = settings_.kinds[ticket.kind].name;
        change.player = player.avatar;
        note(std::move(change));
    }
}

void MatchBook::refuse(const MatchOrder& order, ZoneId zone, MatchRefusal why) {
    ++refused_;
    MatchChange change;
    change.refusal = why;
    change.zone = zone;
    change.match = order.match;
    change.kind = order.kind;
    change.player = order.player;
    note(std::move(change));
}

void MatchBook::note(MatchChange change) {
    changed_ = now_;
    digest_.add(static_cast<std::uint8_t>(change.event));
    digest_.add(static_cast<std::uint8_t>(change.refusal));
    digest_.add(change.zone.value);
    digest_.add(change.match.value);
    digest_.add(change.player.value);
    digest_.add(change.team);
    digest_.add(change.result_event);
    digest_.add_bytes(change.result);
    changes_.push_back(std::move(change));
}

// ---- saved books ----

void MatchBook::take_over(std::uint64_t digest) {
    digest_ = std::bit_cast<core::StateHash>(digest);
    waiting_.clear();
    playing_.clear();
    avatars_.clear();
    for (const Ticket& ticket : tickets_) {
        for (const MatchPlayer& player : ticket.players) {
            waiting_[player.avatar] = ticket.number;
            avatars_[player.client] = player.avatar;
        }
    }
    for (const Match& match : matches_) {
        for (const MatchPlayer& player : match.players) {
            if (match.ended == 0 && plays(player)) {
                playing_[player.avatar] = match.id;
                avatars_[player.client] = player.avatar;
            }
        }
    }
}

std::string MatchBook::unsound() const {
    std::set<EntityId> busy;
    std::uint64_t number = 0;
    for (const Ticket& ticket : tickets_) {
        if (ticket.number <= number || ticket.number > next_ticket_) {
            return "tickets are in no order";
        }
        number = ticket.number;
        if (ticket.kind >= settings_.kinds.size() || ticket.players.empty() ||
            ticket.players.size() > settings_.kinds[ticket.kind].size) {
            return "a ticket is for no match that there is";
        }
        for (const MatchPlayer& player : ticket.players) {
            if (!busy.insert(player.avatar).second) {
                return "a player waits twice";
            }
        }
    }
    MatchId before;
    for (const Match& match : matches_) {
        if (match.id <= before || match.id.value > next_match_) {
            return "matches are in no order";
        }
        before = match.id;
        if (match.kind >= settings_.kinds.size()) {
            return "a match is of a kind that there is not";
        }
        std::vector<std::uint32_t> teams(kind_of(match).teams, 0);
        for (const MatchPlayer& player : match.players) {
            if (player.team >= teams.size()) {
                return "a player is in a team that there is not";
            }
            if (match.ended != 0 || !plays(player)) {
                continue;
            }
            if (!busy.insert(player.avatar).second) {
                return "a player is in two matches, or plays and waits";
            }
            if (++teams[player.team] > kind_of(match).size) {
                return "a team is too large";
            }
        }
    }
    return "";
}

}  // namespace zoned::zone
