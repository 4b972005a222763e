// The parts of the suite `replication`, one function and one file each.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Scenes `dead_reckoning` and `display`: each kind of prediction on each kind of motion, at
/// several thresholds: publications and bytes per second, the error that a client sees, and the
/// jerk of what it displays; and how that depends on convergence and on the kind of view.
void run_dead_reckoning(Session& session);

}  // namespace zoned::bench
