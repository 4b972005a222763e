// zoned-pages: takes the steps of pages as a reader would, and says what went wrong, was cut short
// or left out.
#include "tests/pages/play.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>

namespace {

namespace fs = std::filesystem;
using namespace zoned::pages;

constexpr const char* kUsage =
    "usage: zoned-pages SOURCE BUILD PAGE...\n"
    "Runs every command and example of the pages (paths from the root of the repository SOURCE) in "
    "a copy of it, with the\n"
    "programs of BUILD. Exit code: 0 all went as the pages say, 1 something did not, 2 bad "
    "usage.\n";

void tell(const Page& page, const char* what, const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) {
        std::printf("%s:%d: %s%s\n", page.path.c_str(), finding.line, what, finding.text.c_str());
    }
}

bool good(const fs::path& source, const fs::path& build, const std::string& path) {
    std::ifstream in(source / path, std::ios::binary);
    if (!in) {
        std::printf("%s: no such page\n", path.c_str());
        return false;
    }
    const Page page = read_page(
        path, std::string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()));
    std::string folder = (fs::temp_directory_path() / "zoned-pages-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) {
        std::printf("cannot make a folder in %s\n", fs::temp_directory_path().c_str());
        return false;
    }
    const Stage stage = set_stage(source, build, folder);
    const std::vector<Finding> wrong = wrong_mentions(page, stage);
    const Played played = play(page, stage);
    fs::remove_all(folder);
    tell(page, "", page.defects);
    tell(page, "", wrong);
    tell(page, "", played.failures);
    tell(page, "not run: ", played.skipped);
    tell(page, "shortened: ", played.shortened);
    std::printf("%s: %d blocks run\n", page.path.c_str(), played.commands);
    return page.defects.empty() && wrong.empty() && played.failures.empty();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fputs(kUsage, stderr);
        return 2;
    }
    bool all = true;
    try {
        for (int i = 3; i < argc; ++i) {
            all = good(argv[1], argv[2], argv[i]) && all;
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-pages: %s\n", error.what());
        return 1;
    }
    return all ? 0 : 1;
}
