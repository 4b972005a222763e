// Results: rows that a benchmark reports on one method and one scene, and how rows are written out.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace zoned::bench {

struct Row {
    std::string suite;
    std::string scene;
    std::string method = "default";  ///< `default` is the method that a user gets without asking
    std::string parameter;           ///< e.g. "dt=1/240"; empty where the scene has none
    double time_us_p50 = 0.0;        ///< CPU time of one frame, see timing.h
    double time_us_p99 = 0.0;
    double error = 0.0;
    std::string error_unit;
    std::vector<std::pair<std::string, double>> metrics;  ///< name_unit and value
    std::string peer;                                     ///< empty for our own rows
    std::string state_hash;                               ///< empty where there is none

    void metric(std::string name, double value);

    /// The value of a metric, or null.
    [[nodiscard]] const double* find_metric(const std::string& name) const;
};

/// A picture of a scene, for the report.
struct Drawing {
    std::string name;  ///< of its file, without .svg
    std::string caption;
    std::string svg;
};

/// A scene that was run: its rows stand one after the other, in the order of the runs.
struct SceneRun {
    std::string suite;
    std::string scene;     ///< as `--scene` takes it; its rows may have narrower names
    double seconds = 0.0;  ///< by the wall, building of the scene included
    std::size_t rows = 0;
    double calibration_us =
        0.0;  ///< the calibration kernel beside it (compare/calibration.h); 0: not measured
};

struct Results {
    std::string machine;
    std::string commit;
    std::string build;
    std::string flags;                 ///< of the compiler
    bool quick = false;                ///< scenes were cut short: times hint, errors mean little
    int repeats = 0;                   ///< timed runs of each method that were asked for
    std::vector<std::string> methods;  ///< asked for; empty: all
    std::vector<std::string> notes;
    std::vector<SceneRun> runs;
    std::vector<Row> rows;
    std::vector<Drawing> pictures;
};

enum class Pictures {
    kLeaveOut,
    kKeep
};

/// {"machine", "commit", "build", "flags", "quick", "repeats", "methods", "notes", "runs": [...],
/// "rows": [...]}; numbers that are not finite become null. Pictures are for files that a run
/// resumes from.
std::string to_json(const Results& results, Pictures pictures = Pictures::kLeaveOut);

/// A table for a terminal: one line per row, notes below it.
std::string to_table(const Results& results);

/// All metrics, one line per row.
std::string to_metrics_table(const Results& results);

/// Processor and system in one line.
std::string machine_name();

}  // namespace zoned::bench
