// CuttingProxy: stands between a store and its PostgreSQL server, and cuts the line at a COMMIT.
#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace zoned::store::test {

enum class Cut : int {
    kNone,
    kBeforeCommit,  ///< the server never hears of it
    kAfterCommit,   ///< the server commits, and its answer is lost
};

class CuttingProxy {
  public:
    /// Takes one connection after the other on port 5433 of the server's folder.
    explicit CuttingProxy(const std::string& folder);
    ~CuttingProxy();
    CuttingProxy(const CuttingProxy&) = delete;
    CuttingProxy& operator=(const CuttingProxy&) = delete;

    /// Cuts the next COMMIT; then all goes through again.
    std::atomic<Cut> cut{Cut::kNone};

  private:
    void run();
    void serve(int client);

    std::string server_;
    std::string socket_;
    int listener_ = -1;
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

}  // namespace zoned::store::test
