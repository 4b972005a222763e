#include "server/zone/groups/instance_book.h"

#include <algorithm>
#include <set>

namespace zoned::zone {

// ---- for rules ----

const Instance* InstanceBook::find(InstanceId instance) const {
    const auto at = std::ranges::lower_bound(open_, instance, {}, &Instance::id);
    return at != open_.end() && at->id == instance ? &*at : nullptr;
}

const Instance* InstanceBook::in(ZoneId zone) const {
    const auto at = std::ranges::find(open_, zone, &Instance::zone);
    return at != open_.end() ? &*at : nullptr;
}

const InstanceKind& InstanceBook::kind_of(const Instance& instance) const {
    return settings_.kinds[instance.kind];
}

bool InstanceBook::has_kind(std::string_view name) const {
    return std::ranges::find(settings_.kinds, name, &InstanceKind::name) != settings_.kinds.end();
}

Vec3d InstanceBook::return_of(ClientId client) const {
    const auto at = visits_.find(client);
    return at != visits_.end() ? at->second.from : settings_.home;
}

bool InstanceBook::is_copy(ZoneId zone) const {
    return std::ranges::any_of(
        settings_.kinds, [&](const InstanceKind& kind) { return kind.copy_in(zone) != nullptr; });
}

bool InstanceBook::tells(ZoneId zone) const {
    return std::ranges::any_of(changes_,
                               [&](const InstanceChange& change) { return change.zone == zone; });
}

// ---- for the world ----

void InstanceBook::begin(Tick now, const ZoneLookup& zone_of) {
    now_ = now;
    changes_.clear();
    std::erase_if(open_, [](const Instance& instance) { return instance.ends; });
    for (Instance& instance : open_) {
        const ZoneUse use = zone_of(instance.zone);
        if (use.clients > 0) {
            instance.empty_since = 0;
        } else if (instance.empty_since == 0) {
            instance.empty_since = now;
        } else if (now - instance.empty_since >= kind_of(instance).close_ticks) {
            end(instance);
        }
    }
}

void InstanceBook::apply(const InstanceOrder& order,
                         const ZoneLookup& zone_of,
                         const PlayerLookup& player_of) {
    if (order.act == InstanceAct::kEnter) {
        return enter(order, player_of);
    }
    if (order.act == InstanceAct::kOpen) {
        const Instance* const opened = open_one(order.kind, order.player, zone_of);
        if (opened == nullptr) {
            return refuse(order);
        }
        return note(InstanceEvent::kReady, order.zone, *opened, order.player);
    }
    const Instance* const instance = find(order.instance);
    if (instance == nullptr || instance->ends) {
        return refuse(order);
    }
    close(order.instance);
}

const Instance* InstanceBook::try_open(std::string_view kind, const ZoneLookup& zone_of) {
    return open_one(kind, EntityId(), zone_of);
}

void InstanceBook::close(InstanceId instance) {
    const auto at = std::ranges::find(open_, instance, &Instance::id);
    if (at != open_.end() && !at->ends) {
        end(*at);
    }
}

const Instance* InstanceBook::open_one(std::string_view name,
                                       EntityId asker,
                                       const ZoneLookup& zone_of) {
    const auto kind = std::ranges::find(settings_.kinds, name, &InstanceKind::name);
    if (kind == settings_.kinds.end()) {
        return nullptr;
    }
    const auto free = std::ranges::find_if(kind->copies, [&](const InstanceKind::Copy& copy) {
        return in(copy.zone) == nullptr && zone_of(copy.zone).runs &&
               zone_of(copy.zone).clients == 0;
    });
    if (free == kind->copies.end()) {
        return nullptr;
    }
    Instance& instance = open_.emplace_back();
    instance.id = InstanceId(++next_instance_);
    instance.kind = static_cast<std::uint16_t>(kind - settings_.kinds.begin());
    instance.zone = free->zone;
    instance.empty_since = now_;
    note(InstanceEvent::kOpened, instance.zone, instance, asker);
    return &instance;
}

/// The rules have sent the avatar there already.
void InstanceBook::enter(const InstanceOrder& order, const PlayerLookup& player_of) {
    const std::optional<PartyPlayer> player = player_of(order.player);
    const Instance* const instance = find(order.instance);
    if (!player || instance == nullptr) {
        return refuse(order);
    }
    Visit& visit = visits_[player->client];
    visit = {order.instance, player->avatar, order.from, false};
    changed_ = now_;
    digest_.add(player->client.value);
    for (int axis = 0; axis < 3; ++axis) {
        digest_.add(order.from[axis]);
    }
    if (player->zone == instance->zone) {
        arrive(visit, *instance);
    }
}

void InstanceBook::arrive(Visit& visit, const Instance& instance) {
    visit.arrived = true;
    note(InstanceEvent::kEntered, instance.zone, instance, visit.avatar);
}

void InstanceBook::move(ClientId client, ZoneId zone) {
    const auto at = visits_.find(client);
    if (at == visits_.end()) {
        return;
    }
    const Instance* const instance = find(at->second.instance);
    if (instance != nullptr && instance->zone == zone) {
        if (!at->second.arrived) {
            arrive(at->second, *instance);
        }
    } else if (at->second.arrived) {
        if (instance != nullptr) {
            note(InstanceEvent::kLeft, instance->zone, *instance, at->second.avatar);
        }
        visits_.erase(at);
    }
}

void InstanceBook::leave(ClientId client) {
    const auto at = visits_.find(client);
    if (at == visits_.end()) {
        return;
    }
    const Instance* const instance = find(at->second.instance);
    if (instance != nullptr && at->second.arrived) {
        note(InstanceEvent::kLeft, instance->zone, *instance, at->second.avatar);
    }
    visits_.erase(at);
}

void InstanceBook::end(Instance& instance) {
    instance.ends = true;
    note(InstanceEvent::kEnds, instance.zone, instance, EntityId());
}

void InstanceBook::refuse(const InstanceOrder& order) {
    ++refused_;
    note({InstanceEvent::kRefused, order.zone, order.instance, order.kind, order.player});
}

void InstanceBook::note(InstanceEvent event,
                        ZoneId zone,
                        const Instance& instance,
                        EntityId player) {
    note({event, zone, instance.id, kind_of(instance).name, player});
}

void InstanceBook::note(InstanceChange change) {
    changed_ = now_;
    digest_.add(static_cast<std::uint8_t>(change.event));
    digest_.add(change.zone.value);
    digest_.add(change.instance.value);
    digest_.add(change.player.value);
    changes_.push_back(std::move(change));
}

std::string InstanceBook::unsound() const {
    std::set<ZoneId> zones;
    InstanceId before;
    for (const Instance& instance : open_) {
        if (instance.id <= before || instance.id.value > next_instance_) {
            return "instances are in no order";
        }
        before = instance.id;
        if (instance.kind >= settings_.kinds.size() ||
            kind_of(instance).copy_in(instance.zone) == nullptr) {
            return "an instance is open where there is no copy of its kind";
        }
        if (!zones.insert(instance.zone).second) {
            return "two instances are open in one zone";
        }
    }
    return "";
}

}  // namespace zoned::zone
