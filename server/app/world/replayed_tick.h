// Replayed tick: one tick of a recording, simulated again, and the state that it begins with.
#pragma once

#include "server/app/world/world.h"
#include "server/recording/recording_reader.h"

#include <string>
#include <vector>

namespace zoned::app {

/// Loads the state that a recording begins with, where it has one, into a world of its config that
/// has not ticked yet. Empty: done; else what is wrong with it.
std::string begin_with_state(const recording::RecordingReader& reader, World& world);

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
