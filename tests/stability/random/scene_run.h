// SceneRun: runs a random scene from start to end under its invariants.
#pragma once

#include "tests/stability/random/scene_invariants.h"
#include "tests/stability/run.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace zoned::stability {

struct SceneRunOptions {
    /// Ends at the first breach of this one that effort did not give up; none: runs to the end.
    std::optional<Invariant> until;
    /// Changes what the checks see, and nothing else.
    std::function<void(std::uint64_t step, Observation& now)> spoil;
};

struct SceneVerdict {
    std::string refused;           ///< by the engine, or unsound; then nothing ran
    std::vector<Breach> breaches;  ///< at most one of each invariant
    std::uint64_t steps = 0;
    std::uint64_t limited_steps = 0;  ///< whose effort did not suffice
    double top_speed_mps = 0.0;
    double cpu_ms = 0.0;

    /// Breaches that fail a run: those that effort gave up are reported apart.
    [[nodiscard]] bool fails(Invariant what) const;
};

SceneVerdict run_scene(const RandomScene& scene, const SceneRunOptions& options = {});

/// A deliberate fault for SceneRunOptions::spoil: each makes its invariant fail.
std::function<void(std::uint64_t, Observation&)> spoil_with(Fault fault);

}  // namespace zoned::stability
