#include "server/zone/groups/group_changes.h"

#include "server/zone/groups/first_state.h"
#include "server/zone/groups/instance_book.h"
#include "server/zone/groups/match_book.h"
#include "server/zone/groups/party_book.h"

namespace zoned::zone {

namespace {

/// Players of an instance that ends go back, and nothing of it stays.
void end_instance(ZoneState& state, RulesContext& context) {
    for (const ZoneClient& client : state.clients) {
        const Vec3d to = state.instances.book()->return_of(client.client);
        context.teleport(client.avatar, (to - context.origin()).cast<float>());
    }
    clear_zone(state);
}

void tell_instance(ZoneState& state, RulesContext& context, const InstanceChange& change) {
    if (change.event == InstanceEvent::kOpened) {
        place_first_state(state);
    }
    state.rules->on_instance(context, change);
    if (change.event == InstanceEvent::kEnds) {
        end_instance(state, context);
    }
}

/// The entrance of a player: teams take turns at the entrances of their instance.
std::size_t entrance_of(const Match& match, const MatchKind& kind, EntityId avatar) {
    std::size_t before = 0;
    for (const MatchPlayer& player : match.players) {
        if (player.avatar == avatar && !player.lost) {
            return before * kind.teams + player.team;
        }
        before += 1;
    }
    return 0;
}

/// Called players of this zone go to their instance; the result of a match goes to its players.
void tell_match(ZoneState& state, RulesContext& context, const MatchChange& change) {
    state.rules->on_match(context, change);
    const MatchBook& book = *state.matches.book();
    const Match* const match = book.find(change.match);
    if (change.event == MatchEvent::kCalled && match != nullptr && match->instance) {
        state.instances.enter(context,
                              change.player,
                              match->instance,
                              entrance_of(*match, book.kind_of(*match), change.player));
    }
    if (change.event == MatchEvent::kEnded && change.result_event != 0) {
        RulesEvent event;
        event.kind = change.result_event;
        event.payload = change.result;
        event.durable = true;
        context.publish(match_topic(change.match), event);
    }
}

template <class Book, class Tell>
std::uint32_t tell_changes(const Book* book, ZoneId zone, Tell&& tell) {
    std::uint32_t told = 0;
    if (book == nullptr) {
        return told;
    }
    for (const auto& change : book->changes()) {
        if (change.zone == zone) {
            tell(change);
            ++told;
        }
    }
    return told;
}

template <class Book>
void hash_book(const Book* book, ZoneState& state) {
    // A login at the end of a tick, behind its hash, is in that of the next one.
    if (book != nullptr && book->changed() != 0 && book->changed() + 1 >= state.now) {
        state.hash.add(book->digest());
    }
}

template <class Book>
bool tells(const Book* book, ZoneId zone) {
    return book != nullptr && book->tells(zone);
}

}  // namespace

bool has_group_changes(const ZoneState& state) {
    const ZoneId zone = state.settings.id;
    return tells(state.parties.book(), zone) || tells(state.matches.book(), zone) ||
           tells(state.instances.book(), zone);
}

std::uint32_t tell_group_changes(ZoneState& state, RulesContext& context) {
    const ZoneId zone = state.settings.id;
    std::uint32_t told = tell_changes(state.parties.book(), zone, [&](const PartyChange& change) {
        state.rules->on_party(context, change);
    });
    // Before its instance ends.
    told += tell_changes(state.matches.book(), zone, [&](const MatchChange& change) {
        tell_match(state, context, change);
    });
    told += tell_changes(state.instances.book(), zone, [&](const InstanceChange& change) {
        tell_instance(state, context, change);
    });
    return told;
}

void hash_groups(ZoneState& state) {
    hash_book(state.parties.book(), state);
    hash_book(state.instances.book(), state);
    hash_book(state.matches.book(), state);
}

}  // namespace zoned::zone
