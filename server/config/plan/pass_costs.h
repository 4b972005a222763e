// Pass costs: the one table of what the passes of a step cost, by the units of work in them.
#pragma once

#include "server/zone/plan.h"
#include "server/zone/zone_state.h"

#include <array>
#include <string_view>

namespace zoned::config {

/// Kinds of units of one pass, at most; the first is the run of the pass itself.
inline constexpr std::size_t kUnitKinds = 7;

/// Numbers of units of a pass, in one tick or as means over several.
using PassUnits = std::array<double, kUnitKinds>;

/// The cost of a pass is linear in its units, each with its own price.
struct PassCost {
    std::array<std::string_view, kUnitKinds> unit{};  ///< empty: none of that kind
    std::array<double, kUnitKinds> ns{};              ///< CPU time of one, on the reference machine
};

const PassCost& cost_of(zone::Pass pass);

/// The units that a pass had in a step; all zero where it did not run.
PassUnits units_of(zone::Pass pass, const zone::StepReport& report);

/// By the table, ns on the reference machine.
double table_ns(zone::Pass pass, const PassUnits& units);

/// Expected cost of a run of the pass, ns. `measured_ns` is the mean over `ran` runs that were
/// measured on this machine; the table counts as much as kTableRuns of them, times `speed`.
double expected_ns(double table_ns, double speed, double measured_ns, double ran);

/// So many measured runs say as much as the table.
inline constexpr double kTableRuns = 4.0;

}  // namespace zoned::config
