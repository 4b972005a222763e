// zoned-stability: worlds that are hard on the rigid-body engine, each step checked.
#include "tests/bench/commit.h"
#include "tests/bench/results.h"
#include "tests/stability/options.h"
#include "tests/stability/run.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>

namespace {

using namespace zoned::stability;

/// The cases that are asked for; none, after a message, where a name is unknown.
std::vector<Case> chosen_cases(const std::vector<std::string>& only) {
    std::vector<Case> cases = all_cases();
    for (const std::string& name : only) {
        if (std::none_of(
                cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; })) {
            std::fprintf(stderr, "zoned-stability: no case '%s'; see --list\n", name.c_str());
            return {};
        }
    }
    if (!only.empty()) {
        std::erase_if(cases, [&only](const Case& c) {
            return std::find(only.begin(), only.end(), c.name) == only.end();
        });
    }
    return cases;
}

int run_random(const RandomLabOptions& options) {
    const RandomLabResult result = run_random_lab(options);
    std::fputs(to_table(result).c_str(), stdout);
    return result.failures.empty() && result.refused.empty() ? kGood : kFailed;
}

int run(const Options& options, const std::vector<Case>& cases) {
    Run run;
    run.quick = options.quick;
    run.seed = options.seed;
    run.fault = options.fault;
    run.talk = !options.quiet;
    run.results.machine = zoned::bench::machine_name();
    run.results.commit = ZONED_COMMIT;
    run.results.seed = options.seed;
    run.results.quick = options.quick;
    for (const Case& one : cases) {
        run.progress(one.name);
        one.run(run);
    }
    std::fputs(to_table(run.results).c_str(), stdout);
    if (!options.json_file.empty()) {
        std::ofstream out(options.json_file, std::ios::binary);
        out << to_json(run.results);
        if (!out.flush()) {
            throw std::runtime_error("can't write " + options.json_file);
        }
    }
    const auto count = [&run](auto&& which) {
        return static_cast<long>(
            std::count_if(run.results.rows.begin(), run.results.rows.end(), which));
    };
    const long failed = count([](const Row& row) { return row.fails_run(); });
    const long known = count([](const Row& row) { return !row.passed() && !row.fails_run(); });
    std::printf(
        "%zu rows, %ld failed, %ld known weaknesses\n", run.results.rows.size(), failed, known);
    return failed == 0 ? kGood : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    int exit_code = kGood;
    const auto options = parse_options(argc, argv, exit_code);
    if (!options) {
        return exit_code;
    }
    if (options->list) {
        for (const Case& one : all_cases()) {
            std::printf("%-12s %s\n", one.name.c_str(), one.purpose.c_str());
        }
        std::puts("invariants of random scenes:");
        for (const std::string& name : invariant_names()) {
            std::printf("  %s\n", name.c_str());
        }
        return kGood;
    }
    try {
        if (options->random) {
            return run_random(*options->random);
        }
        if (!options->replay_file.empty()) {
            return replay_scene(options->replay_file, options->invariants, options->fault)
                       ? kGood
                       : kFailed;
        }
        const std::vector<Case> cases = chosen_cases(options->only);
        if (cases.empty()) {
            return kBadUsage;
        }
        return run(*options, cases);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-stability: %s\n", error.what());
        return kEnvironment;
    }
}
