// Planner worlds: the worlds that the suite `planner` plans and measures, shipped and generated.
#pragma once

#include "server/config/settings.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::bench {

/// A world with budgets; the settings that they decide are unset.
struct PlannerWorld {
    std::string name;
    std::string text;               ///< of a config; empty: `file`
    std::string file;               ///< of a shipped world
    std::vector<std::string> sets;  ///< clear what the file sets itself, and give budgets
};

/// Six shipped worlds.
std::vector<PlannerWorld> shipped_worlds();

/// Six kinds: flight, piles, crowd, soft bodies, particles, and all mixed; numbers, sizes, places
/// and budgets are drawn by the seed.
std::vector<PlannerWorld> generated_worlds(std::uint64_t seed);

/// All worlds of config/ as they are, by name.
std::vector<PlannerWorld> all_shipped_worlds();

/// Throws std::runtime_error with the mistakes.
config::Settings settings_of(const PlannerWorld& world, const std::vector<std::string>& more);

/// Empty where they are good; the first mistake otherwise.
std::string try_settings(const PlannerWorld& world,
                         const std::vector<std::string>& more,
                         config::Settings& settings);

}  // namespace zoned::bench
