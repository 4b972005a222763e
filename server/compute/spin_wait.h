// Spin: a short wait for another thread; it yields the core to others when it becomes long.
#pragma once

#include <thread>

namespace zoned::compute {

class Spin {
  public:
    void wait() {
        if (turns_ < kAwakeTurns) {
            ++turns_;
#if defined(__x86_64__)
            __builtin_ia32_pause();
#elif defined(__aarch64__)
            __asm__ volatile("yield");
#endif
        } else {
            std::this_thread::yield();
        }
    }

  private:
    /// Some ten microseconds: longer than a stage's blocks differ, shorter than a scheduler's turn.
    static constexpr int kAwakeTurns = 1000;
    int turns_ = 0;
};

}  // namespace zoned::compute
