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
    for (auto& [topic, past] : histories_) {
        past.heard.erase(client);
    }
}

Topics::TopicHistory& Topics::history(std::string_view topic) {
    const auto known = histories_.find(topic);
    if (known != histories_.end()) {
        return known->second;
    }
    TopicHistory past;
    past.rule = rule_of(topic);
    return histories_.emplace(std::string(topic), std::move(past)).first->second;
}

const HistoryRule* Topics::rule_of(std::string_view topic) const {
    for (const HistoryRule& rule : rules_) {
        const std::string_view name = rule.name;
        const bool open = name.ends_with('*');
        if (open ? topic.starts_with(name.substr(0, name.size() - 1)) : topic == name) {
            return &rule;
        }
    }
    return nullptr;
}

void Topics::find_rules() {
    for (auto& [topic, past] : histories_) {
        past.rule = rule_of(topic);
    }
}

void Topics::remember(std::string_view topic, PastEvent event) {
    if (rules_.empty()) {
        return;
    }
    TopicHistory& past = history(topic);
    if (past.rule == nullptr) {
        return;
    }
    event.number = ++past.newest;
    for (const ClientId client : subscribers(topic)) {
        past.heard[client] = event.number;
    }
    past.bytes += event.payload.size();
    past.events.push_back(std::move(event));
    while (past.events.size() > past.rule->events || past.bytes > past.rule->bytes) {
        past.bytes -= past.events.front().payload.size();
        past.events.pop_front();
    }
}

void Topics::take_missed(ClientId client, std::string_view topic, std::vector<PastEvent>& out) {
    if (rules_.empty()) {
        return;
    }
    TopicHistory& past = history(topic);
    if (past.rule == nullptr) {
        return;
    }
    std::uint64_t& heard = past.heard[client];
    for (const PastEvent& event : past.events) {
        if (event.number > heard) {
            out.push_back(event);
        }
    }
    heard = past.newest;
}

const std::vector<ClientId>& Topics::subscribers(std::string_view topic) const {
    static const std::vector<ClientId> kNobody;
    const auto it = subscribers_.find(topic);
    return it == subscribers_.end() ? kNobody : it->second;
}

}  // namespace zoned::interest
