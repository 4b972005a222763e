#include "tests/bench/timing.h"

#include "tests/bench/cpu_clock.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace zoned::bench {

namespace {

/// An interval this long makes the clock's own cost and grain small, ns.
constexpr double kShortInterval = 20'000.0;
/// Turns per run: contenders change places this often.
constexpr int kTurns = 12;

/// A contender while it is being timed.
struct Lane {
    const Contender* contender = nullptr;
    std::unique_ptr<Trial> run;
    int group = 1;                             ///< frames per reading of the clock
    int done = 0;                              ///< frames done of this run
    std::vector<double> now;                   ///< CPU time of this run, us per frame, by group
    std::vector<double> wall;                  ///< wall-clock time, in the same form
    std::vector<std::vector<double>> repeats;  ///< `now` of all counted runs
    std::vector<std::vector<double>> wall_repeats;

    /// The run counts.
    void keep() {
        repeats.push_back(now);
        wall_repeats.push_back(wall);
    }

    void turn(int until) {
        while (done < until) {
            const int count = std::min(group, until - done);
            const std::int64_t wall_before = wall_ns();
            const std::int64_t before = thread_cpu_ns();
            for (int i = 0; i < count; ++i) {
                run->frame();
            }
            const auto spent = static_cast<double>(thread_cpu_ns() - before) - clock_cost_ns();
            const auto waited = static_cast<double>(wall_ns() - wall_before) - clock_cost_ns();
            now.push_back(std::max(spent, 0.0) / count * 1e-3);
            wall.push_back(std::max(waited, 0.0) / count * 1e-3);
            done += count;
        }
    }

    void observed_turn(int until) {
        while (done < until) {
            turn(done + 1);
            run->observe();
        }
    }
};

/// Ends of turns; each but the last is a multiple of the largest group, so that all runs form the
/// same groups.
std::vector<int> ends_of_turns(int frames, int group) {
    const int step = std::max(group, (frames / kTurns + group - 1) / group * group);
    std::vector<int> ends;
    for (int end = step; end < frames; end += step) {
        ends.push_back(end);
    }
    ends.push_back(frames);
    return ends;
}

void warm_up(Lane& lane, int frames, bool observed) {
    for (int i = 0; i < frames; ++i) {
        lane.run->frame();
        if (observed) {
            lane.run->observe();
        }
    }
}

/// One run of each lane, in turns.
void run_all(std::span<Lane* const> lanes, const Plan& plan, bool observed) {
    std::vector<std::vector<int>> ends;
    std::size_t turns = 0;
    for (Lane* lane : lanes) {
        lane->run = lane->contender->build();
        lane->done = 0;
        lane->now.clear();
        lane->wall.clear();
        warm_up(*lane, plan.warm_up, observed);
        ends.push_back(ends_of_turns(plan.frames, lane->group));
        turns = std::max(turns, ends.back().size());
    }
    for (std::size_t turn = 0; turn < turns; ++turn) {
        for (const std::size_t i : order_of_turn(turn, lanes.size())) {
            if (turn >= ends[i].size()) {
                continue;
            }
            if (observed) {
                lanes[i]->observed_turn(ends[i][turn]);
            } else {
                lanes[i]->turn(ends[i][turn]);
            }
        }
    }
}

int group_for(double frame_us, int frames) {
    if (frame_us * 1e3 >= kShortInterval) {
        return 1;
    }
    const double wanted = std::ceil(kShortInterval / std::max(frame_us * 1e3, 1.0));
    return static_cast<int>(std::min<double>(wanted, frames));
}

/// CPU time of the lanes' last runs, s.
double last_runs_s(std::span<const Lane> lanes) {
    double us = 0.0;
    for (const Lane& lane : lanes) {
        us += mean(lane.now) * lane.done;
    }
    return 1e-6 * us;
}

Timing summary(const Lane& lane) {
    const std::vector<double> frames = median_of_rows(lane.repeats);
    const std::vector<double> wall = median_of_rows(lane.wall_repeats);
    return {median(frames), quantile(frames, 0.99), mean(frames), median(wall)};
}

}  // namespace

std::vector<std::size_t> order_of_turn(std::size_t turn, std::size_t count) {
    std::vector<std::size_t> order;
    // 0, 1, last, 2, last but one, ...: all distances between neighbours differ.
    for (std::size_t place = 0; place < count; ++place) {
        const std::size_t half = (place + 1) / 2;
        order.push_back(((place % 2 == 1 ? half : count - half) + (count > 2 ? turn : 0)) % count);
    }
    if (count % 2 == 1 && turn / count % 2 == 1) {
        std::reverse(order.begin(), order.end());
    }
    return order;
}

std::vector<Timing> time_interleaved(std::span<const Contender> contenders,
                                     const Plan& plan,
                                     const std::function<void(std::size_t, Trial&)>& finish) {
    std::vector<Lane> lanes(contenders.size());
    std::vector<Lane*> due;
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        lanes[i].contender = &contenders[i];
        due.push_back(&lanes[i]);
    }
    run_all(due, plan, true);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        Lane& lane = lanes[i];
        finish(i, *lane.run);
        lane.run.reset();
        lane.group = group_for(median(lane.now), plan.frames);
        if (lane.group == 1) {
            lane.keep();  // lanes that are observed frame by frame were timed so as well
        }
    }
    const std::size_t repeats =
        last_runs_s(lanes) < plan.enough_s ? static_cast<std::size_t>(plan.repeats) : 1;
    while (true) {
        std::erase_if(due, [repeats](const Lane* lane) { return lane->repeats.size() >= repeats; });
        if (due.empty()) {
            break;
        }
        run_all(due, plan, false);
        for (Lane* lane : due) {
            lane->run.reset();
            lane->keep();
        }
    }
    std::vector<Timing> timings;
    for (const Lane& lane : lanes) {
        timings.push_back(summary(lane));
    }
    return timings;
}

}  // namespace zoned::bench
