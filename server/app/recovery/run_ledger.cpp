#include "server/app/recovery/run_ledger.h"

#include <algorithm>

namespace zoned::app {

RunLedger::SessionEntry* RunLedger::find(ClientId client) {
    const auto it = sessions_.find(client);
    return it == sessions_.end() ? nullptr : &it->second;
}

void RunLedger::SessionEntry::acknowledge(std::uint64_t through) {
    for (; acknowledged < through && !events.empty(); ++acknowledged) {
        events.pop_front();
    }
}

void RunLedger::apply(std::span<const mailbox::InboxItem> in,
                      std::span<const mailbox::OutboxItem> out) {
    for (const mailbox::InboxItem& item : in) {
        take(item);
    }
    for (const mailbox::OutboxItem& item : out) {
        if (const auto* event = std::get_if<mailbox::EventOut>(&item)) {
            give(*event);
        } else if (const auto* joined = std::get_if<mailbox::Joined>(&item)) {
            if (SessionEntry* entry = find(joined->client)) {
                entry->joined = *joined;
            }
        } else if (const auto* kick = std::get_if<mailbox::Kick>(&item)) {
            if (sessions_.erase(kick->client) > 0) {
                kicked_.insert(kick->client);
            }
        }
    }
}

void RunLedger::take(const mailbox::InboxItem& item) {
    if (const auto* begun = std::get_if<mailbox::SessionBegun>(&item)) {
        sessions_[begun->client].begun = *begun;
        newest_ = std::max(newest_, begun->client);
    } else if (const auto* leave = std::get_if<mailbox::Leave>(&item)) {
        sessions_.erase(leave->client);
        kicked_.erase(leave->client);
    } else if (const auto* command = std::get_if<mailbox::Command>(&item)) {
        if (SessionEntry* entry = find(command->client)) {
            entry->commands = std::max(entry->commands, command->number);
        }
    } else if (const auto* progress = std::get_if<mailbox::SessionProgress>(&item)) {
        if (SessionEntry* entry = find(progress->client)) {
            entry->commands = std::max(entry->commands, progress->commands);
            entry->acknowledge(progress->events);
        }
    } else if (const auto* confirm = std::get_if<mailbox::Confirm>(&item)) {
        if (SessionEntry* entry = find(confirm->client)) {
            entry->unconfirmed.erase(confirm->event.value);
        }
    } else if (const auto* kept = std::get_if<mailbox::StoreKept>(&item)) {
        std::erase_if(requests_, [kept](const auto& of) { return of.first == kept->tick; });
    }
}

void RunLedger::give(const mailbox::EventOut& event) {
    session::EventBody body;
    for (const ClientId client : event.recipients) {
        SessionEntry* entry = find(client);
        if (entry == nullptr) {
            continue;
        }
        if (!body) {
            body = session::encode_event_body(event);
        }
        entry->events.push_back(body);
        if (event.confirm) {
            entry->unconfirmed.insert(event.event.value);
        }
    }
}

void RunLedger::ask_store(Tick tick, std::span<const mailbox::StoreRequest> requests) {
    if (!requests.empty()) {
        requests_.emplace_back(
            tick, std::vector<mailbox::StoreRequest>(requests.begin(), requests.end()));
    }
}

std::vector<session::KeptSession> RunLedger::sessions() const {
    std::vector<session::KeptSession> out;
    for (const auto& [client, entry] : sessions_) {
        session::KeptSession& kept = out.emplace_back();
        kept.begun = entry.begun;
        kept.commands = entry.commands;
        kept.events = session::EventQueue(
            entry.acknowledged,
            std::vector<session::EventBody>(entry.events.begin(), entry.events.end()));
        kept.unconfirmed = entry.unconfirmed;
        kept.joined = entry.joined;
    }
    return out;
}

std::uint64_t RunLedger::commands_of(ClientId client) const {
    const auto it = sessions_.find(client);
    return it == sessions_.end() ? 0 : it->second.commands;
}

std::vector<mailbox::StoreRequest> RunLedger::ask_again(Tick tick) {
    std::vector<mailbox::StoreRequest> all;
    for (const auto& [made, requests] : requests_) {
        all.insert(all.end(), requests.begin(), requests.end());
    }
    requests_.clear();
    ask_store(tick, all);
    return all;
}

}  // namespace zoned::app
