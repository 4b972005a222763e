// WorkerPool: a fixed set of threads that run one batch of independent tasks at a time.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
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
    /// returns when all are done. Tasks must not throw and must not call run() themselves.
    void run(std::size_t count, const std::function<void(std::size_t)>& task);

    [[nodiscard]] unsigned threads() const { return static_cast<unsigned>(workers_.size()) + 1; }

    /// CPU time that the pool's own threads have used so far, ns (the caller's time is the caller's
    /// business).
    [[nodiscard]] std::uint64_t cpu_ns() const { return cpu_ns_.load(std::memory_order_relaxed); }

  private:
    void work_loop();
    void take_tasks();

    std::vector<std::thread> workers_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::condition_variable done_;
    const std::function<void(std::size_t)>* task_ = nullptr;
    std::size_t count_ = 0;
    std::atomic<std::size_t> next_{0};
    std::size_t busy_ = 0;  // workers that have not finished the current batch
    std::uint64_t batch_ = 0;
    bool stop_ = false;
    std::atomic<std::uint64_t> cpu_ns_{0};
};

}  // namespace zoned::compute
