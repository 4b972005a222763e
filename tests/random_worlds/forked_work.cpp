#include "tests/random_worlds/forked_work.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <system_error>
#include <utility>

namespace zoned::random_worlds {

namespace {

/// Comes before the result, and in no message.
constexpr char kMark = '\x01';
/// Of the last words of a process that died.
constexpr std::size_t kMostText = 3000;

[[noreturn]] void fail(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

void write_all(int file, const std::string& text) {
    for (std::size_t at = 0; at < text.size();) {
        const ssize_t size = ::write(file, text.data() + at, text.size() - at);
        if (size < 0 && errno != EINTR) {
            return;  // nobody reads any more
        }
        at += size > 0 ? static_cast<std::size_t>(size) : 0;
    }
}

[[noreturn]] void be_child(const std::function<std::string()>& work, double most_cpu_s, int file) {
    if (most_cpu_s > 0.0) {
        const auto seconds = static_cast<rlim_t>(std::max(1.0, most_cpu_s));
        const rlimit limit{seconds, seconds + 5};
        ::setrlimit(RLIMIT_CPU, &limit);
    }
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::dup2(file, STDERR_FILENO);
    try {
        write_all(file, kMark + work());
    } catch (const std::exception& error) {
        write_all(file, error.what());
        std::_Exit(1);
    }
    std::_Exit(0);
}

}  // namespace

ForkedWork::ForkedWork(const std::function<std::string()>& work, double most_cpu_s) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) {
        fail("pipe");
    }
    std::fflush(nullptr);
    process_ = ::fork();
    if (process_ < 0) {
        fail("fork");
    }
    if (process_ == 0) {
        ::close(ends[0]);
        be_child(work, most_cpu_s, ends[1]);
    }
    ::close(ends[1]);
    file_ = ends[0];
}

ForkedWork::ForkedWork(ForkedWork&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      file_(std::exchange(other.file_, -1)),
      said_(std::move(other.said_)) {
}

ForkedWork::~ForkedWork() {
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
    }
    if (file_ >= 0) {
        ::close(file_);
    }
}

bool ForkedWork::read_some() {
    std::array<char, 4096> buffer{};
    const ssize_t size = ::read(file_, buffer.data(), buffer.size());
    if (size > 0) {
        said_.append(buffer.data(), static_cast<std::size_t>(size));
    }
    return size > 0 || (size < 0 && errno == EINTR);
}

ForkedResult ForkedWork::finish() {
    while (read_some()) {
    }
    int status = 0;
    rusage used{};
    while (::wait4(process_, &status, 0, &used) < 0 && errno == EINTR) {
    }
    process_ = -1;
    ForkedResult result;
    result.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    const std::size_t mark = said_.rfind(kMark);
    result.ended = WIFEXITED(status) && WEXITSTATUS(status) == 0 && mark != std::string::npos;
    result.text = result.ended ? said_.substr(mark + 1)
                               : said_.substr(said_.size() - std::min(said_.size(), kMostText));
    result.cpu_s = static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                   1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    return result;
}

}  // namespace zoned::random_worlds
