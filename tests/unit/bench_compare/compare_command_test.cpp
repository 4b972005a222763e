#include "tests/bench/compare/compare_command.h"

#include "tests/bench/compare/program_run.h"
#include "tests/bench/options.h"
#include "tests/bench/report/results_reader.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace zoned::bench {
namespace {

/// Scripts that speak as zoned-bench does: each notes its run, and writes its rows where --json
/// says.
class CompareCommand : public testing::Test {
  protected:
    CompareCommand() : folder(testing::TempDir() + "compare" + std::to_string(getpid())) {
        std::filesystem::create_directories(folder);
    }

    ~CompareCommand() override { std::filesystem::remove_all(folder); }

    [[nodiscard]] std::string rows(const char* name, double time_us, double error) const {
        Results results;
        for (const char* scene : {"a", "b", "c", "d", "e", "f", "g"}) {
            Row row;
            row.suite = "suite";
            row.scene = scene;
            row.time_us_p50 = time_us;
            row.error = error;
            results.rows.push_back(row);
        }
        write_text_file(folder + "/" + name, to_json(results));
        return folder + "/" + name;
    }

    [[nodiscard]] std::string program(const char* name, double time_us, double error) const {
        const std::string json = rows((std::string(name) + ".json").c_str(), time_us, error);
        return script(name,
                      "echo " + std::string(name) + " \"$@\" >> " + folder +
                          "/log\nwhile [ \"$1\" != --json ]; do shift; done\ncp " + json +
                          " \"$2\"\n");
    }

    [[nodiscard]] std::string script(const char* name, const std::string& text) const {
        const std::string path = folder + "/" + name;
        std::ofstream(path) << "#!/bin/sh\n" << text;
        chmod(path.c_str(), 0700);
        return path;
    }

    int compare(std::vector<std::string> arguments) {
        std::vector<const char*> argv{"compare"};
        for (const std::string& argument : arguments) {
            argv.push_back(argument.c_str());
        }
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        const int code = compare_main(static_cast<int>(argv.size()), argv.data());
        said = testing::internal::GetCapturedStdout();
        errors = testing::internal::GetCapturedStderr();
        return code;
    }

    std::string folder;
    std::string said;
    std::string errors;
};

TEST_F(CompareCommand, RunsBothBuildsInTurnsWithTheChosenScenes) {
    EXPECT_EQ(compare({program("old", 10.0, 1.0),
                       program("new", 10.0, 1.0),
                       "suite",
                       "--scene",
                       "a,b",
                       "--quick",
                       "--rounds",
                       "2"}),
              kGood);
    std::istringstream log(read_text_file(folder + "/log"));
    std::string order;
    for (std::string line; std::getline(log, line);) {
        order += line.substr(0, 3) + " ";
        EXPECT_THAT(line, testing::HasSubstr("suite --repeat 1 --scene a,b --quick --json "));
    }
    EXPECT_EQ(order, "old new new old new old old new ");
    EXPECT_THAT(said, testing::HasSubstr("findings: 0 slower, 0 less accurate"));
    EXPECT_THAT(errors, testing::HasSubstr("round 2 of 2, about "));
}

TEST_F(CompareCommand, EndsWithOneWhereSomethingGotWorse) {
    const std::string old_build = program("old", 10.0, 1.0);
    EXPECT_EQ(compare({old_build, program("new", 12.0, 1.0)}), kWorse);
    EXPECT_THAT(said, testing::ContainsRegex("slower +suite +suite "));
    EXPECT_EQ(compare({old_build, program("new", 8.0, 1.0)}), kGood);
    EXPECT_THAT(said, testing::ContainsRegex("faster +suite +suite "));
    EXPECT_EQ(compare({old_build, program("new", 10.0, 1.06), "--rounds", "1"}), kWorse);
    EXPECT_THAT(said, testing::ContainsRegex("less accurate +row +suite a default"));
}

TEST_F(CompareCommand, TakesTwoFiles) {
    const std::string old_rows = rows("old.json", 10.0, 1.0);
    EXPECT_EQ(compare({old_rows, rows("new.json", 10.0, 1.0)}), kGood);
    EXPECT_EQ(compare({old_rows, rows("new.json", 12.0, 1.0)}), kWorse);
    EXPECT_EQ(compare({old_rows, rows("new.json", 10.0, 2.0)}), kWorse);
}

TEST_F(CompareCommand, TellsBadUsageFromWhatIsMissing) {
    EXPECT_EQ(compare({}), kBadUsage);
    EXPECT_EQ(compare({rows("old.json", 1.0, 1.0), program("new", 1.0, 1.0)}), kBadUsage);
    EXPECT_THAT(errors, testing::HasSubstr("two programs or two files"));
    EXPECT_EQ(compare({folder + "/none", folder + "/none"}), kEnvironment);
    EXPECT_THAT(errors, testing::HasSubstr("can't start"));
    const std::string broken = script("broken", "echo it broke >&2\nexit 3\n");
    EXPECT_EQ(compare({broken, broken}), kEnvironment);
    EXPECT_THAT(errors, testing::HasSubstr("ended with 3: it broke"));
}

}  // namespace
}  // namespace zoned::bench
