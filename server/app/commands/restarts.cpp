#include "server/app/commands/restarts.h"

#include "server/app/commands/commands.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>

namespace zoned::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostDeaths = 10;
constexpr auto kWithin = std::chrono::minutes(1);

volatile std::sig_atomic_t child_of_restarts = 0;
volatile std::sig_atomic_t asked_to_end = 0;

void pass_on(int signal) {
    if (signal != SIGHUP) {
        asked_to_end = 1;
    }
    if (child_of_restarts > 0) {
        ::kill(static_cast<pid_t>(child_of_restarts), signal);
    }
}

void listen(void (*handler)(int)) {
    struct sigaction action {};

    action.sa_handler = handler;
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
        ::sigaction(signal, &action, nullptr);
    }
}

/// Signals that come between a fork and the note of its number wait.
class HeldSignals {
  public:
    HeldSignals() {
        sigset_t held;
        sigemptyset(&held);
        for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
            sigaddset(&held, signal);
        }
        ::sigprocmask(SIG_BLOCK, &held, &before_);
    }

    HeldSignals(const HeldSignals&) = delete;
    HeldSignals& operator=(const HeldSignals&) = delete;

    ~HeldSignals() { ::sigprocmask(SIG_SETMASK, &before_, nullptr); }

  private:
    sigset_t before_{};
};

/// 0 in the child.
pid_t start_child() {
    const HeldSignals held;
    const pid_t child = ::fork();
    if (child == 0) {
        listen(SIG_DFL);
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    } else {
        child_of_restarts = child;
    }
    return child;
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    child_of_restarts = 0;
    return status;
}

bool died(int status) {
    return WIFSIGNALED(status) || (WIFEXITED(status) && WEXITSTATUS(status) == kFailed);
}

void tell(int status) {
    if (WIFSIGNALED(status)) {
        std::fprintf(stderr,
                     "zoned: the server died of signal %d (%s); it is started again\n",
                     WTERMSIG(status),
                     ::strsignal(WTERMSIG(status)));
    } else {
        std::fprintf(stderr, "zoned: the server failed; it is started again\n");
    }
}

}  // namespace

int restart_when_it_dies(const std::function<int()>& serve) {
    listen(&pass_on);
    std::deque<Clock::time_point> deaths;
    for (;;) {
        const pid_t child = start_child();
        if (child == 0) {
            return serve();
        }
        if (child < 0) {
            std::fprintf(stderr, "zoned: no process can be started: %s\n", std::strerror(errno));
            return kEnvironment;
        }
        const int status = wait_for(child);
        if (!died(status) || asked_to_end != 0) {
            return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
        }
        deaths.push_back(Clock::now());
        while (deaths.front() < deaths.back() - kWithin) {
            deaths.pop_front();
        }
        if (deaths.size() > kMostDeaths) {
            std::fprintf(stderr,
                         "zoned: the server died %zu times within a minute; it is given up\n",
                         deaths.size());
            return kFailed;
        }
        tell(status);
    }
}

}  // namespace zoned::app
