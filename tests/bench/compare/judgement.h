// Judgement: what became slower, faster or less accurate from one build to another.
#pragma once

#include "tests/bench/results.h"

#include <array>
#include <string>
#include <vector>

namespace zoned::bench {

/// Four runs close together, in the order old, new, new, old or the reverse: a machine that becomes
/// slower at a steady pace slows both builds alike.
struct Block {
    std::array<Results, 2> old_runs;
    std::array<Results, 2> new_runs;
};

/// One row in all blocks.
struct RowSamples {
    std::string suite;
    std::string scene;  ///< of the row
    std::string name;   ///< "suite scene parameter method", unique
    /// Of new over old time, by block; empty: not timed.
    std::vector<double> log_ratios;
    /// The same of the calibration kernel beside the row's scene; empty: not measured.
    std::vector<double> log_controls;
    std::vector<double> old_us;
    std::vector<double> new_us;
    std::vector<double> old_errors;  ///< absolute
    std::vector<double> new_errors;
};

struct Samples {
    std::vector<RowSamples> rows;
    std::vector<std::string> gone;  ///< rows that only the old build has
    std::vector<std::string> came;  ///< rows that only the new build has
};

Samples samples_of(const std::vector<Block>& blocks);

/// Rows of two single runs: one block of one run each. Times are taken over those of the
/// calibration kernel beside each scene, where both runs have them.
Samples samples_of(const Results& old_run, const Results& new_run);

struct Limits {
    double threshold =
        0.10;  ///< a change of time of this share is to be found, half of it is borne
    double error_threshold = 0.05;  ///< a loss of accuracy of this share is named
    double level = 0.05;            ///< chance of any false alarm
};

enum class Change {
    kNone,
    kSlower,
    kFaster,
    kLessAccurate,
    kMoreAccurate,
    kGone
};

struct Finding {
    std::string level;  ///< "suite", "scene" or "row"
    std::string name;
    Change change = Change::kNone;
    double ratio = 1.0;  ///< new over old, of times or errors
    double low = 1.0;    ///< of the ratio, 95 %; equal to it where a value is exact
    double high = 1.0;
    double p = 1.0;  ///< adjusted
    double old_value = 0.0;
    double new_value = 0.0;
};

/// Worse rather than better: the comparison fails.
bool is_worse(Change change);

/// All changes, those for the worse first.
///
/// Times: each suite, scene and row has one log ratio a block, the median over its rows. It is an
/// alarm where the signed-rank test tells it from zero and its Hodges-Lehmann estimate exceeds half
/// the threshold: a change of the whole threshold is found in spite of noise, and trifles are
/// borne. Where taking the calibration kernel's log ratio off makes the blocks agree better (by the
/// median absolute deviation, which knows no direction), it is taken off: the kernel is a control
/// variate for the machine (Lavenberg and Welch, "A Perspective on the Use of Control Variables to
/// Increase the Efficiency of Monte Carlo Simulations", Management Science 27, 1981). The three
/// levels share the chance of a false alarm, and Holm's procedure divides each share. Log ratios of
/// runs close together and an interval for the ratio follow Kalibera and Jones, "Rigorous
/// Benchmarking in Reasonable Time", ISMM 2013.
///
/// Errors: where each build repeats its error exactly, a loss beyond the threshold is always named;
/// else the medians must differ by it and the signed-rank test must tell the builds apart.
std::vector<Finding> judge(const Samples& samples, const Limits& limits);

/// The same for samples of two single runs. Nothing repeats a row, so that scenes stand for
/// repetitions: a suite of at least six scenes is tested, and all scenes together.
std::vector<Finding> judge_single(const Samples& samples, const Limits& limits);

/// Blocks from which a single row can raise an alarm, where all blocks agree.
int blocks_for_rows(std::size_t rows, double level);

}  // namespace zoned::bench
