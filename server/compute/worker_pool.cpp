#include "server/compute/worker_pool.h"

#include "server/compute/spin_wait.h"
#include "shared/core/assert.h"
#include "shared/core/signal_stack.h"

#include <ctime>

namespace zoned::compute {

namespace {

std::uint64_t thread_cpu_ns() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<std::uint64_t>(t.tv_sec) * 1000000000ull +
           static_cast<std::uint64_t>(t.tv_nsec);
}

}  // namespace

WorkerPool::WorkerPool(unsigned threads) {
    ZONED_ASSERT(threads >= 1, "the caller is a thread as well");
    for (unsigned i = 1; i < threads; ++i) {
        workers_.emplace_back([this] { work_loop(); });
    }
}

WorkerPool::~WorkerPool() {
    stop_.store(true);
    ring();
    for (std::thread& worker : workers_) {
        worker.join();
    }
}

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (workers_.empty() || count <= 1) {
        for (std::size_t i = 0; i < count; ++i) {
            task(i);
        }
        return;
    }
    ZONED_ASSERT(count < Team::kMostBlocks, "a batch has few tasks");
    using Task = std::function<void(std::size_t)>;
    batch_.publish(
        static_cast<std::uint32_t>(count),
        [](void* context, std::uint32_t i) { (*static_cast<const Task*>(context))(i); },
        const_cast<Task*>(&task));
    const std::size_t place = post(batch_);
    while (batch_.work(Team::TeamEnd::kFront)) {
    }
    // The others are still at their tasks: within those there may be something to do.
    for (std::uint32_t heard = bell_.load(); !batch_.finished(); heard = bell_.load()) {
        if (!help_all() && !batch_.finished()) {
            bell_.wait(heard);
        }
    }
    withdraw(place);
}

std::size_t WorkerPool::post(Team& team) {
    for (std::size_t i = 0; i < kPlaces; ++i) {
        Team* nobody = nullptr;
        if (board_[i].team.compare_exchange_strong(nobody, &team)) {
            ring();
            return i;
        }
    }
    return kNoPlace;
}

void WorkerPool::withdraw(std::size_t place) {
    if (place == kNoPlace) {
        return;
    }
    board_[place].team.store(nullptr);
    Spin spin;
    while (board_[place].visitors.load() != 0) {
        spin.wait();
    }
}

void WorkerPool::ring() {
    bell_.fetch_add(1);
    bell_.notify_all();
}

bool WorkerPool::visit(QueuePlace& place) {
    if (place.team.load(std::memory_order_relaxed) == nullptr) {
        return false;
    }
    place.visitors.fetch_add(1);
    bool worked = false;
    // Read again: a thread that withdraws either sees the visitor or is seen by it.
    if (Team* const team = place.team.load(); team != nullptr) {
        const std::uint64_t begin = thread_cpu_ns();
        worked = team->help();
        cpu_ns_.fetch_add(thread_cpu_ns() - begin, std::memory_order_relaxed);
    }
    place.visitors.fetch_sub(1);
    return worked;
}

bool WorkerPool::help_all() {
    bool worked = false;
    for (QueuePlace& place : board_) {
        worked = visit(place) || worked;
    }
    return worked;
}

void WorkerPool::work_loop() {
    core::add_signal_stack();
    for (std::uint32_t heard = bell_.load(); !stop_.load(); heard = bell_.load()) {
        if (help_all()) {
            ring();  // wakes the threads that wait for the end of a batch
        } else if (!stop_.load()) {
            bell_.wait(heard);
        }
    }
}

}  // namespace zoned::compute
