// Suite `planner`, the scene of costs: prices of the planner's table fitted anew, beside the table.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Runs shipped and generated worlds with several crowds, and fits the price of each unit of each
/// pass: least squares of the relative error, no price below zero. One row a pass.
void run_planner_costs(Session& session);

}  // namespace zoned::bench
