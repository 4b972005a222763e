// Scene `npc_100k` of suite `decisions`.
#pragma once

#include "tests/bench/suite.h"

#include <string>

namespace zoned::bench {

/// A tick of all agents on two threads, and what a simulated agent and one that nobody sees cost.
void run_npcs(Session& session, const std::string& scene);

}  // namespace zoned::bench
