// SceneRuns: runs suites scene by scene, so that an interrupted run goes on where it stopped.
#pragma once

#include "tests/bench/suite.h"

#include <functional>
#include <string>
#include <vector>

namespace zoned::bench {

/// One scene of one suite.
struct SceneTask {
    const Suite* suite = nullptr;
    std::string scene;
};

/// Every scene of the suites, or those of them that `scenes` names. They point into `suites`.
std::vector<SceneTask> tasks_of(const std::vector<Suite>& suites,
                                const std::vector<std::string>& scenes);

/// Seconds that the tasks from `next` on will take, by the mean of scenes already run: those of the
/// same suite where there are some, else all. Negative where none was run.
double seconds_left(const std::vector<SceneTask>& tasks,
                    std::size_t next,
                    const std::vector<SceneRun>& runs);

/// Takes over the rows of an earlier run's file where there is one. Throws std::runtime_error where
/// the earlier run was of another machine, build, commit, number of repeats or methods: their rows
/// can't stand beside each other.
void take_over(Results& results, const std::string& resume_file);

/// The work beside a scene.
struct SceneHooks {
    std::function<double()> calibrate;          ///< empty: not; else microseconds
    std::function<void(const Results&)> after;  ///< empty, or called after each scene
};

/// Runs the tasks whose scene session.results.runs lacks, and says on standard error how many are
/// left and for how long.
void run_scenes(Session& session, const std::vector<SceneTask>& tasks, const SceneHooks& hooks);

}  // namespace zoned::bench
