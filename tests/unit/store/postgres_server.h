// PostgresServer: a PostgreSQL server of a test's own, from Debian's package, in a temporary
// folder.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace zoned::store::test {

class PostgresServer {
  public:
    /// Null where the package is not installed. The first call starts it; it ends with the process.
    static PostgresServer* get();

    ~PostgresServer();
    PostgresServer(const PostgresServer&) = delete;
    PostgresServer& operator=(const PostgresServer&) = delete;

    /// Makes an empty database and returns its URL.
    std::string make_database(const std::string& options = "");

    /// Ends at once, connections and all; what was committed is in its log.
    void stop();
    void start();

    /// Holds its socket, and is for sockets of tests too.
    [[nodiscard]] const std::string& folder() const { return folder_; }

  private:
    PostgresServer() = default;

    /// As a user that PostgreSQL accepts: it refuses root.
    [[nodiscard]] pid_t spawn(const std::vector<std::string>& command) const;

    std::string programs_;
    std::string folder_;
    pid_t server_ = 0;
    int databases_ = 0;
};

}  // namespace zoned::store::test
