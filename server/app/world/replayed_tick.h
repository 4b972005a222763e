// Replayed tick: one tick of a recording, simulated again.
#pragma once

#include "server/app/world/world.h"
#include "server/recording/recording_format.h"

#include <string>
#include <vector>

namespace zoned::app {

/// Gives the world what it was given then; its output goes to `out`. Empty: it was the world's next
/// tick, and its hashes are the recorded ones where it has any and `compare`; else what differs.
std::string replayed_tick(const config::Settings& settings,
                          recording::TickRecord& record,
                          bool compare,
                          World& world,
                          std::vector<mailbox::OutboxItem>& out);

/// The same where nobody wants the output.
inline std::string replayed_tick(const config::Settings& settings,
                                 recording::TickRecord& record,
                                 bool compare,
                                 World& world) {
    std::vector<mailbox::OutboxItem> out;
    return replayed_tick(settings, record, compare, world, out);
}

}  // namespace zoned::app
