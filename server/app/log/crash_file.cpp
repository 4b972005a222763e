#include "server/app/log/crash_file.h"

#include "server/app/log/current_zone.h"
#include "server/recording/recorder.h"
#include "shared/core/signal_stack.h"

#include <execinfo.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <filesystem>

namespace zoned::app {

namespace {

constexpr int kMostFrames = 64;
/// The process lives on so long at most for the inputs of its last tick to come to disk.
constexpr int kMostWait_ms = 200;
constexpr std::array kFatal{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

/// Written before a signal can come, read by the handler alone.
struct CrashState {
    std::array<char, 3000> folder{};
    std::array<char, 300> exception{};  ///< what a std::terminate was about
};

CrashState& crash_state() {
    static CrashState state;
    return state;
}

/// Text in a fixed buffer, without memory or locale.
class SafeText {
  public:
    SafeText& add(const char* text) {
        for (; *text != '\0' && length_ + 1 < text_.size(); ++text) {
            text_[length_++] = *text;
        }
        return *this;
    }

    SafeText& add(std::string_view text) {
        for (const char c : text) {
            if (length_ + 1 < text_.size()) {
                text_[length_++] = c;
            }
        }
        return *this;
    }

    SafeText& add(std::uint64_t number, unsigned base = 10) {
        std::array<char, 24> digits{};
        std::size_t at = digits.size() - 1;
        do {
            digits[--at] = "0123456789abcdef"[number % base];
            number /= base;
        } while (number > 0);
        return add(digits.data() + at);
    }

    [[nodiscard]] const char* text() {
        text_[length_] = '\0';
        return text_.data();
    }

    void write_to(int fd) {
        std::size_t done = 0;
        while (done < length_) {
            const ssize_t wrote = ::write(fd, text_.data() + done, length_ - done);
            if (wrote <= 0) {
                return;
            }
            done += static_cast<std::size_t>(wrote);
        }
        length_ = 0;
    }

  private:
    std::array<char, 4096> text_{};
    std::size_t length_ = 0;
};

const char* signal_name(int number) {
    switch (number) {
        case SIGSEGV:
            return "SIGSEGV (an access to no memory)";
        case SIGBUS:
            return "SIGBUS (an access to no memory)";
        case SIGFPE:
            return "SIGFPE (arithmetic)";
        case SIGILL:
            return "SIGILL (an instruction that the processor lacks)";
        default:
            return "SIGABRT (abort)";
    }
}

void write_place(SafeText& out) {
    const zone::ZoneState* zone = current_zone;
    if (zone == nullptr) {
        out.add("place: outside of any zone's tick\n");
        return;
    }
    out.add("place: zone ")
        .add(zone->settings.id.value)
        .add(", tick ")
        .add(static_cast<std::uint64_t>(zone->now))
        .add(", pass ")
        .add(zone->running ? zone::pass_name(*zone->running) : std::string_view("none"))
        .add("\n");
}

void write_crash(int number, const siginfo_t* info, int fd) {
    const CrashState& state = crash_state();
    SafeText out;
    out.add("zoned " ZONED_VERSION ", built for " ZONED_TARGET_NAME "\nsignal: ")
        .add(signal_name(number))
        .add("\n");
    if (number != SIGABRT) {
        out.add("address: 0x").add(reinterpret_cast<std::uintptr_t>(info->si_addr), 16).add("\n");
    }
    out.add("time: ").add(static_cast<std::uint64_t>(std::time(nullptr))).add(" s (Unix)\n");
    if (state.exception[0] != '\0') {
        out.add("exception: ").add(state.exception.data()).add("\n");
    }
    write_place(out);
    out.add("thread: ").add(static_cast<std::uint64_t>(::gettid())).add("\nstack:\n");
    out.write_to(fd);
    std::array<void*, kMostFrames> frames{};
    const int count = ::backtrace(frames.data(), kMostFrames);
    ::backtrace_symbols_fd(frames.data(), count, fd);
}

void on_fatal(int number, siginfo_t* info, void*) {
    // A second crash, in here or in another thread, ends the process at once.
    for (const int fatal : kFatal) {
        std::signal(fatal, SIG_DFL);
    }
    SafeText path;
    path.add(crash_state().folder.data())
        .add("/crash-")
        .add(static_cast<std::uint64_t>(std::time(nullptr)))
        .add("-")
        .add(static_cast<std::uint64_t>(::getpid()))
        .add(".txt");
    const int fd = ::open(path.text(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd >= 0) {
        write_crash(number, info, fd);
        ::fsync(fd);
        ::close(fd);
    }
    SafeText line;
    line.add("zoned: ")
        .add(signal_name(number))
        .add(fd >= 0 ? "; the stack is in " : "; the stack could not be written to ")
        .add(path.text())
        .add("\n");
    line.write_to(STDERR_FILENO);
    recording::await_written_inputs(kMostWait_ms);
    ::raise(number);
}

/// Keeps what the exception says; std::abort then comes to the handler.
[[noreturn]] void on_terminate() {
    std::array<char, 300>& text = crash_state().exception;
    if (const std::exception_ptr current = std::current_exception()) {
        try {
            std::rethrow_exception(current);
        } catch (const std::exception& error) {
            std::strncpy(text.data(), error.what(), text.size() - 1);
        } catch (...) {
            std::strncpy(text.data(), "no std::exception", text.size() - 1);
        }
    }
    std::abort();
}

}  // namespace

void install_crash_file(const std::string& folder) {
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    const std::string whole = std::filesystem::absolute(folder, ignored).string();
    CrashState& state = crash_state();
    std::strncpy(state.folder.data(), whole.c_str(), state.folder.size() - 1);
    // The first call loads the library that walks the stack, which takes memory.
    std::array<void*, 4> frames{};
    (void)::backtrace(frames.data(), static_cast<int>(frames.size()));
    core::add_signal_stack();

    struct sigaction action {};

    action.sa_sigaction = on_fatal;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    for (const int number : kFatal) {
        ::sigaction(number, &action, nullptr);
    }
    std::set_terminate(on_terminate);
}

std::string newest_crash_file(const std::string& folder) {
    std::error_code error;
    std::string newest;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        // Names hold ten digits of seconds: they sort by time.
        if (name.starts_with("crash-") && name.ends_with(".txt") &&
            entry.path().string() > newest) {
            newest = entry.path().string();
        }
    }
    return newest;
}

}  // namespace zoned::app
