// Budget plan: fills in the settings that a config leaves unset from the error budgets of the whole
// world.
#pragma once

#include "server/config/settings.h"
#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::config {

/// Writes settings into `config`, which is as read; what it sets already is kept. Returns one plan
/// for each setting that a budget decides or would decide, with the setting's path as subject;
/// nothing, and `config` as it was, without budgets of the whole world. Reports settings that are
/// given and leave no room in a budget. Depends on the config alone, so a replay makes the same
/// choices.
std::vector<MethodPlan> plan_budgets(proto::config::Config& config, Diagnostics& diagnostics);

WorldBudgets world_budgets(const proto::config::Config& config);

/// `--set` arguments that multiply all budgets of a world, as its config gives them: those of
/// `budget`, the contacts' budget, and the bounds of levels of detail. Settings that the plan
/// filled in follow.
std::vector<std::string> scaled_budgets(const Settings& settings, double factor);

/// Reason of a plan for a setting that the config gives.
inline constexpr const char* kAsConfigured = "as configured";

}  // namespace zoned::config
