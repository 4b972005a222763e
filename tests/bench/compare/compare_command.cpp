#include "tests/bench/compare/compare_command.h"

#include "tests/bench/compare/program_run.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/options.h"
#include "tests/bench/report/results_reader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>

namespace zoned::bench {

namespace {

struct CompareOptions {
    std::string old_build;
    std::string new_build;
    std::vector<std::string> suites;
    std::vector<std::string> scenes;
    std::vector<std::string> methods;
    int rounds = 12;
    double threshold_percent = 10.0;
    double error_threshold_percent = 5.0;
    bool quick = false;
};

constexpr const char* kCompareFooter =
    "Examples:\n"
    "  zoned-bench compare old/zoned-bench build/zoned-bench physics --quick\n"
    "  zoned-bench compare old.json new.json\n"
    "A change of the threshold is found, one of half of it is borne. Any false alarm is at most "
    "one\n"
    "run in twenty. Exit codes: 0 nothing got worse, 1 something did, 2 bad usage, 3 environment.";

/// False where the program must end with `exit_code`.
bool parse(int argc, const char* const* argv, CompareOptions& o, int& exit_code) {
    CLI::App app("zoned-bench compare: what became slower, faster or less accurate");
    app.add_option("OLD", o.old_build, "A zoned-bench, or a file of --json")->required();
    app.add_option("NEW", o.new_build, "The same, of the build that is judged")->required();
    app.add_option("SUITE", o.suites, "Suites to run; all by default");
    app.add_option("--scene", o.scenes, "Only these scenes, comma-separated")->delimiter(',');
    app.add_option("--method", o.methods, "Only these methods or peers, comma-separated")
        ->delimiter(',');
    app.add_option("--rounds", o.rounds, "Rounds of four runs: old, new, new, old")
        ->check(CLI::Range(1, 1000));
    app.add_option("--threshold", o.threshold_percent, "Change of time to find, %")
        ->check(CLI::Range(1.0, 1000.0));
    app.add_option("--error-threshold", o.error_threshold_percent, "Loss of accuracy to name, %")
        ->check(CLI::Range(0.001, 1000.0));
    app.add_flag("--quick", o.quick, "Runs scenes cut short");
    app.footer(kCompareFooter);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        exit_code = app.exit(error) == 0 ? kGood : kBadUsage;
        return false;
    }
    return true;
}

std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        text += (text.empty() ? "" : ",") + name;
    }
    return text;
}

std::vector<std::string> run_arguments(const CompareOptions& o) {
    std::vector<std::string> arguments = o.suites;
    arguments.insert(arguments.end(), {"--repeat", "1"});
    if (!o.scenes.empty()) {
        arguments.insert(arguments.end(), {"--scene", joined(o.scenes)});
    }
    if (!o.methods.empty()) {
        arguments.insert(arguments.end(), {"--method", joined(o.methods)});
    }
    if (o.quick) {
        arguments.emplace_back("--quick");
    }
    return arguments;
}

const char* word_for(Change change) {
    switch (change) {
        case Change::kNone:
            return "same";
        case Change::kSlower:
            return "slower";
        case Change::kFaster:
            return "faster";
        case Change::kLessAccurate:
            return "less accurate";
        case Change::kMoreAccurate:
            return "more accurate";
        case Change::kGone:
            return "gone";
    }
    return "";
}

template <class... Values>
std::string line_text(const char* pattern, Values... values) {
    std::array<char, 512> text{};
    std::snprintf(text.data(), text.size(), pattern, values...);
    return text.data();
}

Samples measured_samples(const CompareOptions& o) {
    const std::vector<Block> blocks =
        measured_blocks(o.old_build, o.new_build, run_arguments(o), o.rounds);
    Samples samples = samples_of(blocks);
    const int needed = blocks_for_rows(samples.rows.size(), Limits().level);
    if (o.rounds < needed) {
        std::printf(
            "note: with %d rounds suites and scenes are tested; a single one of %zu rows "
            "raises an alarm from --rounds %d on\n",
            o.rounds,
            samples.rows.size(),
            needed);
    }
    return samples;
}

Samples samples_of_files(const CompareOptions& o) {
    const Results old_run = results_from_json(read_text_file(o.old_build), o.old_build);
    const Results new_run = results_from_json(read_text_file(o.new_build), o.new_build);
    std::printf(
        "note: one run a side: scenes stand for repetitions, and single scenes are not "
        "tested for time; give two programs for that\n");
    if (old_run.machine != new_run.machine || old_run.quick != new_run.quick) {
        std::printf("note: the runs are of different machines or lengths: %s%s; %s%s\n",
                    old_run.machine.c_str(),
                    old_run.quick ? " (quick)" : "",
                    new_run.machine.c_str(),
                    new_run.quick ? " (quick)" : "");
    }
    return samples_of(old_run, new_run);
}

