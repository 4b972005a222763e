#include "tests/stability/options.h"

#include "tests/stability/random/scene_generator.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>

namespace zoned::stability {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  zoned-stability --list\n"
    "  zoned-stability --quick\n"
    "  zoned-stability --only press,mass-ratio --seed 7 --json stability.json\n"
    "  zoned-stability --only stack --inject floor\n"
    "  zoned-stability --random 1000 --seed 1 --threads 2 --out found\n"
    "  zoned-stability --seed 1 --scene 17 --only energy,joint\n"
    "  zoned-stability --replay found/random-1-17-energy.txt\n"
    "Exit codes: 0 all rows pass, 1 a row or a random scene fails, 2 bad usage, 3 environment (a "
    "file can't be "
    "written, ...).";

/// The invariants of these names; nothing after a message where one is unknown.
std::optional<std::vector<Invariant>> named_invariants(const std::vector<std::string>& names) {
    std::vector<Invariant> found;
    for (const std::string& name : names) {
        const auto& all = invariant_names();
        const auto at = std::find(all.begin(), all.end(), name);
        if (at == all.end()) {
            std::fprintf(stderr, "zoned-stability: no invariant '%s'; see --list\n", name.c_str());
            return std::nullopt;
        }
        found.push_back(static_cast<Invariant>(at - all.begin()));
    }
    return found;
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
    Options o;
    std::string fault = fault_names().front();
    CLI::App app("zoned-stability: worlds that are hard on a rigid-body engine, each step checked");
    RandomLabOptions lab;
    app.add_option(
           "--only", o.only, "Only these cases, or invariants of random scenes, comma-separated")
        ->delimiter(',');
    app.add_option("--json", o.json_file, "Writes the rows as JSON to FILE");
    app.add_option("--seed", o.seed, "Of what is random; every seed has to pass");
    app.add_option("--inject", fault, "Puts a fault into what the checks read: rows must fail")
        ->check(CLI::IsMember(fault_names()));
    app.add_flag("--quick", o.quick, "Smaller worlds, less than half a minute in all");
    app.add_flag("--list", o.list, "Lists the cases and runs nothing");
    app.add_flag("--quiet", o.quiet, "No progress on standard error");
    auto* random =
        app.add_option(
               "--random", lab.count, "Runs N random scenes under invariants in place of the cases")
            ->check(CLI::Range(1, 100'000'000));
    auto* scene = app.add_option("--scene", lab.first, "The first random scene, or the only one")
                      ->check(CLI::NonNegativeNumber);
    app.add_option("--families", lab.families, "Only these families of things in random scenes")
        ->delimiter(',')
        ->check(CLI::IsMember(family_names()));
    app.add_option("--threads", lab.threads, "Threads that run random scenes")
        ->check(CLI::Range(1, 256));
    app.add_option("--keep", lab.keep, "Failures of each invariant that are shrunk and written")
        ->check(CLI::Range(0, 1000));
    app.add_option("--out", lab.folder, "An existing folder for shrunk scenes")
        ->check(CLI::ExistingDirectory);
    app.add_option("--replay", o.replay_file, "Runs the random scene of FILE")
        ->excludes(random)
        ->excludes(scene);
    app.footer(kExamples);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        exit_code = app.exit(error) == 0 ? kGood : kBadUsage;
        return std::nullopt;
    }
    const auto& names = fault_names();
    o.fault = static_cast<Fault>(std::find(names.begin(), names.end(), fault) - names.begin());
    if (*random || *scene) {
        lab.seed = o.seed;
        lab.fault = o.fault;
        lab.talk = !o.quiet;
        o.random = lab;
    }
    if (o.random || !o.replay_file.empty()) {
        const auto invariants = named_invariants(o.only);
        if (!invariants) {
            exit_code = kBadUsage;
            return std::nullopt;
        }
        o.invariants = *invariants;
        if (o.random) {
            o.random->only = *invariants;
        }
    }
    return o;
}

}  // namespace zoned::stability
