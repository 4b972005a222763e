// TaskThread: one thread that carries out tasks in the order of their times.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace zoned::cluster {

class TaskThread {
  public:
    using Task = std::function<void()>;

    TaskThread() : thread_([this] { run(); }) {}

    ~TaskThread() { stop(); }

    TaskThread(const TaskThread&) = delete;
    TaskThread& operator=(const TaskThread&) = delete;

    /// From any thread. Tasks of one time run in the order of their posts; after stop() they are
    /// dropped.
    void post(Task task, double delay_s = 0.0) {
        const auto due = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(delay_s));
        const std::lock_guard lock(mutex_);
        if (!stopping_) {
            tasks_.emplace(std::pair(due, ++posted_), std::move(task));
            wake_.notify_one();
        }
    }

    /// The running task is finished, the others are dropped. Not from a task.
    void stop() {
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
            wake_.notify_one();
        }
        if (thread_.joinable()) {
            thread_.join();
        }
        tasks_.clear();
    }

  private:
    using Clock = std::chrono::steady_clock;

    void run() {
        std::unique_lock lock(mutex_);
        while (!stopping_) {
            if (tasks_.empty()) {
                wake_.wait(lock);
            } else if (const auto due = tasks_.begin()->first.first; due > Clock::now()) {
                wake_.wait_until(lock, due);
            } else {
                const Task task = std::move(tasks_.begin()->second);
                tasks_.erase(tasks_.begin());
                lock.unlock();
                task();
                lock.lock();
            }
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    std::map<std::pair<Clock::time_point, std::uint64_t>, Task> tasks_;
    std::uint64_t posted_ = 0;
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace zoned::cluster
