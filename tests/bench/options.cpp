#include "tests/bench/options.h"

#include <CLI/CLI.hpp>

namespace zoned::bench {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  zoned-bench --list\n"
    "  zoned-bench physics --json physics.json\n"
    "  zoned-bench physics --scene S1,S3 --method default,bullet --repeat 5\n"
    "  zoned-bench --report build/bench.html --resume build/bench-kept.json\n"
    "  zoned-bench --quick --report build/bench.html --picture build/bench.svg\n"
    "  zoned-bench --quick --against tests/bench/baseline.json\n"
    "zoned-bench compare OLD NEW sets two builds against each other: zoned-bench compare --help.\n"
    "Exit codes: 0 good, 1 worse than --against, 2 bad usage, 3 environment (a file can't be "
    "written, ...).";

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
    Options o;
    CLI::App app("zoned-bench: run time against error, our methods beside their peers");
    app.add_option("SUITE", o.suites, "Suites to run; all by default");
    app.add_option("--scene", o.scenes, "Only these scenes, comma-separated")->delimiter(',');
    app.add_option("--method", o.methods, "Only these methods or peers, comma-separated")
        ->delimiter(',');
    app.add_option("--json", o.json_file, "Writes the rows as JSON to FILE");
    app.add_option("--report",
                   o.report,
                   "Writes a page of plots and tables: to FILE.html, or to DIR/index.html");
    app.add_option("--picture", o.picture_file, "Writes the summary as a picture to FILE.svg");
    app.add_option(
        "--resume", o.resume_file, "Keeps measured scenes in FILE, and skips those that it holds");
    app.add_option(
        "--against", o.against_file, "Names defaults that got worse against the baseline in FILE");
    app.add_flag("--advise-times",
                 o.advise_times,
                 "With --against: slower rows are named, and less accurate ones alone fail");
    app.add_option("--baseline", o.baseline_file, "Writes a baseline for --against to FILE");
    app.add_option("--passes", o.passes, "Runs of a baseline")->check(CLI::Range(3, 1000));
    app.add_option("--repeat", o.repeats, "Timed runs of each method; medians count")
        ->check(CLI::Range(1, 1000));
    app.add_flag("--quick", o.quick, "Cuts every scene short: shows that all run, within seconds");
    app.add_flag("--list", o.list, "Lists suites, scenes and methods, and runs nothing");
    app.add_flag("--metrics", o.metrics, "Prints all metrics below the table");
    app.footer(kExamples);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        exit_code = app.exit(error) == 0 ? kGood : kBadUsage;
        return std::nullopt;
    }
    return o;
}

}  // namespace zoned::bench
