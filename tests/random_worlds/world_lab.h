// WorldLab: draws worlds, tries them, and reduces those that fail to the changes that matter.
#pragma once

#include "tests/random_worlds/world_trial.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace zoned::random_worlds {

struct LabEntry {
    std::uint64_t number = 0;
    std::uint64_t trial_seed = 0;
    ChangedWorld world;  ///< reduced where the trial failed
    TrialOutcome outcome;
};

struct LabSettings {
    std::vector<std::string> files;  ///< shipped worlds to begin with
    std::vector<std::string> sets;   ///< come after the changes of each world
    /// Read anew in each world; empty: half of the worlds draw their own.
    std::vector<std::string> reload;
    std::uint64_t seed = 1;
    std::uint64_t first = 0;  ///< number of the first world
    std::uint64_t count = 1;
    int most_changes = 10;
    int jobs = 1;          ///< processes at a time
    int shrink_runs = 40;  ///< trials of one world that reduce it, at most; 0: it stays as it is
    TrialSettings trial;   ///< seed 0: each world draws its own
    /// Called for each world when it is done, with the number of those that are; empty: not.
    std::function<void(const LabEntry&, std::uint64_t)> each;
};

/// By number. The same for any number of jobs, but for the times.
std::vector<LabEntry> run_lab(const LabSettings& settings);

/// The world `number` of a seed, as it was drawn.
LabEntry draw_entry(const WorldChanger& changer, const LabSettings& settings, std::uint64_t number);

/// Fewer changes with which a trial gives the same finding; no single one can be left out, where
/// `runs` trials suffice to find out.
ChangedWorld reduce(const ChangedWorld& world,
                    const TrialSettings& trial,
                    Finding finding,
                    int runs);

/// The outcome, and the command that runs the world where it failed.
std::string to_text(const LabEntry& entry);

/// How many worlds came to what.
std::string summary_of(const std::vector<LabEntry>& entries);

}  // namespace zoned::random_worlds
