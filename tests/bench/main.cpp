// zoned-bench: run time against error, our methods beside their peers.
#include "tests/bench/commit.h"
#include "tests/bench/compare/baseline.h"
#include "tests/bench/compare/calibration.h"
#include "tests/bench/compare/compare_command.h"
#include "tests/bench/options.h"
#include "tests/bench/report/page.h"
#include "tests/bench/report/results_reader.h"
#include "tests/bench/report/scene_runs.h"
#include "tests/bench/suite.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>

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

bool holds(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// True where `known` accepts each name; else a message says which one it refuses.
bool all_known(const char* what,
               const std::vector<std::string>& names,
               const std::function<bool(const std::string&)>& known) {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
        const bool found = known(name);
        if (!found) {
            std::fprintf(stderr, "zoned-bench: no %s '%s'; see --list\n", what, name.c_str());
        }
        return found;
    });
}

/// The requested suites; none, after a message, where a name is unknown.
std::vector<Suite> chosen_suites(const Options& options) {
    std::vector<Suite> suites = all_suites();
    const bool known_suites =
        all_known("suite", options.suites, [&suites](const std::string& name) {
            return std::any_of(
                suites.begin(), suites.end(), [&name](const Suite& s) { return s.name == name; });
        });
    if (!known_suites) {
        return {};
    }
    if (!options.suites.empty()) {
        std::erase_if(suites,
                      [&options](const Suite& s) { return !holds(options.suites, s.name); });
    }
    const auto in_a_suite = [&suites](const auto& matches) {
        return std::any_of(suites.begin(), suites.end(), matches);
    };
    const bool known_scenes = all_known("scene", options.scenes, [&](const std::string& name) {
        return in_a_suite([&name](const Suite& s) { return holds(s.scenes, name); });
    });
    const bool known_methods = all_known("method", options.methods, [&](const std::string& name) {
        return in_a_suite([&name](const Suite& s) {
            return std::any_of(s.methods.begin(), s.methods.end(), [&name](const std::string& m) {
                return m == name || m.substr(0, m.find('/')) == name;  // a method or a peer
            });
        });
    });
    return known_scenes && known_methods ? suites : std::vector<Suite>();
}

void write_reports(const Options& options,
                   const Results& results,
                   const std::string& command_line) {
    if (!options.json_file.empty()) {
        write_text_file(options.json_file, to_json(results));
    }
    if (!options.picture_file.empty()) {
        write_text_file(options.picture_file, summary_svg(results));
    }
    if (options.report.empty()) {
        return;
    }
    const std::string page = report_html(results, command_line);
    if (options.report.ends_with(".html")) {
        write_text_file(options.report, page);
        return;
    }
    write_text_file(options.report + "/index.html", page);
    for (const Drawing& picture : results.pictures) {
        write_text_file(options.report + "/" + picture.name + ".svg", picture.svg);
    }
}

Session session_for(const Options& options) {
    Session session;
    session.scenes = options.scenes;
    session.methods = options.methods;
    session.repeats = options.repeats;
    session.quick = options.quick;
    session.pictures = !options.report.empty();
    Results& results = session.results;
    results.quick = options.quick;
    results.repeats = options.repeats;
    results.methods = options.methods;
    results.machine = machine_name();
    results.commit = ZONED_COMMIT;
    results.build = ZONED_BUILD;
    results.flags = ZONED_FLAGS;
    return session;
}

SceneHooks hooks_for(const Options& options) {
    SceneHooks hooks;
    hooks.calibrate = calibration_us;
    if (!options.resume_file.empty()) {
        hooks.after = [&options](const Results& results) {
            write_text_file(options.resume_file, to_json(results, Pictures::kKeep));
        };
    }
    return hooks;
}

/// One more pass over tasks, of which no file is kept.
Results pass_over(const Options& options, const std::vector<SceneTask>& tasks) {
    Session session = session_for(options);
    session.pictures = false;
    SceneHooks hooks;
    hooks.calibrate = calibration_us;
    run_scenes(session, tasks, hooks);
    return session.results;
}

