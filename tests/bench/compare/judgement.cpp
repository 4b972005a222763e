#include "tests/bench/compare/judgement.h"

#include "tests/bench/compare/rank_statistics.h"
#include "tests/bench/report/front.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

namespace zoned::bench {

namespace {

constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
/// Errors this small are rounding, in whatever unit.
constexpr double kExact = 1e-12;

/// A row and the calibration kernel's time beside its scene, 0 where it was not measured.
struct CalibratedRow {
    const Row* row = nullptr;
    double calibration_us = 0.0;
};

/// Rows of a run by their names; a second row of one name gets a number.
using NamedRows = std::map<std::string, CalibratedRow>;

NamedRows named_rows(const Results& run) {
    NamedRows rows;
    std::vector<double> calibrations;
    for (const SceneRun& scene : run.runs) {
        calibrations.insert(calibrations.end(), scene.rows, scene.calibration_us);
    }
    calibrations.resize(run.rows.size());
    for (std::size_t at = 0; at < run.rows.size(); ++at) {
        const Row& row = run.rows[at];
        const std::string name = row.suite + " " + row.scene +
                                 (row.parameter.empty() ? "" : " " + row.parameter) + " " +
                                 method_name(row);
        std::string unique = name;
        for (int i = 2; rows.count(unique) != 0; ++i) {
            unique = name + " (" + std::to_string(i) + ")";
        }
        rows[unique] = {&row, calibrations[at]};
    }
    return rows;
}

double log_time(const Row& row) {
    return row.time_us_p50 > 0.0 && std::isfinite(row.time_us_p50) ? std::log(row.time_us_p50)
                                                                   : kNoTime;
}

RowSamples samples_named(const std::string& name, const Row& row) {
    RowSamples samples;
    samples.suite = row.suite;
    samples.scene = row.scene;
    samples.name = name;
    return samples;
}

void add_run(const Row& row, std::vector<double>& times, std::vector<double>& errors) {
    times.push_back(row.time_us_p50);
    errors.push_back(std::abs(row.error));
}

/// Rows that all runs have, in order of their names, and those that one build alone has.
std::vector<std::string> common_rows(const std::vector<NamedRows>& old_runs,
                                     const std::vector<NamedRows>& new_runs,
                                     Samples& samples) {
    std::map<std::string, std::array<std::size_t, 2>> counts;
    for (const NamedRows& run : old_runs) {
        for (const auto& entry : run) {
            ++counts[entry.first][0];
        }
    }
    for (const NamedRows& run : new_runs) {
        for (const auto& entry : run) {
            ++counts[entry.first][1];
        }
    }
    std::vector<std::string> common;
    for (const auto& [name, count] : counts) {
        if (count[1] == 0) {
            samples.gone.push_back(name);
        } else if (count[0] == 0) {
            samples.came.push_back(name);
        } else if (count[0] == old_runs.size() && count[1] == new_runs.size()) {
            common.push_back(name);
        }
    }
    return common;
}

/// The logarithm of new over old of the calibration kernel; NaN where one of the two lacks it.
double log_control(const CalibratedRow& before, const CalibratedRow& after) {
    return before.calibration_us > 0.0 && after.calibration_us > 0.0
               ? std::log(after.calibration_us / before.calibration_us)
               : kNoTime;
}

void drop_unless_finite(std::vector<double>& values) {
    if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
        values.clear();
    }
}

/// One line of log ratios that is tested, and whose it is.
struct Tested {
    std::string name;
    std::vector<double> log_ratios;
};

double deviation_of(const std::vector<double>& values) {
    const double middle = median(values);
    std::vector<double> deviations;
    for (const double value : values) {
        deviations.push_back(std::abs(value - middle));
    }
    return median(deviations);
}

/// The rows of each group, as one line: by block the median over the rows, with the calibration
/// kernel as control where that makes the blocks agree better.
std::vector<Tested> grouped(const Samples& samples,
                            const std::function<std::string(const RowSamples&)>& group_of) {
    struct Group {
        std::vector<std::vector<double>> plain;
        std::vector<std::vector<double>> controlled;
    };

    std::map<std::string, Group> groups;
    for (const RowSamples& row : samples.rows) {
        if (row.log_ratios.empty()) {
            continue;
        }
        Group& group = groups[group_of(row)];
        group.plain.push_back(row.log_ratios);
        if (row.log_controls.size() == row.log_ratios.size()) {
            std::vector<double> controlled = row.log_ratios;
            std::transform(controlled.begin(),
                           controlled.end(),
                           row.log_controls.begin(),
                           controlled.begin(),
                           std::minus<>());
            group.controlled.push_back(controlled);
        }
    }
    std::vector<Tested> tested;
    for (const auto& [name, group] : groups) {
        std::vector<double> line = median_of_rows(group.plain);
        if (group.controlled.size() == group.plain.size()) {
            const std::vector<double> controlled = median_of_rows(group.controlled);
            // A single block has no deviation: the control is trusted.
            line = line.size() < 2 || deviation_of(controlled) < deviation_of(line) ? controlled
                                                                                    : line;
        }
        tested.push_back({name, line});
    }
    return tested;
}

/// Findings on one level, whose share of false alarms is `level`.
void test_times(const std::string& level_name,
                const std::vector<Tested>& tested,
                const Limits& limits,
                double level,
                std::vector<Finding>& findings) {
    const double borne = 0.5 * std::log1p(limits.threshold);
    std::vector<double> slower;
    std::vector<double> faster;
    for (const Tested& t : tested) {
        slower.push_back(signed_rank_p(t.log_ratios, 0.0));
        std::vector<double> turned = t.log_ratios;
        std::transform(turned.begin(), turned.end(), turned.begin(), std::negate<>());
        faster.push_back(signed_rank_p(turned, 0.0));
    }
    slower = holm(slower);
    faster = holm(faster);
    for (std::size_t i = 0; i < tested.size(); ++i) {
        const Location at = hodges_lehmann(tested[i].log_ratios);
        if (std::min(slower[i], faster[i]) > level || std::abs(at.middle) < borne) {
            continue;
        }
        Finding finding;
        finding.level = level_name;
        finding.name = tested[i].name;
        finding.change = slower[i] <= level ? Change::kSlower : Change::kFaster;
        finding.ratio = std::exp(at.middle);
        finding.low = std::exp(at.low);
        finding.high = std::exp(at.high);
        finding.p = std::min(slower[i], faster[i]);
        findings.push_back(finding);
    }
}

bool all_alike(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [&values](double value) {
        return value == values[0] || (std::isnan(value) && std::isnan(values[0]));
    });
}

