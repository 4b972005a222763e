// Team: threads that work at the short stages of one job together.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace zoned::compute {

class WorkerPool;

/// A pool's tasks are long. Within one there may be stages of some ten microseconds, one after the
/// other, with independent blocks. The thread that runs the task leads: run() hands blocks to the
/// idle threads of the pool, and works at blocks itself. Without a pool, or while all others are
/// busy, the leader does all by itself.
///
/// Any thread may do any block, so a block must not touch data that another block writes. Then the
/// result is the same for any number of threads. The leader takes blocks from the front and the
/// helpers from the back. Where successive stages go through the same data, most of it then stays
/// in the same core's cache.
///
/// Only one thread may lead. All public functions are the leader's.
class Team {
  public:
    Team() = default;
    ~Team();
    Team(const Team&) = delete;
    Team& operator=(const Team&) = delete;

    /// From now on idle threads of the pool help. The pool must outlive the team.
    void join_pool(WorkerPool& pool);

    /// While one of these lives, helpers stay at hand between stages: they wait awake. So it should
    /// live for a chain of stages and not beyond.
    class Shift {
      public:
        explicit Shift(Team& team) : team_(team) { team_.open(); }

        ~Shift() { team_.close(); }

        Shift(const Shift&) = delete;
        Shift& operator=(const Shift&) = delete;

      private:
        Team& team_;
    };

    /// Calls task(begin, end) for consecutive ranges that cover [0, count), each of `grain` (or
    /// more, where there would be too many) but the last one, in any order; returns when all are
    /// done. Tasks must not throw.
    template <class Task>
    void run(std::size_t count, std::size_t grain, Task&& task) {
        if (!open_ || count <= grain) {
            if (count > 0) {
                task(std::size_t{0}, count);
            }
            return;
        }

        struct Ranges {
            std::remove_reference_t<Task>* task;
            std::size_t count, grain;
        } ranges{&task, count, std::max(grain, count / kMostBlocks + 1)};

        run_blocks(
            static_cast<std::uint32_t>((count + ranges.grain - 1) / ranges.grain),
            [](void* context, std::uint32_t block) {
                const auto& r = *static_cast<Ranges*>(context);
                const std::size_t begin = block * r.grain;
                (*r.task)(begin, begin + r.grain < r.count ? begin + r.grain : r.count);
            },
            &ranges);
    }

  private:
    friend class WorkerPool;

    using Call = void (*)(void* context, std::uint32_t block);

    static constexpr std::size_t kMostBlocks = 1U << 16U;

    void open();
    void close();
    void run_blocks(std::uint32_t blocks, Call call, void* context);
    void publish(std::uint32_t blocks, Call call, void* context);

    enum class TeamEnd : std::uint8_t {
        kFront,
        kBack
    };

    /// Does one block of the present stage; false when there is none to take.
    bool work(TeamEnd end);

    [[nodiscard]] bool finished() const { return unfinished_.load(std::memory_order_acquire) == 0; }

    /// A helper's time with the team. True when it did something.
    bool help();

    WorkerPool* pool_ = nullptr;
    std::size_t place_ = 0;  // on the pool's board
    bool open_ = false;      // the leader's view
    /// Helpers wait for further stages. Without, they leave when no block is left.
    std::atomic<bool> more_to_come_{false};
    std::atomic<Call> call_{nullptr};
    std::atomic<void*> context_{nullptr};
    /// Number of the stage, and the range of blocks that nobody has taken yet: see Ticket.
    alignas(64) std::atomic<std::uint64_t> ticket_{0};
    alignas(64) std::atomic<std::uint32_t> unfinished_{0};
};

}  // namespace zoned::compute
