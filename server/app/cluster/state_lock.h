// StateLock: one process uses a state folder at a time, and is known by it again.
#pragma once

#include <string>

namespace zoned::app {

/// Held until it is destroyed, or the process dies in whatever way.
class StateLock {
  public:
    /// Where another process uses the folder it waits until that one has ended, with `waits`.
    /// Throws std::runtime_error where it does not wait, or the folder cannot be written.
    StateLock(const std::string& folder, bool waits);
    ~StateLock();
    StateLock(const StateLock&) = delete;
    StateLock& operator=(const StateLock&) = delete;

    /// 16 random bytes that stay in the folder: a process that has the lock and finds an entry of
    /// this instance knows that the process that wrote it is dead.
    [[nodiscard]] const std::string& instance() const { return instance_; }

  private:
    int file_ = -1;
    std::string instance_;
};

}  // namespace zoned::app
