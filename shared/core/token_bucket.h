// TokenBucket: a flood limit; so many per second, with a burst, on the caller's clock.
#pragma once

#include <algorithm>

namespace zoned::core {

/// Full at the start. `rate_per_s` > 0, `burst` >= 1.
class TokenBucket {
  public:
    TokenBucket(double rate_per_s, double burst)
        : rate_per_s_(rate_per_s),
          burst_(burst),
          tokens_(burst) {}

    /// Takes one token; false when there is none. Time that runs backwards adds nothing.
    bool take(double now_s) {
        if (started_) {
            tokens_ = std::min(burst_, tokens_ + std::max(0.0, now_s - last_s_) * rate_per_s_);
        }
        started_ = true;
        last_s_ = now_s;
        if (tokens_ < 1.0) {
            return false;
        }
        tokens_ -= 1.0;
        return true;
    }

  private:
    double rate_per_s_;
    double burst_;
    double tokens_;
    double last_s_ = 0.0;
    bool started_ = false;
};

}  // namespace zoned::core
