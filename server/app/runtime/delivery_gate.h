// DeliveryGate: keeps the tick loop from running away from the network thread: so many ticks'
// output may wait, then the next tick does.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>

namespace zoned::app {

/// Nothing is dropped and memory stays bounded: where the network cannot keep up, the loop falls
/// behind, and leaves out ticks as it does where the world takes too long. Thread-safe.
class DeliveryGate {
  public:
    /// A second's worth of most worlds.
    static constexpr std::size_t kMostWaiting = 32;

    explicit DeliveryGate(std::size_t most = kMostWaiting) : most_(most) {}

    /// One more output waits. Returns when there was room for it, or the gate is open for good.
    void enter() {
        std::unique_lock lock(mutex_);
        if (waiting_ >= most_ && !open_) {
            ++held_;
            left_.wait(lock, [this] { return waiting_ < most_ || open_; });
        }
        ++waiting_;
    }

    /// One output was delivered.
    void leave() {
        {
            const std::lock_guard lock(mutex_);
            --waiting_;
        }
        left_.notify_one();
    }

    /// Nobody waits any more: the network thread is about to wait for the loop.
    void open() {
        {
            const std::lock_guard lock(mutex_);
            open_ = true;
        }
        left_.notify_all();
    }

    /// How often somebody had to wait.
    [[nodiscard]] std::uint64_t held() const {
        const std::lock_guard lock(mutex_);
        return held_;
    }

  private:
    std::size_t most_;
    mutable std::mutex mutex_;
    std::condition_variable left_;
    std::size_t waiting_ = 0;
    std::uint64_t held_ = 0;
    bool open_ = false;
};

}  // namespace zoned::app
