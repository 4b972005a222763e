// Replayed tick: one tick of a recording, simulated again.
#pragma once

#include "server/app/world/world.h"
#include "server/recording/recording_format.h"

#include <string>

namespace zoned::app {

/// Gives the world what it was given then. Empty: it was the world's next tick, and its hashes are
/// the recorded ones where it has any and `compare`; else what differs.
std::string replayed_tick(const config::Settings& settings,
                          recording::TickRecord& record,
                          bool compare,
                          World& world);

}  // namespace zoned::app
