// Process: a server whose wall clock jumps, as where somebody sets it or a time server is wrong.
#include "tests/integration/process/admin_fixture.h"

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

namespace zoned::testing_process {
namespace {

constexpr const char* kVariables[] = {"LD_PRELOAD",
                                      "DONT_FAKE_MONOTONIC",
                                      "FAKETIME_TIMESTAMP_FILE",
                                      "FAKETIME_NO_CACHE"};

/// Debian's libfaketime answers for the system's calendar time; other clocks stay.
class ClockJumps : public Admin {
  protected:
    void SetUp() override {
        for (const auto& folder : std::filesystem::directory_iterator("/usr/lib")) {
            const auto found = folder.path() / "faketime/libfaketimeMT.so.1";
            library_ = std::filesystem::exists(found) ? found.string() : library_;
        }
        ASSERT_FALSE(library_.empty()) << "needs the package faketime";
        jump(0);
    }

    void serve_by_that_clock() {
        const std::string values[] = {library_, "1", file_, "1"};
        for (std::size_t i = 0; i < std::size(kVariables); ++i) {
            ::setenv(kVariables[i], values[i].c_str(), 1);
        }
        serve();
        for (const char* variable : kVariables) {
            ::unsetenv(variable);
        }
    }

    /// To so many hours off.
    void jump(int hours) const {
        std::ofstream(file_ + ".new") << (hours < 0 ? "" : "+") << hours << "h\n";
        std::filesystem::rename(file_ + ".new", file_);
    }

    /// The day so many hours from now, as the log writes it.
    static std::string day_in(int hours) {
        const std::time_t then = std::time(nullptr) + 3600 * static_cast<std::time_t>(hours);
        std::tm parts{};
        ::localtime_r(&then, &parts);
        char text[16];
        return {text, std::strftime(text, sizeof(text), "%Y-%m-%d", &parts)};
    }

    const std::string file_ = scratch_folder() + "/hours";
    std::string library_;
};

TEST_F(ClockJumps, DisturbNobody) {
    ASSERT_NO_FATAL_FAILURE(serve_by_that_clock());
    Child bots("client-sim", play(5, 12));
    ASSERT_TRUE(wait_for_sessions(5)) << bots.errors();
    for (const int hours : {50, -50, 0}) {
        jump(hours);
        const std::string notice = "it is " + std::to_string(hours) + " hours off";
        EXPECT_EQ(ctl({"say", notice}), 0) << complained;
        ASSERT_TRUE(server->wait_for_errors(notice, kPatience));
        const std::string log = server->errors();
        const std::size_t line = log.rfind('\n', log.find(notice)) + 1;
        EXPECT_EQ(log.substr(line, 10), day_in(hours)) << "the clock did not jump";
        EXPECT_EQ(status_of(ask("/readyz")), 200);
        EXPECT_TRUE(wait_for_sessions(5));
    }
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output();
    EXPECT_NE(bots.output().find(" 0 resumes"), std::string::npos) << bots.output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
}

}  // namespace
}  // namespace zoned::testing_process
