// ServerProcess: the server itself under the load generator, both as processes of their own.
#pragma once

#include "tests/integration/process/child.h"

#include <memory>
#include <string>

namespace zoned::bench {

/// CPU time of a process so far, s.
struct ProcessCpu {
    double all_s = 0.0;     ///< by the scheduler, ns exact
    double user_s = 0.0;    ///< in steps of 10 ms
    double system_s = 0.0;  ///< the same
};

/// A number that stands behind `"name": ` in JSON; NaN: none does.
double number_in_json(const std::string& json, const std::string& name);

/// Starts `zoned serve` with a config of this text; stopped, and its folder removed, at the end.
class ServerProcess {
  public:
    /// Throws std::runtime_error with the server's own words where it does not start.
    explicit ServerProcess(const std::string& config);
    ~ServerProcess();
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    [[nodiscard]] int port() const { return port_; }

    [[nodiscard]] ProcessCpu cpu() const;

    /// Stops the server, and returns its report. Throws where it fails.
    std::string stop();

  private:
    std::string base_;  ///< beginning of its files' paths
    std::unique_ptr<testing_process::Child> server_;
    int port_ = -1;
};

}  // namespace zoned::bench
