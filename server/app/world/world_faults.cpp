#include "server/app/world/world_faults.h"

#include "proto/session.pb.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <variant>

namespace zoned::app {

namespace {

void turn_clocks_wrong(double share, mailbox::Bytes& payload) {
    proto::SharedEnvironment update;
    const bool good = update.ParseFromArray(payload.data(), static_cast<int>(payload.size()));
    ZONED_ASSERT(good, "the world has just written it");
    for (proto::SharedEnvironment::Course& course : *update.mutable_courses()) {
        course.set_rate_per_s(course.rate_per_s() * (1.0 + share));
    }
    payload.resize(update.ByteSizeLong());
    update.SerializeToArray(payload.data(), static_cast<int>(payload.size()));
}

}  // namespace

zone::FaultSettings zone_faults(const config::Settings& settings, ZoneId id) {
    const config::TestingSettings& testing = settings.server.testing;
    zone::FaultSettings faults = testing.faults;
    if (testing.stall) {
        const std::string& asked = testing.stall->zone;
        if (asked.empty() ? id.value == 1 : asked == settings.zones[id.value - 1U].name) {
            faults.stall_from = testing.stall->at_tick;
            faults.stall_ticks = testing.stall->ticks;
        }
    }
    if (testing.broken) {
        const std::string& asked = testing.broken->zone;
        if (asked.empty() ? id.value == 1 : asked == settings.zones[id.value - 1U].name) {
            faults.broken = testing.broken->kind;
            faults.broken_at = testing.broken->at_tick;
        }
    }
    return faults;
}

WorldFaults::WorldFaults(const config::TestingSettings& testing)
    : leak_topic_(testing.leak_topic),
      wrong_clock_(testing.wrong_clock) {
}

void WorldFaults::alter(Tick now,
                        const std::map<ClientId, std::size_t>& zone_of,
                        std::span<mailbox::OutboxItem> out) const {
    for (mailbox::OutboxItem& item : out) {
        auto* event = std::get_if<mailbox::EventOut>(&item);
        if (event == nullptr) {
            continue;
        }
        if (event->kind == proto::CORE_EVENT_SHARED_ENVIRONMENT && wrong_clock_ != 0.0) {
            turn_clocks_wrong(wrong_clock_, event->payload);
        }
        if (event->topic.empty() || event->history) {
            continue;
        }
        for (const auto& [client, zone] : zone_of) {
            const auto at =
                std::lower_bound(event->recipients.begin(), event->recipients.end(), client);
            if (leak_topic_.hits(client.value, now) &&
                (at == event->recipients.end() || *at != client)) {
                event->recipients.insert(at, client);
            }
        }
    }
}

std::unique_ptr<const WorldFaults> make_world_faults(const config::Settings& settings) {
    const config::TestingSettings& testing = settings.server.testing;
    const bool any = testing.leak_topic != zone::ShareFault{} || testing.wrong_clock != 0.0;
    return any ? std::make_unique<const WorldFaults>(testing) : nullptr;
}

}  // namespace zoned::app
