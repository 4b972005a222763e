// ReportFile: a report comes to disk whole or not at all, and on a full disk too.
#include "server/recording/report_file.h"

#include <gmock/gmock.h>
#include <sys/mount.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace zoned::recording {
namespace {

namespace fs = std::filesystem;

class ReportFiles : public testing::Test {
  protected:
    ReportFiles() {
        fs::remove_all(folder);
        fs::create_directories(folder);
    }

    ~ReportFiles() override { fs::remove_all(folder); }

    static std::string content(const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        std::ostringstream text;
        text << in.rdbuf();
        return text.str();
    }

    std::string folder = testing::TempDir() + "zoned_report_" +
                         testing::UnitTest::GetInstance()->current_test_info()->name();
    std::string file = folder + "/report.json";
};

TEST_F(ReportFiles, ReplaceTheOldReportByTheWholeNewOne) {
    std::ofstream(file) << "old";
    ReportFile report;
    ASSERT_TRUE(report.reserve(file).ok());
    EXPECT_EQ(content(file), "old") << "until there is a new one";
    ASSERT_TRUE(report.commit("{\"new\": 1}\n").ok());
    EXPECT_EQ(content(file), "{\"new\": 1}\n");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1)
        << "nothing else is left";
}

TEST_F(ReportFiles, LeaveTheOldReportWhenThereIsNoNewOne) {
    std::ofstream(file) << "old";
    {
        ReportFile report;
        ASSERT_TRUE(report.reserve(file).ok());
    }
    EXPECT_EQ(content(file), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST_F(ReportFiles, SayBeforehandThatAFileCannotBeWritten) {
    ReportFile report;
    const auto failed = report.reserve("/nonexistent/report.json");
    ASSERT_FALSE(failed.ok());
    EXPECT_THAT(failed.error(), testing::HasSubstr("No such file"));
    EXPECT_FALSE(report.commit("x").ok());
    ReportFile full;
    ASSERT_TRUE(full.reserve("/dev/full").ok());
    const auto written = full.commit("x");
    ASSERT_FALSE(written.ok());
    EXPECT_THAT(written.error(), testing::HasSubstr("No space left"));
}

TEST_F(ReportFiles, HaveRoomOnADiskThatIsFullByNow) {
    if (::mount("none", folder.c_str(), "tmpfs", 0, "size=1m") != 0) {
        GTEST_SKIP() << "only root may mount a small file system";
    }
    {
        ReportFile report;
        ASSERT_TRUE(report.reserve(file).ok());
        std::ofstream other(folder + "/other", std::ios::binary);
        const std::string block(4096, 'x');
        while (other.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
        }
        const std::string text(100000, 'r');
        const auto written = report.commit(text);
        EXPECT_TRUE(written.ok()) << written.error();
        EXPECT_EQ(content(file), text);
    }
    EXPECT_EQ(::umount(folder.c_str()), 0);
}

}  // namespace
}  // namespace zoned::recording
