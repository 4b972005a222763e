// RandomLab: runs random scenes on several threads, and shrinks and keeps those that fail.
#pragma once

#include "tests/stability/random/scene_run.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace zoned::stability {

struct RandomLabOptions {
    std::uint64_t seed = 1;
    std::uint64_t first = 0;  ///< number of the first scene
    std::uint64_t count = 1;  ///< how many scenes from there on
    int threads = 1;
    std::vector<Invariant> only;        ///< empty: all
    std::vector<std::string> families;  ///< empty: all
    Fault fault = Fault::kNone;
    int keep = 1;           ///< failures of each invariant that are shrunk and written
    std::string folder;     ///< for their files
    int shrink_runs = 500;  ///< of one scene at most
    bool talk = false;      ///< progress on standard error
};

/// A scene of which an invariant broke.
struct RandomFailure {
    std::uint64_t scene = 0;
    std::string families;
    std::size_t bodies = 0;
    std::size_t joints = 0;
    float dt = 0.0F;
    Breach breach;
    std::string file;  ///< of the shrunk scene; empty where it was not kept
};

struct RandomLabResult {
    std::uint64_t scenes = 0;
    std::uint64_t bodies = 0;
    std::uint64_t joints = 0;
    std::uint64_t steps = 0;
    std::uint64_t limited_steps = 0;
    std::vector<std::string> refused;     ///< scenes that did not run, and why; a fault of the lab
    std::vector<RandomFailure> failures;  ///< by scene, then by invariant
    std::vector<RandomFailure> gave_up;   ///< open joints where effort had given up
    double cpu_ms = 0.0;
};

/// The same result for any number of threads, but for the times. Throws where a file cannot be
/// written.
RandomLabResult run_random_lab(const RandomLabOptions& options);

/// A line for each failure, and a summary.
std::string to_table(const RandomLabResult& result);

/// One scene from a file, checked; prints what broke. Throws where the file cannot be read.
/// Returns whether all of `only` (empty: all) hold.
bool replay_scene(const std::string& file, const std::vector<Invariant>& only, Fault fault);

}  // namespace zoned::stability
