// zoned-bench: run time against error, our methods beside their peers.
#include "tests/bench/commit.h"
#include "tests/bench/options.h"
#include "tests/bench/plot.h"
#include "tests/bench/suite.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace {

using namespace zoned::bench;

void print_list() {
    const auto line = [](const char* what, const std::vector<std::string>& names) {
        std::printf("  %s:", what);
        for (const std::string& name : names) {
            std::printf(" %s", name.c_str());
        }
        std::printf("\n");
    };
    for (const Suite& suite : all_suites()) {
        std::printf("%s: %s\n", suite.name.c_str(), suite.purpose.c_str());
        line("scenes", suite.scenes);
        line("methods", suite.methods);
    }
}

/// The suites that are asked for, or nothing after a message about an unknown name.
std::vector<Suite> chosen_suites(const Options& options) {
    std::vector<Suite> suites = all_suites();
    for (const std::string& name : options.suites) {
        if (std::none_of(
                suites.begin(), suites.end(), [&](const Suite& s) { return s.name == name; })) {
            std::fprintf(stderr, "zoned-bench: no suite '%s'; see --list\n", name.c_str());
            return {};
        }
    }
    if (!options.suites.empty()) {
        std::erase_if(suites, [&options](const Suite& s) {
            return std::find(options.suites.begin(), options.suites.end(), s.name) ==
                   options.suites.end();
        });
    }
    return suites;
}

void write_file(const std::string& path, const std::string& text) {
    std::ofstream out(path, std::ios::binary);
    out << text;
    if (!out.flush()) {
        throw std::runtime_error("can't write " + path);
    }
}

int run(const Options& options) {
    const std::vector<Suite> suites = chosen_suites(options);
    if (suites.empty()) {
        return kBadUsage;
    }
    Session session;
    session.scenes = options.scenes;
    session.methods = options.methods;
    session.repeats = options.repeats;
    session.quick = options.quick;
    session.results.quick = options.quick;
    session.results.machine = machine_name();
    session.results.commit = ZONED_COMMIT;
    session.results.build = ZONED_BUILD;
    for (const Suite& suite : suites) {
        suite.run(session);
    }
    if (session.results.rows.empty()) {
        std::fprintf(stderr, "zoned-bench: no scene and method of these names; see --list\n");
        return kBadUsage;
    }
    std::fputs(to_table(session.results).c_str(), stdout);
    if (options.metrics) {
        std::fputs(to_metrics_table(session.results).c_str(), stdout);
    }
    if (!options.json_file.empty()) {
        write_file(options.json_file, to_json(session.results));
    }
    if (!options.report_folder.empty()) {
        std::filesystem::create_directories(options.report_folder);
        write_file(options.report_folder + "/index.html", report_html(session.results));
    }
    return kGood;
}

}  // namespace

int main(int argc, char** argv) {
    int exit_code = kGood;
    const auto options = parse_options(argc, argv, exit_code);
    if (!options) {
        return exit_code;
    }
    if (options->list) {
        print_list();
        return kGood;
    }
    try {
        return run(*options);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-bench: %s\n", error.what());
        return kEnvironment;
    }
}
