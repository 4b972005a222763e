// Suite `crowd`: its parts, one file each.
#pragma once

#include "tests/bench/suite.h"

#include <string>

namespace zoned::bench {

/// Rows of scene `avoidance_20k`: time of a step per agent; the error is the largest overlap of two
/// agents after any step, over a radius.
void run_crowd_avoidance(Session& session);

/// Rows of scene `flock_50k`: a step of a flock that follows a path, on two threads (`default`),
/// one and a device.
void run_crowd_flock(Session& session);

/// Pictures of a corridor, of two doors with the paths that avoid a crowd, and of scents.
void draw_crowds(Session& session);

inline const std::string kAvoidanceScene = "avoidance_20k";
inline const std::string kFlockScene = "flock_50k";

}  // namespace zoned::bench
