// TravelFaults: a server that dies at a named step of a travel, and a journal of who had whom, for
// the checker of travel.
#pragma once

#include "server/config/server_settings.h"

#include <atomic>
#include <cstdint>
#include <string>

namespace zoned::app {

class TravelFaults {
  public:
    /// Throws std::runtime_error when the journal cannot be opened.
    TravelFaults(config::TravelFaultSettings settings, std::string world);
    ~TravelFaults();
    TravelFaults(const TravelFaults&) = delete;
    TravelFaults& operator=(const TravelFaults&) = delete;

    /// Kills the process where the settings say so. From any thread.
    void at(config::TravelStep step);

    /// An avatar of the account begins to be in this world, or has left it. One line: time of the
    /// machine's monotonic clock in ns, "begin" or "end", world, account. From any thread.
    void begins(const std::string& account) { note("begin", account); }

    void ends(const std::string& account) { note("end", account); }

    [[nodiscard]] bool keep_avatar() const { return settings_.keep_avatar; }

    [[nodiscard]] bool lose_records() const { return settings_.lose_records; }

  private:
    void note(const char* what, const std::string& account) const;

    config::TravelFaultSettings settings_;
    std::string world_;
    std::atomic<std::uint32_t> came_{0};
    int journal_ = -1;
};

}  // namespace zoned::app
