#include "shared/core/files/replace_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace zoned::core {
namespace {

namespace fs = std::filesystem;

class ReplacedFile : public testing::Test {
  protected:
    ReplacedFile() { fs::create_directories(folder); }

    ~ReplacedFile() override { fs::remove_all(folder); }

    static std::string content(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    const std::string folder = testing::TempDir() + "zoned_replaced_" +
                               testing::UnitTest::GetInstance()->current_test_info()->name();
    const std::string path = folder + "/file";
};

TEST_F(ReplacedFile, HasTheNewBytesAndTheMode) {
    ASSERT_TRUE(replace_file(path, "first", 0600).ok());
    const std::string bytes(3'000'000, '\0');
    ASSERT_TRUE(replace_file(path, bytes, 0600).ok());
    EXPECT_EQ(content(path), bytes);

    struct stat status {};

    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "nothing else is left";
}

TEST_F(ReplacedFile, StaysAsItWasWhereTheDiskIsFull) {
    ASSERT_TRUE(replace_file(path, "old", 0600).ok());
    // A file that may not grow ends a write in the middle, as a full disk does.
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1000, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &small);
    const auto written = replace_file(path, std::string(2000, 'x'), 0600);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error(), "cannot write '" + path + "': File too large");
    EXPECT_EQ(content(path), "old");
    EXPECT_FALSE(fs::exists(path + ".part"));
}

TEST_F(ReplacedFile, IsNotWrittenThroughALinkThatSomebodyLaid) {
    std::ofstream(folder + "/victim") << "precious";
    fs::create_symlink("victim", path + ".part");
    ASSERT_TRUE(replace_file(path, "new", 0600).ok());
    EXPECT_EQ(content(folder + "/victim"), "precious");
    EXPECT_EQ(content(path), "new");
}

TEST_F(ReplacedFile, NamesTheFileThatCannotBe) {
    const auto written = replace_file(folder + "/none/file", "x", 0600);
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error(),
              "cannot write '" + folder + "/none/file': No such file or directory");
}

}  // namespace
}  // namespace zoned::core
