#include "tests/lint/check.h"
#include "tests/lint/layers.h"
#include "tests/lint/local_names.h"
#include "tests/lint/math_calls.h"
#include "tests/lint/names.h"
#include "tests/lint/pages.h"
#include "tests/lint/reach.h"
#include "tests/lint/rooms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace zoned::lint {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// All text files below the checked folders, by path.
std::vector<SourceFile> sources_below(const fs::path& root) {
    std::vector<SourceFile> files;
    files.push_back({"README.md", read(root / "README.md")});
    for (const std::string_view folder : kCheckedFolders) {
        const fs::path base = root / folder;
        if (!fs::exists(base)) {
            continue;
        }
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(base)) {
            if (!entry.is_regular_file()) {
                continue;
            }
            SourceFile file{fs::relative(entry.path(), root).generic_string(), read(entry.path())};
            if (file.text.find('\0') == std::string::npos) {
                files.push_back(std::move(file));
            }
        }
    }
    std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) {
        return a.path < b.path;
    });
    return files;
}

TEST(Repository, IsFoundWithItsSources) {
    const std::vector<SourceFile> files = sources_below(ZONED_SOURCE_DIR);
    // A wrong root would let every other check pass for want of files.
    EXPECT_TRUE(std::any_of(files.begin(), files.end(), [](const SourceFile& file) {
        return file.path == "shared/core/ids.h";
    }));
}

TEST(Repository, HasTheFixedTopLevel) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(ZONED_SOURCE_DIR)) {
        names.push_back(entry.path().filename().string());
    }
    const std::vector<Finding> findings = check_top_level(names);
    EXPECT_TRUE(findings.empty()) << to_text(findings);
}

using Check = std::vector<Finding> (*)(const SourceFile&);

void expect_clean(Check check) {
    std::vector<Finding> all;
    for (const SourceFile& file : sources_below(ZONED_SOURCE_DIR)) {
        std::vector<Finding> found = check(file);
        std::move(found.begin(), found.end(), std::back_inserter(all));
    }
    EXPECT_TRUE(all.empty()) << to_text(all);
}

TEST(Repository, IncludesOnlyUpTheLayerOrder) {
    expect_clean(check_includes);
}

TEST(Repository, BeginsEveryHeaderWithItsPurpose) {
    expect_clean(check_header);
}

TEST(Repository, HasNoOverlongFile) {
    expect_clean(check_length);
}

TEST(Repository, HasNoMarksOfUnfinishedWork) {
    expect_clean(check_words);
}

TEST(Repository, KeepsTheSandboxGameToItsRulesAndBots) {
    expect_clean(check_sandbox);
}

TEST(Repository, KeepsTheSentenceRulesInItsPages) {
    expect_clean(check_page);
}

TEST(Repository, ComputesTheSameBitsOnAllComputers) {
    expect_clean(check_math_calls);
}

TEST(Repository, UsesNoWordThatWasRenamed) {
    expect_clean([](const SourceFile& file) { return check_renamed_words(file); });
}

/// Checks that look at all files together.
template <class TreeCheck>
void expect_clean_tree(TreeCheck check) {
    const std::vector<Finding> findings = check(sources_below(ZONED_SOURCE_DIR));
    EXPECT_TRUE(findings.empty()) << to_text(findings);
}

TEST(Repository, HasTheFoldersOfTheLayerTable) {
    expect_clean_tree(check_layer_table);
}

TEST(Repository, ReachesAllItsSourcesFromAProgram) {
    expect_clean_tree(check_reached);
}

TEST(Repository, HasNoCrowdedFolder) {
    expect_clean_tree([](const auto& files) { return check_folder_sizes(files); });
}

TEST(Repository, HasNoRoomsThatIncludeEachOther) {
    expect_clean_tree(check_room_cycles);
}

TEST(Repository, IncludesOnlyUpTheOrderOfItsRooms) {
    expect_clean_tree([](const auto& files) { return check_room_order(files); });
}

TEST(Repository, NamesEachHeaderOnce) {
    expect_clean_tree([](const auto& files) { return check_header_names(files); });
}

TEST(Repository, CompilesSeveralSourcesAsOne) {
    expect_clean_tree([](const auto& files) { return check_local_names(files); });
}

TEST(Repository, NamesEachTypeOnce) {
    expect_clean_tree([](const auto& files) { return check_type_names(files); });
}

}  // namespace
}  // namespace zoned::lint
