// Directory: which server has which world of the realm, as the board says.
#pragma once

#include "server/cluster/board.h"
#include "proto/cluster.pb.h"

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace zoned::cluster {

struct ListedWorld {
    proto::cluster::WorldEntry entry;
    std::uint64_t revision = 0;
    double unchanged_s = 0.0;  ///< since this directory saw another revision

    /// A server has it, and has renewed its lease.
    [[nodiscard]] bool alive() const {
        return !entry.instance().empty() && unchanged_s <= 1e-3 * entry.lease_ms();
    }

    /// Players can be sent there.
    [[nodiscard]] bool open() const {
        return alive() && entry.tcp_port() != 0 && !entry.draining();
    }
};

/// list() and look() wait for the board, on one thread; the rest is for any thread and does not.
/// Watches of boards can fall silent, so the board is read again and again.
class Directory {
  public:
    explicit Directory(Board& board) : board_(board) {}

    /// Finds all worlds; to be called now and then. `now_s` of a monotonic clock. Empty: it was
    /// read.
    std::string list(double now_s);
    /// Reads the worlds that are known, those of know() among them; about once a second. It asks
    /// less of the board than list(), and works while NATS servers choose a leader.
    std::string look(double now_s);
    void know(const std::string& world);

    [[nodiscard]] std::optional<ListedWorld> find(const std::string& world, double now_s) const;
    [[nodiscard]] std::vector<ListedWorld> all(double now_s) const;

  private:
    struct KnownWorld {
        proto::cluster::WorldEntry entry;
        std::uint64_t revision = 0;
        double changed_s = 0.0;
    };

    void take(const std::string& world, const BoardEntry& entry, double now_s);

    Board& board_;
    mutable std::mutex mutex_;
    std::map<std::string, KnownWorld> seen_;
};

}  // namespace zoned::cluster
