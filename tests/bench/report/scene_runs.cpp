#include "tests/bench/report/scene_runs.h"

#include "tests/bench/cpu_clock.h"
#include "tests/bench/report/results_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace zoned::bench {

namespace {

bool is_done(const std::vector<SceneRun>& runs, const SceneTask& task) {
    return std::any_of(runs.begin(), runs.end(), [&task](const SceneRun& run) {
        return run.suite == task.suite->name && run.scene == task.scene;
    });
}

/// The mean seconds of the runs of a suite, or of all where `suite` is empty; negative for none.
double mean_seconds(const std::vector<SceneRun>& runs, const std::string& suite) {
    double sum = 0.0;
    int count = 0;
    for (const SceneRun& run : runs) {
        if (suite.empty() || run.suite == suite) {
            sum += run.seconds;
            ++count;
        }
    }
    return count == 0 ? -1.0 : sum / count;
}

std::string time_text(double seconds) {
    if (seconds < 0.0) {
        return "time left unknown";
    }
    return seconds < 90.0 ? "about " + std::to_string(std::lround(seconds)) + " s left"
                          : "about " + std::to_string(std::lround(seconds / 60.0)) + " min left";
}

void refuse_other(const char* what,
                  const std::string& kept,
                  const std::string& now,
                  const std::string& file) {
    if (kept != now) {
        throw std::runtime_error(file + " was measured with another " + what + " ('" + kept +
                                 "', now '" + now + "'): choose another file or remove it");
    }
}

}  // namespace

std::vector<SceneTask> tasks_of(const std::vector<Suite>& suites,
                                const std::vector<std::string>& scenes) {
    std::vector<SceneTask> tasks;
    for (const Suite& suite : suites) {
        for (const std::string& scene : suite.scenes) {
            if (scenes.empty() || std::find(scenes.begin(), scenes.end(), scene) != scenes.end()) {
                tasks.push_back({&suite, scene});
            }
        }
    }
    return tasks;
}

double seconds_left(const std::vector<SceneTask>& tasks,
                    std::size_t next,
                    const std::vector<SceneRun>& runs) {
    const double overall = mean_seconds(runs, "");
    if (overall < 0.0) {
        return -1.0;
    }
    double left = 0.0;
    for (std::size_t i = next; i < tasks.size(); ++i) {
        if (!is_done(runs, tasks[i])) {
            const double own = mean_seconds(runs, tasks[i].suite->name);
            left += own < 0.0 ? overall : own;
        }
    }
    return left;
}

void take_over(Results& results, const std::string& resume_file) {
    if (!std::filesystem::exists(resume_file)) {
        return;
    }
    Results kept = results_from_json(read_text_file(resume_file), resume_file);
    refuse_other("machine", kept.machine, results.machine, resume_file);
    refuse_other("build", kept.build, results.build, resume_file);
    refuse_other("commit", kept.commit, results.commit, resume_file);
    refuse_other("choice of --quick",
                 kept.quick ? "quick" : "full",
                 results.quick ? "quick" : "full",
                 resume_file);
    refuse_other(
        "--repeat", std::to_string(kept.repeats), std::to_string(results.repeats), resume_file);
    if (kept.methods != results.methods) {
        throw std::runtime_error(
            resume_file + " was measured with other methods: choose another file or remove it");
    }
    results = std::move(kept);
}

void run_scenes(Session& session, const std::vector<SceneTask>& tasks, const SceneHooks& hooks) {
    Results& results = session.results;
    const std::vector<std::string> wanted = session.scenes;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const SceneTask& task = tasks[i];
        if (is_done(results.runs, task)) {
            continue;
        }
        session.progress("scene " + std::to_string(i + 1) + " of " + std::to_string(tasks.size()) +
                         ", " + task.suite->name + " " + task.scene + ", " +
                         time_text(seconds_left(tasks, i, results.runs)));
        const std::size_t rows = results.rows.size();
        const std::int64_t begin = wall_ns();
        const double before = hooks.calibrate ? hooks.calibrate() : 0.0;
        session.scenes = {task.scene};
        task.suite->run(session);
        const double after = hooks.calibrate ? hooks.calibrate() : 0.0;
        results.runs.push_back({task.suite->name,
                                task.scene,
                                static_cast<double>(wall_ns() - begin) * 1e-9,
                                results.rows.size() - rows,
                                std::sqrt(before * after)});
        if (hooks.after) {
            hooks.after(results);
        }
    }
    session.scenes = wanted;
}

}  // namespace zoned::bench
