// MethodPlan: the methods for bodies, particles and soft bodies, selected by the error budgets of a
// config.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Fills settings.methods, and writes the selected methods into settings.physics and
/// settings.softs. These have been expanded from settings.config, a config without mistakes so far.
/// Reports a configured method that is unstable under its drag or misses its budget, with the
/// cheapest method that would keep it. Reports a budget that no method keeps. Depends on the config
/// alone, so a replay makes the same choices.
void plan_methods(Settings& settings, Diagnostics& diagnostics);

/// Distance to all players beyond which a compound or soft type is one hull; 0: never. `radius` is
/// that of its sphere, m. A distance in the config holds. Otherwise it is the distance at which the
/// error of the hull (selection::kSingleErrorShare, kSoftHullErrorShare of its diameter) is seen
/// under budget.representation_rad.
double single_beyond_m(const proto::config::Config& config,
                       const proto::config::Type& type,
                       float radius,
                       bool pinned);

/// The plan as a section of `zoned explain`: for each part the method in use and why, errors beside
/// the budget, costs, and the reason against each other method.
std::string methods_text(const Settings& settings);

}  // namespace zoned::config
