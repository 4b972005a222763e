// zoned-random-worlds: shipped worlds with random changes, each with bots on a bad network; exit
// code 1 where one breaks a promise.
#include "tests/random_worlds/world_lab.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <thread>

namespace {

using namespace zoned::random_worlds;

/// Worlds small enough for a trial of a few seconds.
std::vector<std::string> shipped_worlds(const std::vector<std::string>& only) {
    std::vector<std::string> files;
    const std::filesystem::path root = ZONED_SOURCE_DIR "/config";
    for (const auto& folder : {root, root / "methods"}) {
        for (const auto& file : std::filesystem::directory_iterator(folder)) {
            const std::string name = file.path().stem().string();
            const bool large = name == "city" || name == "swarms" || name == "cubes";
            const bool chosen =
                only.empty() ? !large : std::find(only.begin(), only.end(), name) != only.end();
            if (file.path().extension() == ".txtpb" && chosen) {
                files.push_back(file.path().string());
            }
        }
    }
    std::sort(files.begin(), files.end());  // folders have no order of their own
    return files;
}

}  // namespace

int main(int argc, char** argv) {
    LabSettings settings;
    settings.count = 20;
    settings.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    std::vector<std::string> only;
    bool quiet = false;
    CLI::App app(
        "zoned-random-worlds: shipped worlds with random changes, checked as bots see them");
    app.add_option("--worlds", settings.count, "How many");
    app.add_option("--seed", settings.seed, "Of the changes, networks and bots");
    app.add_option("--first", settings.first, "Number of the first world of the seed");
    app.add_option("--only", only, "Shipped worlds to change, as \"arena\" (repeatable)");
    app.add_option(
        "--changes", settings.most_changes, "Changes of a world, at most; 0: none but --set");
    app.add_option("--trial-seed",
                   settings.trial.seed,
                   "Of networks and bots, as the table tells it; 0: drawn");
    app.add_option("--set", settings.sets, "path.to.field=value after all changes (repeatable)");
    app.add_option("--reload",
                   settings.reload,
                   "path.to.field=value that is read anew in the middle of the play (repeatable)");
    app.add_option("--bots", settings.trial.bots, "Bots in each world");
    app.add_option("--seconds", settings.trial.seconds, "They play for so long");
    app.add_option("--jobs", settings.jobs, "Worlds at a time");
    app.add_option(
        "--reduce", settings.shrink_runs, "Trials that reduce a world that fails, at most");
    app.add_option("--most-cpu", settings.trial.most_cpu_s, "CPU seconds of a trial, at most");
    app.add_flag("--quiet", quiet, "No progress");
    CLI11_PARSE(app, argc, argv);
    // Told at once: a run may be ended early.
    settings.each = [&](const LabEntry& entry, std::uint64_t done) {
        if (!quiet) {
            std::fprintf(stderr,
                         "%llu of %llu done, %s: %s, %.1f s of CPU\n",
                         static_cast<unsigned long long>(done),
                         static_cast<unsigned long long>(settings.count),
                         entry.world.file.c_str(),
                         name_of(entry.outcome.finding),
                         entry.outcome.cpu_s);
        }
        if (entry.outcome.finding != Finding::kNone) {
            std::printf("%s\n", to_text(entry).c_str());
            std::fflush(stdout);
        }
    };
    settings.files = shipped_worlds(only);
    try {
        if (settings.files.empty()) {
            throw std::runtime_error("no shipped world has that name");
        }
        const std::vector<LabEntry> entries = run_lab(settings);
        std::printf("%s\n", summary_of(entries).c_str());
        return std::any_of(entries.begin(),
                           entries.end(),
                           [](const LabEntry& e) { return e.outcome.failed(); })
                   ? 1
                   : 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-random-worlds: %s\n", error.what());
        return 3;
    }
}
