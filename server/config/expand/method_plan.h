// Method plan: what moves bodies, particles and soft bodies, chosen by the error budgets of a
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

/// Fills settings.methods, and what it chooses into settings.physics and settings.softs, which have
/// been expanded from settings.config, a config without mistakes so far. Reports a method named
/// there that cannot bear its drag or misses its budget, with the cheapest that would keep it, and
/// a budget that nothing keeps. Depends on the config alone: a replay makes the same choices.
void plan_methods(Settings& settings, Diagnostics& diagnostics);

/// From which distance to all players on a compound or soft type with the radius of its sphere, m,
/// is one hull: as it says itself, or from where on what it is then off by (selection::
/// kSingleErrorShare, kSoftHullErrorShare of its diameter) is seen under budget.representation_rad.
/// 0: never.
double single_beyond_m(const proto::config::Config& config,
                       const proto::config::Type& type,
                       float radius,
                       bool pinned);

/// The plan as a section of `zoned explain`: for each part what is used and why, errors beside the
/// budget, costs, and why each of the others was refused.
std::string methods_text(const Settings& settings);

}  // namespace zoned::config
