// Rows `goals_5000` of the suite `crowd`: many far goals in the same tick.
#pragma once

#include "tests/bench/suite.h"

#include <string>

namespace zoned::bench {

inline const std::string kGoalsScene = "goals_5000";

/// 5,000 agents are given the farthest goals of a map's scenario in one tick and follow their
/// paths; the parameter is the map. Time is that of all path work in the dearest tick. The error is
/// the number of agents that stand still in the first tick or have no free path to the goal.
void run_crowd_goals(Session& session);

}  // namespace zoned::bench
