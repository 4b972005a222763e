#include "server/app/world/replayed_tick.h"

#include "server/app/world/agent_reload.h"

#include <cstdio>

namespace zoned::app {

namespace {

std::string hex_of(std::uint64_t hash) {
    char text[20];
    std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

/// Names the zones that differ.
std::string difference_of(const World& world, const recording::TickRecord& record) {
    std::string text;
    for (std::size_t i = 0; i < record.hashes.size(); ++i) {
        const std::uint64_t hash = world.zones()[i]->state_hash();
        if (hash != record.hashes[i]) {
            text += (text.empty() ? "" : "; ") + ("zone " + std::to_string(i + 1)) + " has hash " +
                    hex_of(hash) + ", recorded was " + hex_of(record.hashes[i]);
        }
    }
    return text.empty() ? text : "tick " + std::to_string(record.tick) + ": " + text;
}

}  // namespace

std::string begin_with_state(const recording::RecordingReader& reader, World& world) {
    if (!reader.state()) {
        return {};
    }
    std::string wrong = world.load(reader.state()->bytes);
    if (wrong.empty() && world.now() != reader.state()->tick) {
        wrong = "it is of tick " + std::to_string(world.now());
    }
    return wrong.empty() ? wrong
                         : "the state of tick " + std::to_string(reader.state()->tick) +
                               ", with which it begins: " + wrong;
}

std::string replayed_tick(const config::Settings& settings,
                          recording::TickRecord& record,
                          bool compare,
                          World& world,
                          std::vector<mailbox::OutboxItem>& out) {
    if (record.tick != world.now() + 1) {
        return "the recording skips from tick " + std::to_string(world.now()) + " to " +
               std::to_string(record.tick);
    }
    if (!record.hashes.empty() && record.hashes.size() != world.zones().size()) {
        return "the recording names " + std::to_string(record.hashes.size()) +
               " zones, the world has " + std::to_string(world.zones().size());
    }
    for (mailbox::InboxItem& item : record.items) {
        const auto restored = restore_brains(settings, item);
        if (!restored.ok()) {
            return "tick " + std::to_string(record.tick) + ": " + restored.error();
        }
    }
    world.tick(record.items, out);
    return compare ? difference_of(world, record) : std::string();
}

}  // namespace zoned::app
