#include "server/interest/topics.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::interest {

namespace {

constexpr std::size_t kMaxNameBytes = 64;

}  // namespace

void Topics::subscribe(ClientId client, std::string_view topic) {
    ZONED_ASSERT(!topic.empty() && topic.size() <= kMaxNameBytes, "a topic has 1..64 bytes");
    auto it = subscribers_.find(topic);
    if (it == subscribers_.end()) {
        it = subscribers_.emplace(std::string(topic), std::vector<ClientId>()).first;
    }
    std::vector<ClientId>& clients = it->second;
    const auto at = std::lower_bound(clients.begin(), clients.end(), client);
    if (at == clients.end() || *at != client) {
        clients.insert(at, client);
    }
}

void Topics::unsubscribe(ClientId client, std::string_view topic) {
    const auto it = subscribers_.find(topic);
    if (it == subscribers_.end()) {
        return;
    }
    std::vector<ClientId>& clients = it->second;
    const auto at = std::lower_bound(clients.begin(), clients.end(), client);
    if (at != clients.end() && *at == client) {
        clients.erase(at);
    }
    if (clients.empty()) {
        subscribers_.erase(it);
    }
}

void Topics::remove(ClientId client) {
    for (auto it = subscribers_.begin(); it != subscribers_.end();) {
        std::vector<ClientId>& clients = it->second;
        const auto at = std::lower_bound(clients.begin(), clients.end(), client);
        if (at != clients.end() && *at == client) {
            clients.erase(at);
        }
        it = clients.empty() ? subscribers_.erase(it) : std::next(it);
    }
}

const std::vector<ClientId>& Topics::subscribers(std::string_view topic) const {
    static const std::vector<ClientId> kNobody;
    const auto it = subscribers_.find(topic);
    return it == subscribers_.end() ? kNobody : it->second;
}

}  // namespace zoned::interest
