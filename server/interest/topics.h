// Topics: publish-subscribe by topic (team, zone, world), with a history for late subscribers.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::interest {

/// The history of a topic for later subscribers.
struct HistoryRule {
    std::string name;        ///< of the topic; an end of "*" stands for any end
    std::size_t events = 0;  ///< at most
    std::size_t bytes = 0;   ///< of payloads, at most
};

/// An event of a topic as it is kept.
struct PastEvent {
    std::uint64_t number = 0;  ///< in its topic: 1, 2, 3, ...
    EventId event;
    Tick tick = 0;
    std::uint16_t kind = 0;
    std::vector<std::uint8_t> payload;
};

/// Names are "world", "zone/<id>", "team/<name>" or a studio's own, 1..64 bytes.
class Topics {
  public:
    void subscribe(ClientId client, std::string_view topic);
    void unsubscribe(ClientId client, std::string_view topic);
    void remove(ClientId client);  ///< from all topics; it is forgotten
    /// Subscribers ascending by client id; empty for an unknown topic.
    [[nodiscard]] const std::vector<ClientId>& subscribers(std::string_view topic) const;

    /// The first rule that fits a topic holds for it. Before the first event.
    void keep(std::vector<HistoryRule> rules) { rules_ = std::move(rules); }

    /// Publishes an event. All present subscribers get it, and later ones as long as it is kept.
    /// `event.number` is set here. Nothing where the topic has no history.
    void remember(std::string_view topic, PastEvent event);

    /// The events that a new subscriber has not got yet, oldest first. Each event goes out once to
    /// each client, whether the client was subscribed when it happened or comes (back) later.
    void take_missed(ClientId client, std::string_view topic, std::vector<PastEvent>& out);

    /// Subscribers and histories; the rules are those of the config.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(subscribers_, histories_);
        if constexpr (Archive::kReads) {
            find_rules();
        }
    }

  private:
    struct TopicHistory {
        const HistoryRule* rule = nullptr;  // null: nothing is kept
        std::deque<PastEvent> events;
        std::size_t bytes = 0;
        std::uint64_t newest = 0;
        std::map<ClientId, std::uint64_t>
            heard;  // number of the last message that each notified client got

        template <class Archive>
        void serialize(Archive& archive) {
            archive(events, bytes, newest, heard);
        }
    };

    [[nodiscard]] const HistoryRule* rule_of(std::string_view topic) const;
    void find_rules();

    TopicHistory& history(std::string_view topic);

    std::map<std::string, std::vector<ClientId>, std::less<>> subscribers_;
    std::vector<HistoryRule> rules_;
    std::map<std::string, TopicHistory, std::less<>> histories_;
};

}  // namespace zoned::interest
