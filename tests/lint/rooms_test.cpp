#include "tests/lint/rooms.h"

#include <gtest/gtest.h>

#include <array>

namespace zoned::lint {
namespace {

std::string include_line(const std::string& path) {
    return "#include \"" + path + "\"\n";
}

std::vector<SourceFile> files_in(const std::string& folder, int count) {
    std::vector<SourceFile> files;
    for (int i = 0; i < count; ++i) {
        files.push_back({folder + "/f" + std::to_string(i) + (i % 2 == 0 ? ".h" : ".cpp"), ""});
    }
    return files;
}

TEST(CheckLayerTable, FindsFoldersThatDoNotExist) {
    std::vector<SourceFile> files;
    for (const Layer& layer : kLayers) {
        files.push_back({std::string(layer.folder) + "/main.cpp", ""});
    }
    EXPECT_TRUE(check_layer_table(files).empty());
    files.erase(files.begin());
    const std::vector<Finding> findings = check_layer_table(files);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].path, kLayers[0].folder);
}

TEST(CheckFolderSizes, CountsHeadersAndSourcesOfAFolderAlone) {
    std::vector<SourceFile> files = files_in("server/ai", kMostInFolder);
    files.push_back({"server/ai/steering/a.h", ""});
    files.push_back({"server/ai/README.md", ""});
    EXPECT_TRUE(check_folder_sizes(files, {}).empty());
    files.push_back({"server/ai/one_more.h", ""});
    EXPECT_EQ(check_folder_sizes(files, {}).size(), 1U);
    EXPECT_TRUE(check_folder_sizes(files_in("tests/unit/ai", kMostInFolder + 1), {}).empty());
}

TEST(CheckFolderSizes, AllowsWhatAnExceptionSaysAndNoMore) {
    const std::array exception{LargeFolder{"server/ai", kMostInFolder + 2}};
    EXPECT_TRUE(check_folder_sizes(files_in("server/ai", kMostInFolder + 2), exception).empty());
    EXPECT_EQ(check_folder_sizes(files_in("server/ai", kMostInFolder + 3), exception).size(), 1U);
    EXPECT_EQ(check_folder_sizes(files_in("server/ai", kMostInFolder), exception).size(), 1U)
        << "it is not needed any more";
}

TEST(CheckRoomCycles, LetsRoomsIncludeInOneDirection) {
    EXPECT_TRUE(
        check_room_cycles(
            {
                {"server/ai/ai_update.cpp",
                 include_line("server/ai/ai_update.h") + include_line("server/ai/agent/store.h")},
                {"server/ai/agent/store.h", include_line("server/ai/ai_context.h")},
                {"server/ai/agent/store.cpp", include_line("server/ai/agent/brain.h")},
                {"server/ai/agent/brain.h", include_line("server/ai/agent/store.h")},
                {"server/ai/ai_context.h", include_line("server/world/entities.h")},
            })
            .empty())
        << "files of one room may include each other";
}

TEST(CheckRoomCycles, FindsADetourBack) {
    const std::vector<Finding> findings = check_room_cycles({
        {"server/ai/agent/store.h", include_line("server/ai/steering/velocity.h")},
        {"server/ai/steering/velocity.h", include_line("server/ai/pathfinding/grid/path.h")},
        {"server/ai/pathfinding/grid/path.h", "\n" + include_line("server/ai/agent/store.h")},
        {"server/ai/perception/senses.h", include_line("server/ai/agent/store.h")},
    });
    ASSERT_EQ(findings.size(), 1U) << to_text(findings);
    EXPECT_EQ(findings[0].path, "server/ai");
    EXPECT_NE(findings[0].what.find("agent -> steering"), std::string::npos) << findings[0].what;
    EXPECT_NE(findings[0].what.find("path.h:2"), std::string::npos) << findings[0].what;
    EXPECT_EQ(findings[0].what.find("perception"), std::string::npos) << findings[0].what;
}

TEST(CheckRoomCycles, LetsARoomAndOneInsideItIncludeEachOther) {
    EXPECT_TRUE(check_room_cycles(
                    {
                        {"server/ai/agent/store.h", include_line("server/ai/agent/brain/tree.h")},
                        {"server/ai/agent/brain/tree.h", include_line("server/ai/agent/id.h")},
                    })
                    .empty());
    EXPECT_EQ(
        check_room_cycles({
                              {"server/ai/agent/store.h", include_line("server/ai/agents/a.h")},
                              {"server/ai/agents/a.h", include_line("server/ai/agent/store.h")},
                          })
            .size(),
        1U)
        << "a name that begins alike is another room";
}

TEST(CheckRoomCycles, LeavesFilesOfTheFolderItselfToTheOrder) {
    EXPECT_TRUE(
        check_room_cycles({
                              {"server/ai/ai_update.h", include_line("server/ai/agent/store.h")},
                              {"server/ai/agent/store.h", include_line("server/ai/ai_context.h")},
                              {"server/ai/ai_context.h", include_line("server/ai/ai_update.h")},
                          })
            .empty());
}

class CheckRoomOrder : public testing::Test {
  protected:
    static std::size_t findings(const std::string& path, const std::string& target) {
        static constexpr std::array<std::string_view, 4> kRooms{
            "ai_context", "agent", "agent/brains", "ai_update"};
        static constexpr std::array kOrders{RoomOrder{"server/ai", kRooms}};
        return check_room_order({{path, include_line(target)}}, kOrders).size();
    }
};

TEST_F(CheckRoomOrder, LetsARoomIncludeItselfAndWhatStandsBeforeIt) {
    EXPECT_EQ(findings("server/ai/ai_update.cpp", "server/ai/ai_update.h"), 0U);
    EXPECT_EQ(findings("server/ai/ai_update.cpp", "server/ai/ai_context.h"), 0U);
    EXPECT_EQ(findings("server/ai/ai_update.cpp", "server/ai/agent/brains/tree.h"), 0U);
    EXPECT_EQ(findings("server/ai/agent/brains/tree.h", "server/ai/agent/store.h"), 0U);
    EXPECT_EQ(findings("server/ai/agent/store.h", "server/world/entities.h"), 0U);
}

TEST_F(CheckRoomOrder, RefusesWhatStandsAfterIt) {
    EXPECT_EQ(findings("server/ai/agent/store.h", "server/ai/ai_update.h"), 1U);
    EXPECT_EQ(findings("server/ai/agent/store.cpp", "server/ai/agent/brains/tree.h"), 1U);
    EXPECT_EQ(findings("server/ai/ai_context.h", "server/ai/agent/store.h"), 1U);
}

TEST_F(CheckRoomOrder, WantsEveryFileInARoom) {
    EXPECT_EQ(findings("server/ai/steering/velocity.h", "server/world/entities.h"), 1U);
    EXPECT_EQ(findings("server/ai/ai_updates.h", "server/world/entities.h"), 1U);
    EXPECT_EQ(findings("server/ai/README.md", "server/world/entities.h"), 0U);
}

}  // namespace
}  // namespace zoned::lint
