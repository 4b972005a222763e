// RunLedger: what a run knows beside its world: the sessions, and what the store owes the rules. It
// follows from the same inputs, tick by tick.
#pragma once

#include "server/mailbox/messages.h"
#include "server/session/host/session_host.h"

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

namespace zoned::mailbox {

/// How a snapshot holds it.
template <class Archive>
void serialize(Archive& archive, StoreRequest& r) {
    archive(r.act, r.number, r.zone, r.target, r.key, r.value, r.kind);
    archive(r.position[0], r.position[1], r.position[2]);
}

}  // namespace zoned::mailbox

namespace zoned::app {

class RunLedger {
  public:
    /// After a tick: what went into it, and what came out. Events get their numbers here in the
    /// order in which the session host will give them.
    void apply(std::span<const mailbox::InboxItem> in, std::span<const mailbox::OutboxItem> out);
    /// The requests that the zones made in that tick.
    void ask_store(Tick tick, std::span<const mailbox::StoreRequest> requests);

    /// Ascending by client.
    [[nodiscard]] std::vector<session::KeptSession> sessions() const;

    /// Clients whom the rules threw out, and of whose leaving the world has not heard.
    [[nodiscard]] const std::set<ClientId>& kicked() const { return kicked_; }

    [[nodiscard]] ClientId newest_client() const { return newest_; }

    /// The number of the newest command that a session has used up; 0: none, or no session.
    [[nodiscard]] std::uint64_t commands_of(ClientId client) const;

    /// Requests of which nobody knows whether the store carried them out, in their order. From here
    /// on they count as made in that tick.
    std::vector<mailbox::StoreRequest> ask_again(Tick tick);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(newest_, sessions_, kicked_, requests_);
    }

  private:
    struct SessionEntry {
        mailbox::SessionBegun begun;
        std::uint64_t commands = 0;
        std::uint64_t acknowledged = 0;         ///< number of the newest event that has arrived
        std::deque<session::EventBody> events;  ///< all after it
        std::set<std::uint64_t> unconfirmed;
        std::optional<mailbox::Joined> joined;

        void acknowledge(std::uint64_t through);

        template <class Archive>
        void serialize(Archive& archive);
    };

    void take(const mailbox::InboxItem& item);
    void give(const mailbox::EventOut& event);
    [[nodiscard]] SessionEntry* find(ClientId client);

    ClientId newest_;
    std::map<ClientId, SessionEntry> sessions_;
    std::set<ClientId> kicked_;
    std::deque<std::pair<Tick, std::vector<mailbox::StoreRequest>>> requests_;  // ascending
};

template <class Archive>
void RunLedger::SessionEntry::serialize(Archive& archive) {
    std::vector<std::vector<std::uint8_t>> bodies;
    if constexpr (!Archive::kReads) {
        for (const session::EventBody& body : events) {
            bodies.push_back(*body);
        }
    }
    archive(begun, commands, acknowledged, bodies, unconfirmed, joined);
    if constexpr (Archive::kReads) {
        for (std::vector<std::uint8_t>& body : bodies) {
            events.push_back(std::make_shared<const std::vector<std::uint8_t>>(std::move(body)));
        }
    }
}

}  // namespace zoned::app
