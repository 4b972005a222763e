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

/// Scenes `bodies250` (250 spinning bodies on circular orbits of 1 to 10 m around centres that
/// drift, to one client at 30 Hz), `crowd200` (200 clients that all see each other's avatars, which
/// take a new direction every 1 to 3 s, 10 Hz) and `crowd100` (100 of them, 30 Hz): bytes of all
/// clients together, and what the first client is wrong by. A frame is one step of replication for
/// all clients.
void run_scenes(Session& session);

}  // namespace zoned::bench
