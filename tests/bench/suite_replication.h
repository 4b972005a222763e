// The parts of the suite `replication`, one function and one file each.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Scenes `dead_reckoning` and `display`: each kind of prediction on each kind of motion, at
/// several thresholds: publications and bytes per second, the error that a client sees, and the
/// jerk of what it displays; and how that depends on convergence and on the kind of view.
void run_dead_reckoning(Session& session);

/// Scenes `cubes901_A`, `cubes901_B` and `orientations`: public data, coded exactly: kbit/s of a
/// world of 901 cubes at 60 Hz, each snapshot against the one six before, over a perfect network
/// and over one that loses 5 %; a frame is one snapshot encoded and decoded. Bits of a captured
/// orientation against the one before.
void run_snapshots(Session& session);

}  // namespace zoned::bench
