// ProcessCopy: work on the state of one moment while the ticks go on, done by a copy of the
// process.
#pragma once

#include "shared/core/histogram.h"

#include <sys/types.h>

#include <functional>
#include <string>

namespace zoned::app {

/// The copy (fork) shares its memory with the server as long as neither writes to it. (Redis saves
/// its data so: "Redis persistence", RDB.) It has the calling thread alone, so its work must touch
/// nothing that another thread might have locked but for memory, which fork(2) of glibc keeps
/// whole. One at a time. Not thread-safe.
class ProcessCopy {
  public:
    enum class CopyEnd {
        kNothing,  ///< it works, or there is none
        kDone,
        kFailed
    };

    /// Returns an empty text where all went well, otherwise the reason, which goes to stderr.
    using Work = std::function<std::string()>;

    ProcessCopy() = default;
    ProcessCopy(const ProcessCopy&) = delete;
    ProcessCopy& operator=(const ProcessCopy&) = delete;
    ~ProcessCopy();  ///< as stop()

    /// Empty text: it works; otherwise why there is no copy. None may be at work.
    std::string start(const Work& work);

    /// How the copy ended, said once.
    CopyEnd look();

    void stop();

    [[nodiscard]] bool works() const { return copy_ != 0; }

    /// How long the caller waited for each copy, ms.
    [[nodiscard]] const core::Histogram& pauses_ms() const { return pauses_ms_; }

  private:
    pid_t copy_ = 0;  // 0: none
    core::Histogram pauses_ms_;
};

}  // namespace zoned::app
