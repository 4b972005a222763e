#include "tests/integration/process/child.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

namespace zoned::testing_process {

namespace {

constexpr auto kPoll = std::chrono::milliseconds(5);

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

/// Goes with the process.
struct ScratchFolder {
    ScratchFolder() {
        path = "/tmp/zoned-process-XXXXXX";  // as mkdtemp(3) wants it
        if (::mkdtemp(path.data()) == nullptr) {
            throw std::system_error(errno, std::generic_category(), "a folder in /tmp");
        }
    }

    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    ~ScratchFolder() {
        std::error_code left;  // a browser that is still ending may write there
        if (::getpid() == owner) {
            std::filesystem::remove_all(path, left);
        }
    }

    std::string path;
    pid_t owner = ::getpid();
};

}  // namespace

std::string scratch_folder() {
    static const ScratchFolder folder;
    return folder.path;
}

Child::Child(const std::string& program, const std::vector<std::string>& arguments) {
    static std::atomic<int> count{0};
    const std::string base = scratch_folder() + "/" + std::to_string(++count);
    out_file_ = base + ".out";
    err_file_ = base + ".err";
    std::string path = program.starts_with('/') ? program : ZONED_BINARY_DIR "/" + program;
    std::vector<std::string> copies = arguments;
    std::vector<char*> argv{path.data()};
    for (std::string& argument : copies) {
        argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
        const int out = open(out_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        const int err = open(err_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(out, STDOUT_FILENO);
        dup2(err, STDERR_FILENO);
        execv(path.c_str(), argv.data());
        _exit(127);
    }
}

Child::~Child() {
    if (!ended_ && pid_ > 0) {
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }
}

bool Child::wait_for_output(const std::string& text, double seconds) {
    return wait_for_text(&Child::output, text, seconds);
}

bool Child::wait_for_errors(const std::string& text, double seconds) {
    return wait_for_text(&Child::errors, text, seconds);
}

bool Child::wait_for_text(std::string (Child::*stream)() const,
                          const std::string& text,
                          double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
        if ((this->*stream)().find(text) != std::string::npos) {
            return true;
        }
        if (wait(0.0) >= 0) {
            return (this->*stream)().find(text) != std::string::npos;
        }
        std::this_thread::sleep_for(kPoll);
    }
    return false;
}

void Child::signal(int number) const {
    kill(pid_, number);
}

int Child::wait(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!ended_) {
        int status = 0;
        if (waitpid(pid_, &status, WNOHANG) == pid_) {
            ended_ = true;
            code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
            break;
        }
        if (std::chrono::steady_clock::now() >= end) {
            return -1;
        }
        std::this_thread::sleep_for(kPoll);
    }
    return code_;
}

std::string Child::output() const {
    return read_file(out_file_);
}

std::string Child::errors() const {
    return read_file(err_file_);
}

int number_after(const std::string& text, const std::string& key) {
    const std::size_t at = text.find(key);
    return at == std::string::npos ? -1 : std::atoi(text.c_str() + at + key.size());
}

}  // namespace zoned::testing_process
