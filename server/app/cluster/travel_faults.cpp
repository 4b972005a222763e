#include "server/app/cluster/travel_faults.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <stdexcept>
#include <utility>

namespace zoned::app {

TravelFaults::TravelFaults(config::TravelFaultSettings settings, std::string world)
    : settings_(std::move(settings)),
      world_(std::move(world)) {
    if (!settings_.journal.empty()) {
        journal_ =
            ::open(settings_.journal.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
        if (journal_ < 0) {
            throw std::runtime_error("testing.travel.journal: cannot write " + settings_.journal);
        }
    }
}

TravelFaults::~TravelFaults() {
    if (journal_ >= 0) {
        ::close(journal_);
    }
}

void TravelFaults::at(config::TravelStep step) {
    if (step == settings_.die_at && ++came_ == settings_.die_after) {
        static_cast<void>(::kill(::getpid(), SIGKILL));
    }
}

void TravelFaults::note(const char* what, const std::string& account) const {
    if (journal_ < 0) {
        return;
    }
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    // In one call, so that the line is whole whatever happens to the process.
    const std::string line =
        std::to_string(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()) + " " +
        what + " " + world_ + " " + account + "\n";
    static_cast<void>(::write(journal_, line.data(), line.size()) < 0);
}

}  // namespace zoned::app
