// ShellChild: commands of a page in a shell of their own, with a limit on their time and all that
// they print.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace zoned::pages {

struct ShellResult {
    int exit_code = 0;  ///< 128 + signal where one ended it
    bool late = false;  ///< was ended because its time was over
    std::string printed;
};

/// Its process group dies with it.
class ShellChild {
  public:
    /// Starts `bash -c script` in `folder`; both outputs go to the file `log`. Throws
    /// std::runtime_error when that cannot be done.
    ShellChild(const std::string& script,
               const std::filesystem::path& folder,
               std::filesystem::path log);
    ~ShellChild();
    ShellChild(const ShellChild&) = delete;
    ShellChild& operator=(const ShellChild&) = delete;

    /// Waits for its end; past the limit it is killed.
    ShellResult wait(double seconds);
    /// Waits until it has printed `text`; false when it ends or the time is over before.
    bool wait_for(const std::string& text, double seconds);
    /// Asks it to end (SIGTERM) and waits.
    ShellResult stop(double seconds);

    [[nodiscard]] std::string printed() const;

  private:
    bool poll();

    std::filesystem::path log_;
    pid_t pid_ = -1;
    bool ended_ = false;
    int status_ = 0;
};

}  // namespace zoned::pages
