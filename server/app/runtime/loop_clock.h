// LoopClock: the time by which the tick loop runs: the steady clock, slower, faster or standing
// still.
#pragma once

namespace zoned::app {

/// Pure arithmetic over times that the caller passes, s. A world is slowed down and stopped in
/// development alone; its ticks are the same, only their moments differ.
class LoopClock {
  public:
    /// Loop time at a moment of the steady clock.
    [[nodiscard]] double time(double now_s) const { return base_s_ + scale_ * (now_s - since_s_); }

    /// How long the steady clock takes to a loop time, s; only while the clock runs.
    [[nodiscard]] double until(double time_s, double now_s) const {
        return (time_s - time(now_s)) / scale_;
    }

    [[nodiscard]] bool runs() const { return scale_ > 0.0; }

    [[nodiscard]] double scale() const { return scale_; }

    /// From now on it runs at `scale` >= 0; 0: it stands still.
    void set_scale(double scale, double now_s) {
        base_s_ = time(now_s);
        since_s_ = now_s;
        scale_ = scale;
    }

    /// Goes on by so much at once.
    void skip(double by_s) { base_s_ += by_s; }

  private:
    double base_s_ = 0.0;
    double since_s_ = 0.0;
    double scale_ = 1.0;
};

}  // namespace zoned::app
