// Groups of players across zones: their parties, their matches, and the instances that they are in.
#include "server/app/world/world.h"

#include <optional>

namespace zoned::app {

void World::make_groups(const config::Settings& settings) {
    if (settings.parties) {
        parties_ = std::make_unique<zone::PartyBook>(*settings.parties);
    }
    if (settings.instances) {
        instances_ = std::make_unique<zone::InstanceBook>(*settings.instances);
    }
    if (settings.matches) {
        matches_ = std::make_unique<zone::MatchBook>(*settings.matches);
    }
    for (zone::ZoneState* state : states_) {
        if (parties_) {
            state->parties.open(*parties_);
        }
        if (instances_) {
            state->instances.use(*instances_);
        }
        if (matches_) {
            state->matches.use(*matches_);
        }
    }
}

zone::ZoneUse World::use_of(ZoneId zone) const {
    const std::size_t index = zone.value - 1U;
    return {runs(index), states_[index]->clients.size()};
}

std::optional<zone::PartyPlayer> World::player_of(EntityId avatar) const {
    for (const zone::ZoneState* state : states_) {
        const world::Row row = state->entities.find(avatar);
        if (row == world::kNoRow || state->entities.has(row, world::kGhost)) {
            continue;
        }
        const int index = zone::find_client(*state, state->entities.client[row]);
        if (index < 0) {
            return std::nullopt;
        }
        const zone::ZoneClient& client = state->clients[static_cast<std::size_t>(index)];
        return zone::PartyPlayer{
            avatar, client.client, state->settings.id, client.account, client.name};
    }
    return std::nullopt;
}

/// The zones were told of the last tick's changes; handoffs make the first of this one.
void World::begin_groups() {
    if (parties_) {
        parties_->begin(now_);
    }
    if (instances_) {
        instances_->begin(now_, [this](ZoneId zone) { return use_of(zone); });
    }
    if (!matches_) {
        return;
    }
    for (const zone::Match& match : matches_->matches()) {
        if (match.ended != 0 && match.ended + 1 < now_) {
            for (const zone::MatchPlayer& player : match.players) {
                topics_.unsubscribe(player.client, zone::match_topic(match.id));
            }
        }
    }
    matches_->begin(now_, instances_.get());
}

void World::update_groups(std::vector<mailbox::OutboxItem>& out) {
    if (parties_) {
        update_parties(out);
    }
    if (instances_) {
        update_instances();
    }
    if (matches_) {
        update_matches(out);
    }
}

void World::move_in_groups(ClientId client, ZoneId zone) {
    if (parties_) {
        parties_->move(client, zone);
    }
    if (instances_) {
        instances_->move(client, zone);
    }
    if (matches_) {
        matches_->move(client, zone);
    }
}

void World::leave_groups(ClientId client) {
    if (parties_) {
        parties_->leave(client);
    }
    if (instances_) {
        instances_->leave(client);
    }
    if (matches_) {
        matches_->leave(client);
    }
}

void World::update_instances() {
    const zone::ZoneLookup zone_of = [this](ZoneId zone) {
        return use_of(zone);
    };
    const zone::PlayerLookup lookup = [this](EntityId avatar) {
        return player_of(avatar);
    };
    for (const auto& zone : zones_) {
        for (const zone::InstanceOrder& order : zone->output().instance_orders) {
            instances_->apply(order, zone_of, lookup);
        }
    }
    for (const auto& zone : zones_) {
        for (const ClientId client : zone->output().departed) {
            instances_->leave(client);
        }
    }
}

/// After the instances, which matches open and end.
void World::update_matches(std::vector<mailbox::OutboxItem>& out) {
    const zone::PlayerLookup lookup = [this](EntityId avatar) {
        return player_of(avatar);
    };
    for (const auto& zone : zones_) {
        for (const zone::MatchOrder& order : zone->output().match_orders) {
            matches_->apply(order, lookup, parties_.get());
        }
    }
    for (const auto& zone : zones_) {
        for (const ClientId client : zone->output().departed) {
            matches_->leave(client);
        }
    }
    matches_->form(instances_.get(), [this](ZoneId zone) { return use_of(zone); });
    for (const zone::MatchChange& change : matches_->changes()) {
        if (change.event == zone::MatchEvent::kCalled) {
            if (const auto player = player_of(change.player)) {
                subscribe(player->client, zone::match_topic(change.match), out);
            }
        }
    }
}

/// Orders in the order of the zones, then those who left.
void World::update_parties(std::vector<mailbox::OutboxItem>& out) {
    const zone::PlayerLookup lookup = [this](EntityId avatar) {
        return player_of(avatar);
    };
    for (const auto& zone : zones_) {
        for (const zone::PartyOrder& order : zone->output().party_orders) {
            parties_->apply(order, lookup);
        }
    }
    for (const auto& zone : zones_) {
        for (const ClientId client : zone->output().departed) {
            parties_->leave(client);
        }
    }
    follow_party_topics(0, out);
}

void World::seat_party_member(const mailbox::Joined& joined,
                              std::vector<mailbox::OutboxItem>& out) {
    if (const std::optional<zone::PartyPlayer> player = player_of(joined.avatar)) {
        const std::size_t from = parties_->changes().size();
        parties_->join(*player);
        follow_party_topics(from, out);
    }
}

/// Clients hear the topic of the party that they are in.
void World::follow_party_topics(std::size_t from, std::vector<mailbox::OutboxItem>& out) {
    for (const zone::PartyChange& change : parties_->changes().subspan(from)) {
        const bool comes =
            change.event == zone::PartyEvent::kJoined || change.event == zone::PartyEvent::kBack;
        const bool goes =
            change.event == zone::PartyEvent::kLeft || change.event == zone::PartyEvent::kKicked;
        if (!change.client || !(comes || goes)) {
            continue;
        }
        const std::string topic = zone::party_topic(change.party);
        if (comes) {
            subscribe(change.client, topic, out);
        } else {
            topics_.unsubscribe(change.client, topic);
        }
    }
}

}  // namespace zoned::app
