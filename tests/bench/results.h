// Results: rows that a benchmark reports on one method and one scene, and how rows are written out.
#pragma once

#include <cstdint>
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

struct Results {
    std::string machine;
    std::string commit;
    std::string build;
    bool quick = false;  ///< scenes were cut short: times hint, errors mean little
    std::vector<std::string> notes;
    std::vector<Row> rows;
    std::vector<Drawing> pictures;
};

/// {"machine", "commit", "build", "quick", "notes", "rows": [...]}; numbers that are not finite
/// become null.
std::string to_json(const Results& results);

/// A table for a terminal: one line per row, notes below it.
std::string to_table(const Results& results);

/// All metrics, one line per row.
std::string to_metrics_table(const Results& results);

/// Processor and system in one line.
std::string machine_name();

}  // namespace zoned::bench
