// Topics with a history: a late subscriber hears earlier events, in order, each once.
#include "server/app/world/world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <optional>

namespace zoned::app {
namespace {

/// A payload that tells events apart.
zone::RulesEvent numbered_event(std::uint8_t number, std::size_t bytes = 1) {
    zone::RulesEvent event;
    event.payload.assign(bytes, number);
    return event;
}

struct Received {
    std::uint8_t number = 0;
    bool history = false;

    bool operator==(const Received&) const = default;
};

/// Two zones side by side; a client joins where its number puts it.
class WithHistory {
  public:
    WithHistory(std::uint32_t events, std::uint32_t bytes) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        config::Settings s = scenario::small_world(2, 1, 120.0);
        s.server.topics = {{"news/*", events, bytes}};
        s.spawn_points = {{Vec3d(-30.0, 0.9, 0.0), "", ""}, {Vec3d(30.0, 0.9, 0.0), "", ""}};
        world_.emplace(s, 1);
    }

    void join(std::uint32_t client) {
        mailbox::Join join;
        join.client = ClientId(client);
        join.name = "player";
        tick({join});
    }

    /// In the next tick the first zone's rules do this.
    void tick_with(const std::function<void(zone::RulesContext&)>& call) {
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            if (context.zone() == ZoneId(1)) {
                call(context);
            }
        };
        tick({});
        plain_log()->each_tick = nullptr;
    }

    void publish(std::uint8_t number, const char* topic = "news/a", std::size_t bytes = 1) {
        tick_with([&](zone::RulesContext& context) {
            context.publish(topic, numbered_event(number, bytes));
        });
    }

    void subscribe(std::uint32_t client, bool on = true) {
        tick_with([&](zone::RulesContext& context) {
            on ? context.subscribe(ClientId(client), "news/a")
               : context.unsubscribe(ClientId(client), "news/a");
        });
    }

    std::vector<Received> received(std::uint32_t client) const {
        const auto it = received_.find(ClientId(client));
        return it == received_.end() ? std::vector<Received>() : it->second;
    }

  private:
    void tick(const std::vector<mailbox::InboxItem>& items) {
        std::vector<mailbox::OutboxItem> out;
        world_->tick(items, out);
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind >= zone::kFirstRulesEvent) {
                for (const ClientId client : event->recipients) {
                    received_[client].push_back({event->payload[0], event->history});
                }
            }
        }
    }

    std::optional<World> world_;
    std::map<ClientId, std::vector<Received>> received_;
};

TEST(TopicHistory, IsToldToWhoComesLateInOrderAndOnceWhereverItsZone) {
    WithHistory w(10, 1000);
    // A rules pass runs where players are; the client that asks for the others is in the first
    // zone.
    for (std::uint32_t client = 1; client <= 4; ++client) {
        w.join(client);
    }
    for (std::uint8_t n = 1; n <= 3; ++n) {
        w.publish(n);
    }
    w.publish(99, "news/other");
    w.publish(98, "gossip");
    for (std::uint32_t client = 1; client <= 4; ++client) {
        w.subscribe(client);
        w.subscribe(client);  // a second time sends nothing
    }
    w.publish(4);
    const std::vector<Received> all = {{1, true}, {2, true}, {3, true}, {4, false}};
    for (std::uint32_t client = 1; client <= 4; ++client) {
        EXPECT_EQ(w.received(client), all) << "client " << client;
    }
}

TEST(TopicHistory, TellsWhoComesBackOnlyWhatItMissed) {
    WithHistory w(10, 1000);
    w.join(1);
    w.join(2);
    w.subscribe(1);
    w.publish(1);
    w.subscribe(1, false);
    w.publish(2);
    w.publish(3);
    w.subscribe(1);
    w.publish(4);
    EXPECT_EQ(w.received(1), (std::vector<Received>{{1, false}, {2, true}, {3, true}, {4, false}}));
}

TEST(TopicHistory, KeepsNoMoreThanItsEventsAndItsBytes) {
    WithHistory few(2, 1000);
    WithHistory* w = &few;
    w->join(1);
    w->join(2);
    for (std::uint8_t n = 1; n <= 5; ++n) {
        w->publish(n);
    }
    w->subscribe(1);
    EXPECT_EQ(w->received(1), (std::vector<Received>{{4, true}, {5, true}}));

    WithHistory small(100, 250);
    w = &small;
    w->join(1);
    w->join(2);
    for (std::uint8_t n = 1; n <= 5; ++n) {
        w->publish(n, "news/a", 100);
    }
    w->subscribe(1);
    EXPECT_EQ(w->received(1), (std::vector<Received>{{4, true}, {5, true}}));
}

}  // namespace
}  // namespace zoned::app
