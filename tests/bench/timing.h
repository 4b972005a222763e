// Fair timing: methods of a scene run in alternating short turns; medians over several runs count.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::bench {

/// One run of one method on one scene, built afresh for every repeat.
class Trial {
  public:
    Trial() = default;
    Trial(const Trial&) = delete;
    Trial& operator=(const Trial&) = delete;
    virtual ~Trial() = default;
    /// The work that is timed: one frame.
    virtual void frame() = 0;

    /// Reads the results of the frame; not timed, and only called in the first run.
    virtual void observe() {}
};

struct Contender {
    std::string label;
    std::function<std::unique_ptr<Trial>()> build;
};

struct Plan {
    int warm_up = 0;  ///< frames before those that are timed
    int frames = 1;   ///< timed frames, > 0
    int repeats = 3;  ///< timed runs, > 0
    /// Once all contenders together have taken so long, s of CPU time, none is run again: in a long
    /// run a disturbance counts little, and repeats would take most of a full report.
    double enough_s = 10.0;
};

/// CPU time of frames in microseconds, over the timed frames of a run. The time of a frame is its
/// median over the runs, so that a disturbance in one run does not count. Frames that are short
/// against the clock are timed in groups. The percentiles are then of the groups' means.
struct Timing {
    double p50_us = 0.0;
    double p99_us = 0.0;
    double mean_us = 0.0;
    double wall_p50_us = 0.0;  ///< wall-clock time, which more threads shorten
};

/// The order in which `count` contenders take a turn. A contender that ran on both cores, or slept
/// while a device worked, leaves the machine in another state than a bare loop does. Over `count`
/// turns (twice as many where it is odd) each contender therefore comes directly after each other
/// one equally often, within turns. Two contenders alternate. (Williams, "Experimental designs
/// balanced for the estimation of residual effects of treatments", Australian Journal of Scientific
/// Research A 2, 1949.)
std::vector<std::size_t> order_of_turn(std::size_t turn, std::size_t count);

/// `finish(i, run)` is called with each contender's observed run after its last frame.
std::vector<Timing> time_interleaved(std::span<const Contender> contenders,
                                     const Plan& plan,
                                     const std::function<void(std::size_t, Trial&)>& finish);

}  // namespace zoned::bench