/// Tasks of the scenes in which a time is suspected.
std::vector<SceneTask> suspected(const std::vector<Finding>& findings,
                                 const std::vector<SceneTask>& tasks,
                                 const Results& pass) {
    std::vector<SceneTask> again;
    std::size_t row = 0;
    for (const SceneRun& run : pass.runs) {
        bool suspect = false;
        for (const std::size_t end = row + run.rows; row < end; ++row) {
            const Row& r = pass.rows[row];
            const std::string name =
                r.suite + " " + r.scene + (r.parameter.empty() ? "" : " " + r.parameter);
            suspect = suspect || std::any_of(findings.begin(), findings.end(), [&](const auto& f) {
                          return f.change == Change::kSlower && f.name == name;
                      });
        }
        const auto task = std::find_if(tasks.begin(), tasks.end(), [&run](const SceneTask& t) {
            return t.suite->name == run.suite && t.scene == run.scene;
        });
        if (suspect && task != tasks.end()) {
            again.push_back(*task);
        }
    }
    return again;
}

/// A time that seems worse is measured four times more before it is named.
int compare_with_baseline(const Options& options,
                          const std::vector<SceneTask>& tasks,
                          const Results& first) {
    const Results baseline =
        results_from_json(read_text_file(options.against_file), options.against_file);
    if (baseline.quick != first.quick) {
        std::fprintf(stderr,
                     "zoned-bench: %s was measured %s --quick\n",
                     options.against_file.c_str(),
                     baseline.quick ? "with" : "without");
        return kBadUsage;
    }
    std::vector<Results> passes{first};
    std::vector<Finding> findings = regressions(baseline, passes, Limits());
    const std::vector<SceneTask> again = suspected(findings, tasks, first);
    for (int i = 0; i < 4 && !again.empty(); ++i) {
        passes.push_back(pass_over(options, again));
    }
    findings = regressions(baseline, passes, Limits());
    if (baseline.machine != first.machine || baseline.build != first.build) {
        std::printf("note: the baseline is of another machine or build: %s; %s\n",
                    baseline.machine.c_str(),
                    baseline.build.c_str());
    }
    std::fputs(findings_table(findings, rows_in_common(baseline, first)).c_str(), stdout);
    const bool fails = std::any_of(findings.begin(), findings.end(), [&options](const Finding& f) {
        return f.change == Change::kLessAccurate || !options.advise_times;
    });
    return fails ? kWorse : kGood;
}

void write_baseline(const Options& options,
                    const std::vector<SceneTask>& tasks,
                    const Results& first) {
    std::vector<Results> passes{first};
    while (passes.size() < static_cast<std::size_t>(options.passes)) {
        std::fprintf(stderr, "zoned-bench: pass %zu of %d\n", passes.size() + 1, options.passes);
        passes.push_back(pass_over(options, tasks));
    }
    write_text_file(options.baseline_file, to_json(baseline_of(passes)));
}

int run(const Options& options, const std::string& command_line) {
    const std::vector<Suite> suites = chosen_suites(options);
    if (suites.empty()) {
        return kBadUsage;
    }
    Session session = session_for(options);
    if (!options.resume_file.empty()) {
        take_over(session.results, options.resume_file);
    }
    const std::vector<SceneTask> tasks = tasks_of(suites, options.scenes);
    run_scenes(session, tasks, hooks_for(options));
    if (session.results.rows.empty()) {
        for (const std::string& note : session.results.notes) {
            std::fprintf(stderr, "zoned-bench: %s\n", note.c_str());
        }
        std::fprintf(stderr,
                     "zoned-bench: %s\n",
                     session.results.notes.empty()
                         ? "no scene and method of these names; see --list"
                         : "nothing was measured");
        return kBadUsage;
    }
    std::fputs(to_table(session.results).c_str(), stdout);
    if (options.metrics) {
        std::fputs(to_metrics_table(session.results).c_str(), stdout);
    }
    write_reports(options, session.results, command_line);
    if (!options.baseline_file.empty()) {
        write_baseline(options, tasks, session.results);
    }
    return options.against_file.empty() ? static_cast<int>(kGood)
                                        : compare_with_baseline(options, tasks, session.results);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc > 1 && std::string(argv[1]) == "compare") {
        return compare_main(argc - 1, argv + 1);
    }
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
        std::string line = "zoned-bench";
        for (int i = 1; i < argc; ++i) {
            line += std::string(" ") + argv[i];
        }
        return run(*options, line);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-bench: %s\n", error.what());
        return kEnvironment;
    }
}
