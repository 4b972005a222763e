#include "server/config/expand/load_settings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace zoned::config {
namespace {

const std::string kFolder = ZONED_SOURCE_DIR "/config";

Settings minimal_with(const std::vector<std::string>& sets) {
    Settings settings;
    std::vector<ConfigError> errors;
    EXPECT_TRUE(load_settings(kFolder + "/minimal.txtpb", sets, settings, errors))
        << format_errors("minimal", errors);
    return settings;
}

TEST(FilesOfAConfig, AreRelativeToItsFolder) {
    const Settings settings =
        minimal_with({"session.state_folder=\"run/here\"", "recording.file=run.zrec"});
    EXPECT_EQ(settings.server.session.state_folder, kFolder + "/run/here");
    EXPECT_EQ(settings.server.recording_file, kFolder + "/run.zrec");
}

TEST(FilesOfAConfig, OfTheDefaultAreThereToo) {
    const Settings settings = minimal_with({});
    EXPECT_EQ(settings.server.session.state_folder, kFolder + "/state");
    EXPECT_TRUE(settings.server.recording_file.empty());
}

TEST(FilesOfAConfig, StayWhereTheyAreWhenTheirPathsAreWhole) {
    const Settings settings =
        minimal_with({"session.state_folder=\"/var/lib/zoned\"", "recording.file=\"/tmp/a.zrec\""});
    EXPECT_EQ(settings.server.session.state_folder, "/var/lib/zoned");
    EXPECT_EQ(settings.server.recording_file, "/tmp/a.zrec");
}

/// A config of the folder in which the server runs has no folder to name.
TEST(FilesOfAConfig, OfTheCurrentFolderAreNamedFromThere) {
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(kFolder);
    Settings settings;
    std::vector<ConfigError> errors;
    const bool good = load_settings("minimal.txtpb", {"recording.file=run.zrec"}, settings, errors);
    std::filesystem::current_path(before);
    ASSERT_TRUE(good);
    EXPECT_EQ(settings.server.session.state_folder, "state");
    EXPECT_EQ(settings.server.recording_file, "run.zrec");
}

}  // namespace
}  // namespace zoned::config
