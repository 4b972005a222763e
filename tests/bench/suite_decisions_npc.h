// Scene `npc_100k` of the suite `decisions`.
#pragma once

#include "tests/bench/suite.h"

#include <string>

namespace zoned::bench {

/// A tick of all agents on two threads, and the costs of a simulated agent and of an off-screen
/// one.
void run_npcs(Session& session, const std::string& scene);

}  // namespace zoned::bench
