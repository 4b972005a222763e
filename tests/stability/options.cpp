#include "tests/stability/options.h"

#include <CLI/CLI.hpp>

#include <algorithm>

namespace zoned::stability {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  zoned-stability --list\n"
    "  zoned-stability --quick\n"
    "  zoned-stability --only press,mass-ratio --seed 7 --json stability.json\n"
    "  zoned-stability --only stack --inject floor\n"
    "Exit codes: 0 all rows pass, 1 a row fails, 2 bad usage, 3 environment (a file can't be "
    "written, ...).";

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
    Options o;
    std::string fault = fault_names().front();
    CLI::App app("zoned-stability: worlds that are hard on a rigid-body engine, each step checked");
    app.add_option("--only", o.only, "Only these cases, comma-separated")->delimiter(',');
    app.add_option("--json", o.json_file, "Writes the rows as JSON to FILE");
    app.add_option("--seed", o.seed, "Of what is random; every seed has to pass");
    app.add_option("--inject", fault, "Puts a fault into what the checks read: rows must fail")
        ->check(CLI::IsMember(fault_names()));
    app.add_flag("--quick", o.quick, "Smaller worlds, less than half a minute in all");
    app.add_flag("--list", o.list, "Lists the cases and runs nothing");
    app.add_flag("--quiet", o.quiet, "No progress on standard error");
    app.footer(kExamples);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        exit_code = app.exit(error) == 0 ? kGood : kBadUsage;
        return std::nullopt;
    }
    const auto& names = fault_names();
    o.fault = static_cast<Fault>(std::find(names.begin(), names.end(), fault) - names.begin());
    return o;
}

}  // namespace zoned::stability
