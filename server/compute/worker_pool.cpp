#include "server/compute/worker_pool.h"

#include "shared/core/assert.h"

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
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
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
    {
        const std::lock_guard lock(mutex_);
        task_ = &task;
        count_ = count;
        next_.store(0, std::memory_order_relaxed);
        busy_ = workers_.size();
        ++batch_;
    }
    wake_.notify_all();
    take_tasks();
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
    task_ = nullptr;
}

void WorkerPool::take_tasks() {
    for (;;) {
        const std::size_t i = next_.fetch_add(1, std::memory_order_relaxed);
        if (i >= count_) {
            return;
        }
        (*task_)(i);
    }
}

void WorkerPool::work_loop() {
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return stop_ || batch_ != seen; });
        if (stop_) {
            return;
        }
        seen = batch_;
        lock.unlock();
        const std::uint64_t begin = thread_cpu_ns();
        take_tasks();
        cpu_ns_.fetch_add(thread_cpu_ns() - begin, std::memory_order_relaxed);
        lock.lock();
        if (--busy_ == 0) {
            done_.notify_one();
        }
    }
}

}  // namespace zoned::compute
