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
    zone::FaultSettings faults;
    if (!settings.config.has_testing()) {
        return faults;
    }
    const proto::Config::Testing& testing = settings.config.testing();
    if (testing.has_corrupt_position()) {
        const auto& corrupt = testing.corrupt_position();
        faults.corrupt = {corrupt.probability(), static_cast<Tick>(corrupt.from_tick())};
        faults.corrupt_offset_m = static_cast<float>(corrupt.offset_m());
    }
    if (testing.has_hide_entity()) {
        faults.hide = {testing.hide_entity().probability(),
                       static_cast<Tick>(testing.hide_entity().from_tick())};
    }
    if (testing.has_leak_entity()) {
        faults.leak = {testing.leak_entity().probability(),
                       static_cast<Tick>(testing.leak_entity().from_tick())};
    }
    if (testing.has_leak_filtered()) {
        faults.leak_filtered = {testing.leak_filtered().probability(),
                                static_cast<Tick>(testing.leak_filtered().from_tick())};
    }
    if (testing.has_drop_decision()) {
        faults.drop_decision = {testing.drop_decision().probability(),
                                static_cast<Tick>(testing.drop_decision().from_tick())};
    }
    if (testing.has_stall_zone()) {
        const auto& stall = testing.stall_zone();
        const std::string& name = settings.zones[id.value - 1U].name;
        if (stall.has_zone() ? stall.zone() == name : id.value == 1) {
            faults.stall_from = static_cast<Tick>(stall.at_tick());
            faults.stall_ticks = static_cast<Tick>(stall.ticks());
        }
    }
    faults.silent_bound = testing.silent_bound();
    return faults;
}

WorldFaults::WorldFaults(const proto::Config::Testing& testing)
    : wrong_clock_(testing.wrong_clock()) {
    if (testing.has_leak_topic()) {
        leak_topic_ = {testing.leak_topic().probability(),
                       static_cast<Tick>(testing.leak_topic().from_tick())};
    }
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
    return settings.config.has_testing()
               ? std::make_unique<const WorldFaults>(settings.config.testing())
               : nullptr;
}

}  // namespace zoned::app
