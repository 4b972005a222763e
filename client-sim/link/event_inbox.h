// EventInbox: turns the numbered events of a session into exactly-once, in-order delivery, and
// counts every fault in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

namespace zoned::link {

/// Numbers count 1, 2, 3, ... per session. The stream keeps order, so a gap or a duplicate is a
/// fault of the server (or a lost session), never of the network path.
class EventInbox {
  public:
    /// True when the event is new and must be delivered. `event_id` reveals an event that came
    /// twice under two numbers.
    bool accept(std::uint64_t number, std::uint64_t event_id);

    /// Newest number seen; it is acknowledged, and sent on a resume.
    [[nodiscard]] std::uint64_t newest() const { return newest_; }

    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

    [[nodiscard]] std::uint64_t duplicated() const { return duplicated_; }

    [[nodiscard]] std::uint64_t out_of_order() const { return out_of_order_; }

    /// Numbers skipped and not received since.
    [[nodiscard]] std::uint64_t lost() const { return missing_.size() + missing_uncounted_; }

    /// How many events the server has numbered for this client so far, over all sessions.
    [[nodiscard]] std::uint64_t numbered() const { return numbered_before_ + newest_; }

    /// A new session: numbers start again at 1, the counts stay.
    void restart();

  private:
    [[nodiscard]] bool known_id(std::uint64_t event_id);

    static constexpr std::size_t kRecent = 512;
    static constexpr std::size_t kMaxMissing = 4096;
    std::uint64_t newest_ = 0;
    std::uint64_t numbered_before_ = 0;
    std::uint64_t delivered_ = 0;
    std::uint64_t duplicated_ = 0;
    std::uint64_t out_of_order_ = 0;
    std::uint64_t missing_uncounted_ = 0;
    std::set<std::uint64_t> missing_;
    std::vector<std::uint64_t> recent_ids_;
    std::size_t recent_next_ = 0;
};

}  // namespace zoned::link
