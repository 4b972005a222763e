// WorkerPool: a fixed set of threads that run one batch of independent tasks at a time; idle
// threads help within the tasks.
#pragma once

#include "server/compute/team.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace zoned::compute {

/// `threads` counts the caller: 1 means that everything runs on the calling thread and no thread is
/// made.
class WorkerPool {
  public:
    explicit WorkerPool(unsigned threads);
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Calls task(i) once for each i in [0, count), in any order, on any thread of the pool;
    /// returns when all are done. Tasks must not throw and must not call run() themselves; they may
    /// lead a Team.
    void run(std::size_t count, const std::function<void(std::size_t)>& task);

    [[nodiscard]] unsigned threads() const { return static_cast<unsigned>(workers_.size()) + 1; }

    /// CPU time that the pool's own threads have used so far, ns; the caller's time is not in it.
    [[nodiscard]] std::uint64_t cpu_ns() const { return cpu_ns_.load(std::memory_order_relaxed); }

  private:
    friend class Team;

    static constexpr std::size_t kPlaces = 64;
    static constexpr std::size_t kNoPlace = kPlaces;

    /// Where a team asks for helpers. It may go only when nobody visits it any more.
    struct alignas(64) QueuePlace {
        std::atomic<Team*> team{nullptr};
        std::atomic<std::uint32_t> visitors{0};
    };

    /// Puts a team on the board and calls the idle; kNoPlace when the board is full.
    std::size_t post(Team& team);
    /// Takes it off and waits until all helpers have left.
    void withdraw(std::size_t place);

    void work_loop();
    /// Looks at all places; true when there was something to do.
    bool help_all();
    bool visit(QueuePlace& place);
    void ring();

    std::vector<std::thread> workers_;
    std::array<QueuePlace, kPlaces> board_;
    /// Counts offers of work. An idle thread that finds nothing to do waits for the next offer.
    alignas(64) std::atomic<std::uint32_t> bell_{0};
    std::atomic<bool> stop_{false};
    std::atomic<std::uint64_t> cpu_ns_{0};
    Team batch_;
};

}  // namespace zoned::compute