/// Whether an error grew by a share of at least `threshold`.
bool is_loss(double before, double after, double threshold) {
    if (!std::isfinite(after) || !std::isfinite(before)) {
        return std::isfinite(before) && !std::isfinite(after);
    }
    return after > kExact && after >= before * (1.0 + threshold) * (1.0 - 1e-9) && after > before;
}

Finding error_finding(const RowSamples& row, Change change, double before, double after) {
    Finding finding;
    finding.level = "row";
    finding.name = row.name;
    finding.change = change;
    finding.old_value = before;
    finding.new_value = after;
    finding.ratio = finding.low = finding.high = after / before;
    finding.p = 0.0;
    return finding;
}

/// Errors that differ between the runs of one build, against those of the other, pair by pair.
double error_p(const std::vector<double>& before, const std::vector<double>& after) {
    std::vector<double> differences;
    for (std::size_t i = 0; i + 1 < before.size(); i += 2) {
        differences.push_back(after[i] + after[i + 1] - before[i] - before[i + 1]);
    }
    return signed_rank_p(differences, 0.0);
}

void test_errors(const Samples& samples, const Limits& limits, std::vector<Finding>& findings) {
    std::vector<Finding> random;
    std::vector<double> p;
    for (const RowSamples& row : samples.rows) {
        const double before = median(row.old_errors);
        const double after = median(row.new_errors);
        const bool exact = all_alike(row.old_errors) && all_alike(row.new_errors);
        const bool lost = is_loss(before, after, limits.error_threshold);
        if (!lost && !is_loss(after, before, limits.error_threshold)) {
            continue;
        }
        const Finding finding =
            error_finding(row, lost ? Change::kLessAccurate : Change::kMoreAccurate, before, after);
        if (exact) {
            findings.push_back(finding);
            continue;
        }
        random.push_back(finding);
        p.push_back(lost ? error_p(row.old_errors, row.new_errors)
                         : error_p(row.new_errors, row.old_errors));
    }
    const std::vector<double> adjusted = holm(p);
    for (std::size_t i = 0; i < random.size(); ++i) {
        random[i].p = adjusted[i];
        if (adjusted[i] <= limits.level) {
            findings.push_back(random[i]);
        }
    }
}

