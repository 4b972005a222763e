// SlowPath: a TCP proxy on this machine that delays what passes, as a long path with losses does.
#pragma once

#include <memory>

namespace zoned::testing_browser {

class SlowPath {
  public:
    struct PathSettings {
        double one_way_s = 0.0;
        double loss = 0.0;  ///< share of what passes that comes later by `resend_s`
        /// TCP hands nothing on before it has sent again what was lost. Linux waits so long at
        /// least.
        double resend_s = 0.2;
    };

    /// To a port of this machine.
    SlowPath(int port, PathSettings settings);
    ~SlowPath();
    SlowPath(const SlowPath&) = delete;
    SlowPath& operator=(const SlowPath&) = delete;

    [[nodiscard]] int port() const;

  private:
    struct Proxy;
    std::unique_ptr<Proxy> proxy_;
};

}  // namespace zoned::testing_browser
