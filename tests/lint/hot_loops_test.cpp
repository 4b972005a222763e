// Sources marked as hot loops are built as such, whatever they are called, and no others are.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace zoned::lint {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = "// build: hot loops";

/// By source, relative to the repository: how it is compiled.
std::map<std::string, std::string> compile_commands() {
    std::map<std::string, std::string> out;
    std::ifstream in(fs::path(ZONED_BINARY_DIR) / "compile_commands.json");
    std::string command;
    for (std::string line; std::getline(in, line);) {
        if (line.find("\"command\": ") != std::string::npos) {
            command = line;
        }
        const std::string key = "\"file\": \"" + std::string(ZONED_SOURCE_DIR) + "/";
        const std::size_t at = line.find(key);
        if (at != std::string::npos) {
            const std::size_t from = at + key.size();
            out[line.substr(from, line.find('"', from) - from)] = command;
        }
    }
    return out;
}

bool is_marked(const fs::path& file) {
    std::ifstream in(file);
    std::string first;
    return std::getline(in, first) && first.rfind(kMark, 0) == 0;
}

TEST(HotLoops, MarkedSourcesAreCompiledByThemselvesWithTheHighestOptimisation) {
    const auto commands = compile_commands();
    ASSERT_FALSE(commands.empty());
    int marked = 0;
    for (const char* folder : {"server", "shared", "client-sim", "tests/bench"}) {
        for (const auto& entry :
             fs::recursive_directory_iterator(fs::path(ZONED_SOURCE_DIR) / folder)) {
            if (entry.path().extension() != ".cpp") {
                continue;
            }
            const std::string name = fs::relative(entry.path(), ZONED_SOURCE_DIR).generic_string();
            const auto command = commands.find(name);
            const bool hot = command != commands.end() &&
                             command->second.find(" -O3 ") != std::string::npos &&
                             command->second.find("cmake_pch.hxx") == std::string::npos;
            EXPECT_EQ(hot, is_marked(entry.path())) << name;
            marked += hot ? 1 : 0;
        }
    }
    EXPECT_GT(marked, 20);
}

}  // namespace
}  // namespace zoned::lint