void finish(const Samples& samples, std::vector<Finding>& findings) {
    for (const std::string& name : samples.gone) {
        Finding finding;
        finding.level = "row";
        finding.name = name;
        finding.change = Change::kGone;
        findings.push_back(finding);
    }
    for (Finding& finding : findings) {
        for (const RowSamples& row : samples.rows) {
            if (row.name == finding.name && finding.change <= Change::kFaster) {
                finding.old_value = median(row.old_us);
                finding.new_value = median(row.new_us);
            }
        }
    }
    std::stable_sort(findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
        return is_worse(a.change) > is_worse(b.change);
    });
}

std::string suite_name(const RowSamples& row) {
    return row.suite;
}

std::string scene_name(const RowSamples& row) {
    return row.suite + " " + row.scene;
}

std::string row_name(const RowSamples& row) {
    return row.name;
}

Samples samples_of_runs(const std::vector<NamedRows>& old_runs,
                        const std::vector<NamedRows>& new_runs,
                        std::size_t runs_in_block) {
    Samples samples;
    for (const std::string& name : common_rows(old_runs, new_runs, samples)) {
        RowSamples row = samples_named(name, *old_runs.front().at(name).row);
        for (std::size_t i = 0; i < old_runs.size(); i += runs_in_block) {
            double ratio = 0.0;
            double control = 0.0;
            for (std::size_t j = i; j < i + runs_in_block; ++j) {
                const CalibratedRow& before = old_runs[j].at(name);
                const CalibratedRow& after = new_runs[j].at(name);
                const double share = 1.0 / static_cast<double>(runs_in_block);
                ratio += share * (log_time(*after.row) - log_time(*before.row));
                control += share * log_control(before, after);
                add_run(*before.row, row.old_us, row.old_errors);
                add_run(*after.row, row.new_us, row.new_errors);
            }
            row.log_ratios.push_back(ratio);
            row.log_controls.push_back(control);
        }
        drop_unless_finite(row.log_ratios);
        drop_unless_finite(row.log_controls);
        samples.rows.push_back(row);
    }
    return samples;
}

}  // namespace

bool is_worse(Change change) {
    return change == Change::kSlower || change == Change::kLessAccurate || change == Change::kGone;
}

Samples samples_of(const std::vector<Block>& blocks) {
    std::vector<NamedRows> old_runs;
    std::vector<NamedRows> new_runs;
    for (const Block& block : blocks) {
        for (std::size_t i = 0; i < 2; ++i) {
            old_runs.push_back(named_rows(block.old_runs.at(i)));
            new_runs.push_back(named_rows(block.new_runs.at(i)));
        }
    }
    return samples_of_runs(old_runs, new_runs, 2);
}

Samples samples_of(const Results& old_run, const Results& new_run) {
    return samples_of_runs({named_rows(old_run)}, {named_rows(new_run)}, 1);
}

std::vector<Finding> judge(const Samples& samples, const Limits& limits) {
    std::vector<Finding> findings;
    const double share = limits.level / 3.0;
    test_times("suite", grouped(samples, suite_name), limits, share, findings);
    test_times("scene", grouped(samples, scene_name), limits, share, findings);
    test_times("row", grouped(samples, row_name), limits, share, findings);
    test_errors(samples, limits, findings);
    finish(samples, findings);
    return findings;
}

std::vector<Finding> judge_single(const Samples& samples, const Limits& limits) {
    constexpr std::size_t kLeastScenes = 6;
    std::map<std::string, std::vector<double>> suites;
    std::vector<Tested> all{{"all suites", {}}};
    for (const Tested& scene : grouped(samples, scene_name)) {
        suites[scene.name.substr(0, scene.name.find(' '))].push_back(scene.log_ratios[0]);
        all[0].log_ratios.push_back(scene.log_ratios[0]);
    }
    std::vector<Tested> tested;
    for (const auto& [name, ratios] : suites) {
        if (ratios.size() >= kLeastScenes) {
            tested.push_back({name, ratios});
        }
    }
    std::vector<Finding> findings;
    if (all[0].log_ratios.size() >= kLeastScenes) {
        test_times("all", all, limits, 0.5 * limits.level, findings);
    }
    test_times("suite", tested, limits, 0.5 * limits.level, findings);
    test_errors(samples, limits, findings);
    finish(samples, findings);
    return findings;
}

int blocks_for_rows(std::size_t rows, double level) {
    return static_cast<int>(
        std::ceil(std::log2(std::max(1.0, static_cast<double>(rows)) * 3.0 / level)));
}

}  // namespace zoned::bench
