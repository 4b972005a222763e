// How a snapshot is taken while the ticks go on: by a copy of the process.
#include "server/app/log/log.h"
#include "server/app/recovery/recovery.h"

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

/// The life of the copy. It has this thread alone: nothing that another might have locked is
/// touched, but for memory, which fork(2) of glibc keeps whole.
[[noreturn]] void write_and_die(const std::string& folder,
                                const World& world,
                                const RunLedger& ledger,
                                Tick oldest_wanted) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::setpriority(PRIO_PROCESS, 0, kNiceness);
    // Sockets and locks of the server must not outlive it in here.
    ::close_range(3, ~0U, 0);
    std::vector<std::uint8_t> buffer;
    const std::string wrong = write_snapshot(folder, world, ledger, buffer);
    if (!wrong.empty()) {
        const std::string line = "zoned: a snapshot failed: " + wrong + "\n";
        [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, line.data(), line.size());
        ::_exit(1);
    }
    remove_snapshots_before(folder, oldest_wanted);
    ::_exit(0);
}

}  // namespace

void Recovery::take_snapshot(const World& world, recording::Recorder& recorder) {
    recorder.cut_journal(world.now());
    started_ = world.now();
    const auto begin = std::chrono::steady_clock::now();
    const pid_t copy = ::fork();
    if (copy == 0) {
        write_and_die(folder_, world, ledger_, last_);
    }
    if (copy < 0) {
        ++figures_.failed;
        log_of(LogArea::kServer)
            .error("no snapshot: the process cannot be copied: {}", std::strerror(errno));
        return;
    }
    copy_ = copy;
    figures_.pause_ms.add(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count());
}

void Recovery::look_after_copy(recording::Recorder& recorder) {
    int status = 0;
    if (copy_ == 0 || ::waitpid(copy_, &status, WNOHANG) != copy_) {
        return;
    }
    copy_ = 0;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        ++figures_.failed;
        log_of(LogArea::kServer)
            .error("the snapshot of tick {} failed; the next one is due in {} ticks",
                   started_,
                   every_ticks_);
        return;
    }
    ++figures_.taken;
    before_ = last_;
    last_ = started_;
    // The snapshot before is kept too, with the inputs since: a disk may lie.
    recorder.forget_journal(before_);
}

void Recovery::stop_copy() {
    if (copy_ != 0) {
        ::kill(copy_, SIGKILL);
        ::waitpid(copy_, nullptr, 0);
        copy_ = 0;
    }
}

}  // namespace zoned::app
