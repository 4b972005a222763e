#include "tests/bench/report/results_reader.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

namespace zoned::bench {
namespace {

TEST(ResultsReader, ReadsWhatToJsonWrote) {
    Results results;
    results.machine = "a \"machine\"";
    results.commit = "abc";
    results.build = "g++";
    results.flags = "-O2";
    results.quick = true;
    results.repeats = 5;
    results.methods = {"default"};
    results.notes = {"note"};
    results.runs = {{"s", "a", 1.5, 1, 12.0}};
    Row row;
    row.suite = "s";
    row.scene = "a_warm";
    row.parameter = "n=10";
    row.time_us_p50 = 1.25;
    row.time_us_p99 = 2.5;
    row.error = std::numeric_limits<double>::infinity();
    row.error_unit = "m";
    row.peer = "bullet";
    row.state_hash = "0123";
    row.metric("frames", 3);
    results.rows = {row};
    results.pictures = {{"name", "caption", "<svg/>"}};
    const Results read = results_from_json(to_json(results, Pictures::kKeep), "it");
    // All fields, but that what is not finite comes back as NaN.
    ASSERT_TRUE(std::isnan(read.rows.at(0).error));
    Results again = read;
    again.rows[0].error = row.error;
    EXPECT_EQ(to_json(again, Pictures::kKeep), to_json(results, Pictures::kKeep));
    EXPECT_EQ(read.rows[0].error_unit, "m");
    EXPECT_EQ(read.runs.at(0).scene, "a");
    EXPECT_TRUE(results_from_json(to_json(results), "it").pictures.empty());
}

TEST(ResultsReader, WritesIntoFoldersThatNobodyMade) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / ("reader" + std::to_string(getpid()));
    std::filesystem::remove_all(folder);
    const std::string file = (folder / "a/b/summary.svg").string();
    write_text_file(file, "<svg/>");
    EXPECT_EQ(read_text_file(file), "<svg/>");
    EXPECT_THROW(write_text_file(file + "/c.svg", ""), std::runtime_error);
    std::filesystem::remove_all(folder);
}

TEST(ResultsReader, RefusesWhatHoldsNoRowsAndNamesIt) {
    for (const char* text : {"", "rows", "{}", "[1]", "{\"rows\": 3}"}) {
        try {
            results_from_json(text, "some.json");
            ADD_FAILURE() << text;
        } catch (const std::runtime_error& error) {
            EXPECT_THAT(error.what(), testing::StartsWith("some.json holds no"));
        }
    }
}

}  // namespace
}  // namespace zoned::bench
