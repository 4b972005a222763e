// Suite `replication`: its parts, one function and one file each.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Scenes `dead_reckoning` and `display`: each kind of prediction on each kind of motion, at
/// several thresholds. They measure publications and bytes per second, the error that a client
/// sees, and the jerk of the displayed motion. They also show how that depends on convergence and
/// on the kind of view.
void run_dead_reckoning(Session& session);

/// Scenes `bodies250`, `crowd200` and `crowd100` measure the bytes of all clients together and the
/// error of the first client's view. `bodies250` has 250 spinning bodies on circular orbits of 1 to
/// 10 m around drifting centres, sent to one client at 30 Hz. `crowd200` has 200 clients that all
/// see each other's avatars; these take a new direction every 1 to 3 s, at 10 Hz. `crowd100` has
/// 100 of them at 30 Hz. `cubes901_A` and `cubes901_B` are public data: 901 cubes at 60 Hz, each
/// within half a quantum of 1/512 m and nine bits at every tick, acknowledged after six ticks; over
/// a perfect network and over one that loses 5 % in each direction. A frame is one step of
/// replication for all clients.
void run_scenes(Session& session);

}  // namespace zoned::bench
