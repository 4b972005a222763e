// Latest: the newest value that a thread has published, for readers on other threads.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace zoned::mailbox {

/// Values are immutable once published. The lock is held for the swap of a pointer only.
template <class T>
class Latest {
  public:
    void publish(std::shared_ptr<const T> value) {
        const std::lock_guard lock(mutex_);
        value_.swap(value);
    }

    /// Null before the first.
    [[nodiscard]] std::shared_ptr<const T> get() const {
        const std::lock_guard lock(mutex_);
        return value_;
    }

  private:
    mutable std::mutex mutex_;
    std::shared_ptr<const T> value_;
};

}  // namespace zoned::mailbox
