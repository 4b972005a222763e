// zoned-pages: takes the steps of pages as a reader would, and says what went wrong, was cut short
// or left out.
#include "tests/pages/play.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <system_error>

namespace {

namespace fs = std::filesystem;
using namespace zoned::pages;

constexpr const char* kUsage =
    "usage: zoned-pages SOURCE BUILD PAGE...\n"
    "Runs every command and example of the pages (paths from the root of the repository SOURCE) in "
    "a copy of it, in\n"
    "BUILD/pages or, where that is in use, in a folder of its own, with the programs of BUILD. "
    "Exit code: 0 all went as\n"
    "the pages say, 1 something did not, 2 bad usage.\n";

void tell(const Page& page, const char* what, const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) {
        std::printf("%s:%d: %s%s\n", page.path.c_str(), finding.line, what, finding.text.c_str());
    }
}

bool good(const fs::path& source,
          const fs::path& build,
          const fs::path& folder,
          const std::string& path) {
    std::ifstream in(source / path, std::ios::binary);
    if (!in) {
        std::printf("%s: no such page\n", path.c_str());
        return false;
    }
    const Page page = read_page(
        path, std::string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()));
    const Stage stage = set_stage(source, build, folder);
    const std::vector<Finding> wrong = wrong_mentions(page, stage);
    const Played played = play(page, stage);
    tell(page, "", page.defects);
    tell(page, "", wrong);
    tell(page, "", played.failures);
    tell(page, "not run: ", played.skipped);
    tell(page, "shortened: ", played.shortened);
    std::printf("%s: %d blocks run\n", page.path.c_str(), played.commands);
    return page.defects.empty() && wrong.empty() && played.failures.empty();
}

/// Where pages are played. It stays, for the next ones: most of a copy is as it was. Who finds it
/// in use, as a page does that plays a page, gets one for itself.
class StageFolder {
  public:
    explicit StageFolder(const fs::path& build)
        : lock_(::open((build / "pages.lock").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644)) {
        if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) == 0) {
            path_ = build / "pages";
            return;
        }
        // As mkdtemp(3) wants it.
        std::string folder = (fs::temp_directory_path() / "zoned-pages-XXXXXX").string();
        if (::mkdtemp(folder.data()) == nullptr) {
            throw std::runtime_error("cannot make a folder in " +
                                     fs::temp_directory_path().string());
        }
        path_ = folder;
        goes_ = true;
    }

    StageFolder(const StageFolder&) = delete;
    StageFolder& operator=(const StageFolder&) = delete;

    ~StageFolder() {
        std::error_code left;
        if (goes_) {
            fs::remove_all(path_, left);
        }
        ::close(lock_);
    }

    [[nodiscard]] const fs::path& path() const { return path_; }

  private:
    int lock_;
    fs::path path_;
    bool goes_ = false;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fputs(kUsage, stderr);
        return 2;
    }
    bool all = true;
    try {
        const StageFolder folder(argv[2]);
        for (int i = 3; i < argc; ++i) {
            all = good(argv[1], argv[2], folder.path(), argv[i]) && all;
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-pages: %s\n", error.what());
        return 1;
    }
    return all ? 0 : 1;
}
