#include "server/replication/client_state.h"

namespace zoned::replication {

/// For a level that the client has left it keeps the last publication sent.
void ClientState::follow_on(const Subscription& left, const StreamTable& streams) {
    const std::uint32_t version = held_version(left);
    const Past* past = streams.past(left.stream, version);
    if (past != nullptr) {
        follow({left.entity, *past, 0.0F, 0.0F});
    } else if (version != 0) {
        std::erase_if(followed_, [&](const Followed& f) { return f.entity == left.entity; });
    }
}

void ClientState::follow(const Followed& what) {
    const auto it = lower_bound_entity(followed_, what.entity);
    if (it != followed_.end() && it->entity == what.entity) {
        *it = what;
    } else {
        followed_.insert(it, what);
    }
}

const Followed* ClientState::followed(EntityId entity) const {
    const auto it = lower_bound_entity(followed_, entity);
    return it != followed_.end() && it->entity == entity ? &*it : nullptr;
}

void ClientState::forget_followed() {
    std::erase_if(followed_, [this](const Followed& f) {
        const Subscription* s = subscription(f.entity);
        return s == nullptr || s->delivered_version != 0;
    });
}

Tick ClientState::switch_tick(EntityId entity) const {
    const auto it = lower_bound_entity(subscriptions, entity);
    return it != subscriptions.end() && it->entity == entity ? it->switched_tick : 0;
}

}  // namespace zoned::replication
