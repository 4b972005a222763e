// Method costs: measures the costs in the table of server/physics/method_selection/cost_table.h.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Scene `free_flight` of the suite `integrators`: a piece of free flight of one body by each
/// method. Metrics ns_per_step, table_ns, measured_over_table.
void run_flight_costs(Session& session);

/// Scene `substeps` of the suite `soft`: rope, cloth, jelly and balloon (`parameter`) by each
/// method of soft bodies. The same metrics, of a step of 1/60 s.
void run_substep_costs(Session& session);

}  // namespace zoned::bench
