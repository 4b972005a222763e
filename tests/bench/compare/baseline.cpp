#include "tests/bench/compare/baseline.h"

#include "tests/bench/report/front.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace zoned::bench {

namespace {

/// The median absolute deviation of a normal distribution is this share of its standard deviation.
constexpr double kDeviationShare = 0.6745;
/// Spreads of few passes come out too small by chance.
constexpr double kLeastSpread = 0.01;
/// An error this small is rounding, in whatever unit.
constexpr double kRounding = 1e-12;

std::string default_name(const Row& row) {
    return row.suite + " " + row.scene + (row.parameter.empty() ? "" : " " + row.parameter);
}

bool is_timed(const Row& row) {
    return std::isfinite(row.time_us_p50) && row.time_us_p50 > 0.0;
}

const Row* peer_beside(const Results& results, const Row& row) {
    for (const Row& other : results.rows) {
        if (!other.peer.empty() && other.method == "default" && is_timed(other) &&
            std::tie(other.suite, other.scene, other.parameter) ==
                std::tie(row.suite, row.scene, row.parameter)) {
            return &other;
        }
    }
    return nullptr;
}

/// Values of one default over passes.
struct OverPasses {
    Row row;
    bool by_peer = false;
    std::vector<double> log_ratios;
    std::vector<double> errors;
};

std::map<std::string, OverPasses> over_passes(std::span<const Results> passes) {
    std::map<std::string, OverPasses> all;
    for (const Results& pass : passes) {
        for (const DefaultRatio& ratio : default_ratios(pass)) {
            OverPasses& values = all[default_name(*ratio.row)];
            if (values.log_ratios.empty()) {
                values.row = *ratio.row;
                values.by_peer = ratio.by_peer;
            }
            values.log_ratios.push_back(std::log(ratio.ratio));
            values.errors.push_back(std::abs(ratio.row->error));
        }
    }
    return all;
}

double spread_of(const std::vector<double>& values) {
    const double middle = median(values);
    std::vector<double> deviations;
    for (const double value : values) {
        deviations.push_back(std::abs(value - middle));
    }
    return std::max(kLeastSpread, median(deviations) / kDeviationShare);
}

Finding worse_finding(const std::string& name, Change change, double before, double after) {
    Finding finding;
    finding.level = "row";
    finding.name = name;
    finding.change = change;
    finding.old_value = before;
    finding.new_value = after;
    finding.ratio = finding.low = finding.high = after / before;
    return finding;
}

double metric_or(const Row& row, const char* name, double otherwise) {
    const double* const value = row.find_metric(name);
    return value == nullptr ? otherwise : *value;
}

}  // namespace

std::vector<DefaultRatio> default_ratios(const Results& results) {
    std::vector<double> calibrations;
    for (const SceneRun& run : results.runs) {
        calibrations.insert(calibrations.end(), run.rows, run.calibration_us);
    }
    calibrations.resize(results.rows.size());
    std::vector<DefaultRatio> ratios;
    for (std::size_t i = 0; i < results.rows.size(); ++i) {
        const Row& row = results.rows[i];
        if (role_of(row) != Role::kDefault || !is_timed(row)) {
            continue;
        }
        const Row* const peer = peer_beside(results, row);
        const double yardstick = peer != nullptr ? peer->time_us_p50 : calibrations[i];
        if (yardstick > 0.0) {
            ratios.push_back({&row, row.time_us_p50 / yardstick, peer != nullptr});
        }
    }
    return ratios;
}

Results baseline_of(std::span<const Results> passes) {
    Results baseline;
    baseline.machine = passes.front().machine;
    baseline.commit = passes.front().commit;
    baseline.build = passes.front().build;
    baseline.flags = passes.front().flags;
    baseline.quick = passes.front().quick;
    baseline.repeats = passes.front().repeats;
    baseline.notes = {
        "ratio: the time of the default over that of a peer's default in the same "
        "scene (by_peer 1) or of the calibration kernel beside it, the median of " +
        std::to_string(passes.size()) + " passes"};
    for (const auto& [name, values] : over_passes(passes)) {
        if (values.log_ratios.size() != passes.size()) {
            continue;
        }
        Row row = values.row;
        row.metrics.clear();
        row.state_hash.clear();
        row.metric("ratio", std::exp(median(values.log_ratios)));
        row.metric("spread", spread_of(values.log_ratios));
        row.metric("by_peer", values.by_peer ? 1.0 : 0.0);
        row.metric("error_largest", largest(values.errors));
        baseline.rows.push_back(row);
    }
    return baseline;
}

std::vector<Finding> regressions(const Results& baseline,
                                 std::span<const Results> passes,
                                 const Limits& limits) {
    const std::map<std::string, OverPasses> now = over_passes(passes);
    std::vector<Finding> findings;
    for (const Row& row : baseline.rows) {
        const auto at = now.find(default_name(row));
        if (at == now.end()) {
            continue;
        }
        const OverPasses& values = at->second;
        const double before = metric_or(row, "ratio", 0.0);
        const double after = median(values.log_ratios);
        const double limit =
            std::max(std::log1p(limits.threshold), 3.0 * metric_or(row, "spread", 0.0));
        const bool same_yardstick = (metric_or(row, "by_peer", 0.0) == 1.0) == values.by_peer;
        if (same_yardstick && before > 0.0 && after - std::log(before) > limit) {
            findings.push_back(worse_finding(at->first, Change::kSlower, before, std::exp(after)));
        }
        const double worst = metric_or(row, "error_largest", 0.0);
        const double least = *std::min_element(values.errors.begin(), values.errors.end());
        const bool lost = std::isnan(least)
                              ? !std::isnan(worst)
                              : least > kRounding &&
                                    least >= worst * (1.0 + limits.error_threshold) * (1.0 - 1e-9);
        if (lost) {
            findings.push_back(worse_finding(at->first, Change::kLessAccurate, worst, least));
        }
    }
    return findings;
}

std::size_t rows_in_common(const Results& baseline, const Results& pass) {
    const std::map<std::string, OverPasses> now = over_passes({&pass, 1});
    return static_cast<std::size_t>(
        std::count_if(baseline.rows.begin(), baseline.rows.end(), [&now](const Row& row) {
            return now.count(default_name(row)) != 0;
        }));
}

}  // namespace zoned::bench
