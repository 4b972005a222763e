// ForkedWork: a function that runs in a process of its own, so that its crash is a result like any.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>

namespace zoned::random_worlds {

/// The end of the process.
struct ForkedResult {
    std::string text;    ///< what the function returned, or the last words on standard error
    int signal = 0;      ///< that ended it; 0: none did
    bool ended = false;  ///< the function returned
    double cpu_s = 0.0;  ///< with that of the processes that it waited for
};

/// Only for processes with one thread: the others' locks would stay locked.
class ForkedWork {
  public:
    /// SIGXCPU ends it after `most_cpu_s`; 0: nothing does. Throws std::system_error.
    ForkedWork(const std::function<std::string()>& work, double most_cpu_s);
    ForkedWork(const ForkedWork&) = delete;
    ForkedWork& operator=(const ForkedWork&) = delete;
    ForkedWork(ForkedWork&& other) noexcept;
    ForkedWork& operator=(ForkedWork&&) = delete;
    /// Kills it where it still runs.
    ~ForkedWork();

    /// Can be read when the work is over, or is saying a lot.
    [[nodiscard]] int file() const { return file_; }

    /// Reads what there is; false: that was all.
    bool read_some();
    /// Waits for its end.
    ForkedResult finish();

  private:
    pid_t process_ = -1;
    int file_ = -1;
    std::string said_;
};

}  // namespace zoned::random_worlds