int compare_builds(const CompareOptions& o) {
    const bool old_file = is_json_file(o.old_build);
    if (old_file != is_json_file(o.new_build)) {
        std::fprintf(stderr, "zoned-bench: give two programs or two files of --json\n");
        return kBadUsage;
    }
    Limits limits;
    limits.threshold = o.threshold_percent / 100.0;
    limits.error_threshold = o.error_threshold_percent / 100.0;
    const Samples samples = old_file ? samples_of_files(o) : measured_samples(o);
    if (samples.rows.empty()) {
        std::fprintf(stderr, "zoned-bench: the two have no row in common\n");
        return kBadUsage;
    }
    const std::vector<Finding> findings =
        old_file ? judge_single(samples, limits) : judge(samples, limits);
    std::fputs(findings_table(findings, samples.rows.size()).c_str(), stdout);
    for (const std::string& name : samples.came) {
        std::printf("note: only the new build has %s\n", name.c_str());
    }
    const bool worse = std::any_of(
        findings.begin(), findings.end(), [](const Finding& f) { return is_worse(f.change); });
    return worse ? kWorse : kGood;
}

}  // namespace

std::vector<Block> measured_blocks(const std::string& old_program,
                                   const std::string& new_program,
                                   const std::vector<std::string>& arguments,
                                   int count) {
    std::vector<Block> blocks;
    const std::int64_t begin = wall_ns();
    for (int i = 0; i < count; ++i) {
        const double spent = static_cast<double>(wall_ns() - begin) * 1e-9;
        std::fprintf(stderr, "zoned-bench: round %d of %d", i + 1, count);
        if (i > 0) {
            std::fprintf(stderr, ", about %.0f s left", spent / i * (count - i));
        }
        std::fprintf(stderr, "\n");
        Block block;
        const bool old_first = i % 2 == 0;
        const std::string& outer = old_first ? old_program : new_program;
        const std::string& inner = old_first ? new_program : old_program;
        std::array<Results, 2>& outer_runs = old_first ? block.old_runs : block.new_runs;
        std::array<Results, 2>& inner_runs = old_first ? block.new_runs : block.old_runs;
        outer_runs[0] = results_of_program(outer, arguments);
        inner_runs[0] = results_of_program(inner, arguments);
        inner_runs[1] = results_of_program(inner, arguments);
        outer_runs[1] = results_of_program(outer, arguments);
        blocks.push_back(std::move(block));
    }
    return blocks;
}

std::string findings_table(const std::vector<Finding>& findings, std::size_t rows) {
    std::string text;
    std::size_t width = 4;
    for (const Finding& finding : findings) {
        width = std::max(width, finding.name.size());
    }
    const int wide = static_cast<int>(width);
    if (!findings.empty()) {
        text += line_text("%-13s  %-5s  %-*s  %10s  %10s  %8s  %s\n",
                          "change",
                          "level",
                          wide,
                          "what",
                          "old",
                          "new",
                          "ratio",
                          "95 % interval, adjusted p");
    }
    std::size_t slower = 0;
    std::size_t lost = 0;
    std::size_t better = 0;
    for (const Finding& f : findings) {
        slower += f.change == Change::kSlower ? 1 : 0;
        lost += f.change == Change::kLessAccurate || f.change == Change::kGone ? 1 : 0;
        better += is_worse(f.change) ? 0 : 1;
        const bool exact = f.low == f.high;
        const bool single = f.level == "row";  // a suite has no one time
        text += line_text("%-13s  %-5s  %-*s  %10s  %10s  %8.3f  ",
                          word_for(f.change),
                          f.level.c_str(),
                          wide,
                          f.name.c_str(),
                          single ? line_text("%.4g", f.old_value).c_str() : "",
                          single ? line_text("%.4g", f.new_value).c_str() : "",
                          f.ratio);
        text += exact ? "exact\n" : line_text("%.3f to %.3f, p = %.2g\n", f.low, f.high, f.p);
    }
    return text +
           line_text(
               "%zu rows compared; findings: %zu slower, %zu less accurate or gone, %zu better\n",
               rows,
               slower,
               lost,
               better);
}

int compare_main(int argc, const char* const* argv) {
    CompareOptions options;
    int exit_code = kGood;
    if (!parse(argc, argv, options, exit_code)) {
        return exit_code;
    }
    try {
        return compare_builds(options);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-bench: %s\n", error.what());
        return kEnvironment;
    }
}

}  // namespace zoned::bench
