// Suite `navigation`: its parts, one file each.
#pragma once

#include "tests/bench/grid_scene.h"
#include "tests/bench/suite.h"

#include <string>

namespace zoned::bench {

/// Rows `goal_field`: time of a field to a new goal.
void run_flow_fields(Session& session, const GridScene& scene);

/// Row `door`: time until a planner with squares may be asked again after a cell of a path was
/// blocked or opened. A path is wrong where its length is not the one that A* finds then.
void run_doors(Session& session, const GridScene& scene);

/// The map that is patched between queries: rows of scene `kPatchedScene`.
void run_patched_map(Session& session);

inline const std::string kPatchedScene = "arena2_patched";

}  // namespace zoned::bench
