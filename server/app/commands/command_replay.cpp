#include "server/app/commands/commands.h"
#include "server/app/world/agent_reload.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/recording/recorder.h"

#include <cstdio>

namespace zoned::app {

namespace {

bool settings_of(const recording::RecordingHeader& header,
                 const std::string& file,
                 config::Settings& settings) {
    std::vector<config::ConfigError> errors;
    if (config::parse_settings(header.config_text, {}, settings, errors)) {
        if (settings.digest == header.config_digest) {
            return true;
        }
        std::fprintf(stderr,
                     "zoned: %s: its config now gives a world with digest %s, when it was recorded "
                     "it was %s: a file that the config names has changed\n",
                     file.c_str(),
                     settings.digest.c_str(),
                     header.config_digest.c_str());
        return false;
    }
    std::fputs(config::format_errors(file + " (its config)", errors).c_str(), stderr);
    return false;
}

/// Says which zones differ at the first tick at which one does; true when all agree.
bool compare(const World& world, const recording::TickRecord& record) {
    bool same = true;
    for (const recording::ZoneTick& tick : record.zones) {
        const std::uint64_t hash = world.zones()[tick.zone.value - 1U]->state_hash();
        if (hash != tick.hash) {
            std::fprintf(stderr,
                         "zoned: tick %lld, zone %u: hash %016llx, recorded %016llx\n",
                         static_cast<long long>(record.tick),
                         static_cast<unsigned>(tick.zone.value),
                         static_cast<unsigned long long>(hash),
                         static_cast<unsigned long long>(tick.hash));
            same = false;
        }
    }
    return same;
}

}  // namespace

int replay(const ReplayArguments& arguments) {
    recording::RecordingReader reader;
    const auto opened = reader.open(arguments.file);
    if (!opened.ok()) {
        std::fprintf(stderr, "zoned: %s\n", opened.error().c_str());
        return kEnvironment;
    }
    config::Settings settings;
    if (!settings_of(reader.header(), arguments.file, settings)) {
        return kUsage;
    }
    World world(settings, arguments.threads);
    std::vector<mailbox::OutboxItem> out;
    std::vector<ZoneInbox> inboxes(settings.zones.size());
    recording::TickRecord record;
    for (;;) {
        const auto next = reader.next(record);
        if (!next.ok()) {
            std::fprintf(stderr, "zoned: %s\n", next.error().c_str());
            return kFailed;
        }
        if (!*next) {
            break;
        }
        if (record.zones.size() != settings.zones.size() || record.tick != world.now() + 1) {
            std::fprintf(stderr,
                         "zoned: %s skips from tick %lld to %lld or names other zones\n",
                         arguments.file.c_str(),
                         static_cast<long long>(world.now()),
                         static_cast<long long>(record.tick));
            return kFailed;
        }
        for (recording::ZoneTick& tick : record.zones) {
            if (tick.zone.value == 0 || tick.zone.value > inboxes.size()) {
                std::fprintf(stderr,
                             "zoned: %s names zone %u of %zu\n",
                             arguments.file.c_str(),
                             static_cast<unsigned>(tick.zone.value),
                             inboxes.size());
                return kFailed;
            }
            for (mailbox::InboxItem& item : tick.inbox) {
                const auto restored = restore_brains(settings, item);
                if (!restored.ok()) {
                    std::fprintf(stderr,
                                 "zoned: %s, tick %lld: %s\n",
                                 arguments.file.c_str(),
                                 static_cast<long long>(record.tick),
                                 restored.error().c_str());
                    return kFailed;
                }
            }
            inboxes[tick.zone.value - 1U] = std::move(tick.inbox);
        }
        out.clear();
        world.replay_tick(inboxes, out);
        if (!compare(world, record)) {
            return kFailed;
        }
        if (world.now() % 900 == 0) {
            std::fprintf(stderr, "replayed %lld ticks\n", static_cast<long long>(world.now()));
        }
    }
    std::printf(
        "replayed %lld ticks of %zu zones with %u threads: every hash agrees, state_hash %016llx\n",
        static_cast<long long>(world.now()),
        settings.zones.size(),
        arguments.threads,
        static_cast<unsigned long long>(world.state_hash()));
    return kGood;
}

}  // namespace zoned::app
