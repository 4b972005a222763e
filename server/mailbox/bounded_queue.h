// BoundedQueue: a queue between threads with a fixed capacity; items that do not fit are dropped
// and counted.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

namespace zoned::mailbox {

/// Many producers, one consumer that takes everything at once. The lock is held for a push_back or
/// a swap only.
template <class T>
class BoundedQueue {
  public:
    explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {
        items_.reserve(capacity < 4096 ? capacity : 4096);
    }

    /// False when full: the item is dropped and counted.
    bool push(T item) {
        const std::lock_guard lock(mutex_);
        if (items_.size() >= capacity_) {
            dropped_.fetch_add(1, std::memory_order_relaxed);
            return false;
        }
        items_.push_back(std::move(item));
        return true;
    }

    /// Moves all items into `out` (cleared first), in the order of their arrival.
    void take_all(std::vector<T>& out) {
        out.clear();
        const std::lock_guard lock(mutex_);
        items_.swap(out);
    }

    [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  private:
    std::mutex mutex_;
    std::vector<T> items_;
    std::size_t capacity_;
    std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace zoned::mailbox
