// Budget load: what a config places, as far as costs are reckoned from it before anything runs.
#pragma once

#include "server/config/plan/error_models.h"

namespace zoned::proto::config {
class Config;
}

namespace zoned::config {

/// Of the bodies that the config places awake, so many are taken to move at a time, and each to
/// have four points of contact.
inline constexpr double kAwakeShare = 0.1;
inline constexpr double kPointsOfContact = 4.0;
/// Of those that it places asleep, so many are awake since somebody touched them.
inline constexpr double kTouchedShare = 0.05;
/// Contacts of bodies that land, are pushed or pinched carry this many times what they carry at
/// rest, and set the substeps of their islands.
inline constexpr double kImpactLoad = 8.0;

/// The things that the config places.
struct BudgetLoad {
    double bodies = 0.0;  ///< rigid props; of those that begin asleep kTouchedShare
    double movers = 0.0;  ///< characters, players among them
    double heard = 0.0;   ///< of these, by one viewer
    double viewers = 0.0;
    double nimbus_m = 0.0;
    Pile pile;  ///< the tallest
};

BudgetLoad load_of(const proto::config::Config& config);

}  // namespace zoned::config
