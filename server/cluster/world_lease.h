// WorldLease: the claim of one server to one world, which it must renew.
#pragma once

#include "server/cluster/board.h"
#include "proto/cluster.pb.h"

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace zoned::cluster {

enum class LeaseState : std::uint8_t {
    kWaiting,  ///< another server has the world, or the board is out of reach
    kHeld,
    kLapsed,  ///< not renewed in time: another server may have taken the world
    kLost,    ///< another server has taken it
    kReleased,
};

struct LeaseSettings {
    std::string world;
    std::string instance;  ///< 16 bytes, of a state folder that one process uses at a time
    double lease_s = 12.0;
    /// The life of the world of which the state folder holds a state, as WorldEntry has it; empty:
    /// it holds none.
    std::string life;
    std::string fresh_life;  ///< where the world has to begin anew
};

/// The owner judges by its own monotonic clock: its lease ends `lease_s` after it began to ask for
/// it. Another server takes a world when it has seen no write for longer than that, by its own
/// clock; so no two servers hold a world at a time, however wrong their wall clocks are. claim()
/// and renew() wait for the board and are called by one thread; the rest is for any thread.
class WorldLease {
  public:
    /// `clock` gives seconds of a monotonic clock.
    WorldLease(Board& board, LeaseSettings settings, std::function<double()> clock);

    /// One attempt to get the world, to be repeated a few times a second.
    LeaseState claim();
    /// Changes the entry that others see; renew() writes it.
    void describe(const std::function<void(proto::cluster::WorldEntry&)>& change);
    /// One attempt to renew, to be repeated several times a lease.
    LeaseState renew();
    /// Others may take it at once.
    void release();

    [[nodiscard]] LeaseState state() const;
    /// Held, and its time has not ended by the clock.
    [[nodiscard]] bool valid() const;
    /// Seconds that are left; below 0: since when it lapsed.
    [[nodiscard]] double left_s() const;
    /// Fencing number of the claim; grows with each.
    [[nodiscard]] std::uint64_t epoch() const;
    /// The life of the world from this claim on: that of the settings, unless the board says that a
    /// server had the world since which did not go on from there.
    [[nodiscard]] std::string life() const;
    /// The entry of whoever has the world, as last seen by claim() or renew().
    [[nodiscard]] proto::cluster::WorldEntry owner() const;
    /// Why the last attempt did not reach the board; empty: it did.
    [[nodiscard]] std::string trouble() const;

    /// Beyond the lease of another server before its world is taken, share of it.
    static constexpr double kMargin = 0.1;

  private:
    [[nodiscard]] std::string key() const { return "world." + settings_.world; }

    LeaseState take(std::uint64_t revision);
    LeaseState look_again();
    void held_since(double begun_s, std::uint64_t revision);
    void note_trouble(const std::string& text);
    [[nodiscard]] std::string next_entry(bool fresh);

    Board& board_;
    LeaseSettings settings_;
    std::function<double()> clock_;
    mutable std::mutex mutex_;
    LeaseState state_ = LeaseState::kWaiting;
    proto::cluster::WorldEntry entry_;  // of this server
    proto::cluster::WorldEntry owner_;
    std::uint64_t revision_ = 0;  // of the last own write, or of what claim() saw
    std::uint64_t epoch_ = 0;
    double ends_s_ = 0.0;
    double seen_s_ = -1.0;  // when another server's entry had a new revision
    std::string trouble_;
};

}  // namespace zoned::cluster
