// EventQueue: the numbered reliable events of one session, kept until the client has acknowledged
// them.
#pragma once

#include "server/mailbox/messages.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

namespace zoned::session {

/// An event's fields but for its number, serialised once for all recipients.
using EventBody = std::shared_ptr<const std::vector<std::uint8_t>>;

/// Serialises `event` without number and recipients.
[[nodiscard]] EventBody encode_event_body(const mailbox::EventOut& event);

/// A whole ServerMessage frame: event `number` with `body`.
[[nodiscard]] std::vector<std::uint8_t> event_frame(std::uint64_t number, const EventBody& body);

/// Numbers count 1, 2, 3, ... without a gap. Exactly once and in order follows from three things:
/// the stream is ordered, the queue keeps unacknowledged events, and after a reconnect it sends
/// them again from where the client says that it stopped.
class EventQueue {
  public:
    EventQueue() = default;
    /// As it was in another process: all events up to `acknowledged` have arrived, these follow.
    EventQueue(std::uint64_t acknowledged, const std::vector<EventBody>& waiting);

    /// Numbers an event and keeps it; returns the number.
    std::uint64_t push(EventBody body);

    /// Uses up a number without an event: the client will see a gap. Only for faults on purpose.
    void skip_number() { ++newest_; }

    /// All events up to `through` have arrived. False when that many were never numbered.
    bool acknowledge(std::uint64_t through);

    /// Whether all events after `number` are still here (so that a client that stopped there can
    /// come back).
    [[nodiscard]] bool can_continue_after(std::uint64_t number) const {
        return number >= acknowledged_ && number <= newest_;
    }

    struct QueuedEvent {
        std::uint64_t number = 0;
        EventBody body;
    };

    /// Not yet acknowledged, ascending.
    [[nodiscard]] const std::deque<QueuedEvent>& waiting() const { return waiting_; }

    [[nodiscard]] std::uint64_t newest() const { return newest_; }

    [[nodiscard]] std::uint64_t acknowledged() const { return acknowledged_; }

  private:
    std::deque<QueuedEvent> waiting_;
    std::uint64_t newest_ = 0;
    std::uint64_t acknowledged_ = 0;
};

}  // namespace zoned::session
