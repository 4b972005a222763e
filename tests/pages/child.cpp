#include "tests/pages/child.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

namespace zoned::pages {

namespace {

using Steady = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::milliseconds(10);

Steady::time_point in_seconds(double seconds) {
    return Steady::now() +
           std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

ShellChild::ShellChild(const std::string& script,
                       const std::filesystem::path& folder,
                       std::filesystem::path log)
    : log_(std::move(log)) {
    const int out = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (out < 0) {
        throw std::runtime_error("cannot write " + log_.string());
    }
    pid_ = ::fork();
    if (pid_ < 0) {
        ::close(out);
        throw std::runtime_error("cannot start a process");
    }
    if (pid_ == 0) {
        ::setpgid(0, 0);
        const int in = ::open("/dev/null", O_RDONLY);
        ::dup2(in, STDIN_FILENO);
        ::dup2(out, STDOUT_FILENO);
        ::dup2(out, STDERR_FILENO);
        if (::chdir(folder.c_str()) == 0) {
            ::execlp("bash", "bash", "-c", script.c_str(), static_cast<char*>(nullptr));
        }
        ::_exit(127);
    }
    ::setpgid(pid_, pid_);
    ::close(out);
}

ShellChild::~ShellChild() {
    ::kill(-pid_, SIGKILL);
    if (!ended_) {
        ::waitpid(pid_, &status_, 0);
    }
}

bool ShellChild::poll() {
    if (!ended_ && ::waitpid(pid_, &status_, WNOHANG) == pid_) {
        ended_ = true;
    }
    return ended_;
}

ShellResult ShellChild::wait(double seconds) {
    const auto end = in_seconds(seconds);
    ShellResult result;
    while (!poll()) {
        if (Steady::now() > end) {
            result.late = true;
            ::kill(-pid_, SIGKILL);
            ::waitpid(pid_, &status_, 0);
            ended_ = true;
            break;
        }
        std::this_thread::sleep_for(kLook);
    }
    result.exit_code = WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
    result.printed = printed();
    return result;
}

bool ShellChild::wait_for(const std::string& text, double seconds) {
    const auto end = in_seconds(seconds);
    while (printed().find(text) == std::string::npos) {
        if (poll() || Steady::now() > end) {
            return printed().find(text) != std::string::npos;
        }
        std::this_thread::sleep_for(kLook);
    }
    return true;
}

ShellResult ShellChild::stop(double seconds) {
    ::kill(-pid_, SIGTERM);
    return wait(seconds);
}

std::string ShellChild::printed() const {
    std::ifstream in(log_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace zoned::pages
