#include "server/app/recovery/process_copy.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

namespace zoned::app {

namespace {

constexpr int kNiceness = 10;

[[noreturn]] void work_and_die(const ProcessCopy::Work& work) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::setpriority(PRIO_PROCESS, 0, kNiceness);
    // Sockets and locks of the server must not outlive it in here.
    ::close_range(3, ~0U, 0);
    const std::string wrong = work();
    if (!wrong.empty()) {
        const std::string line = "zoned: " + wrong + "\n";
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
    }
    ::_exit(wrong.empty() ? 0 : 1);
}

}  // namespace

ProcessCopy::~ProcessCopy() {
    stop();
}

std::string ProcessCopy::start(const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    const pid_t copy = ::fork();
    if (copy == 0) {
        work_and_die(work);
    }
    if (copy < 0) {
        return std::string("the process cannot be copied: ") + std::strerror(errno);
    }
    copy_ = copy;
    pauses_ms_.add(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count());
    return {};
}

ProcessCopy::CopyEnd ProcessCopy::look() {
    int status = 0;
    if (copy_ == 0 || ::waitpid(copy_, &status, WNOHANG) != copy_) {
        return CopyEnd::kNothing;
    }
    copy_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? CopyEnd::kDone : CopyEnd::kFailed;
}

void ProcessCopy::stop() {
    if (copy_ != 0) {
        ::kill(copy_, SIGKILL);
        ::waitpid(copy_, nullptr, 0);
        copy_ = 0;
    }
}

}  // namespace zoned::app
