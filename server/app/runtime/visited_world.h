// VisitedWorld: a world that ticks on a thread of its own, as those see it who look from others.
#pragma once

#include "server/app/world/world.h"
#include "server/mailbox/bounded_queue.h"

#include <algorithm>
#include <cstddef>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace zoned::app {

struct LoopStats;

/// Reads the world between two ticks, on the loop's thread; changes nothing and takes at most a
/// millisecond.
using WorldVisit = std::function<void(const World&)>;
/// So many wait at most.
inline constexpr std::size_t kMostVisits = 16;
inline constexpr double kMostTimeScale = 8.0;

/// All calls are for any thread.
class VisitedWorld {
  public:
    VisitedWorld() = default;
    VisitedWorld(const VisitedWorld&) = delete;
    VisitedWorld& operator=(const VisitedWorld&) = delete;
    virtual ~VisitedWorld() = default;

    /// Has the world visited after one of the next ticks, one visit a tick. False when too many
    /// visits wait already.
    virtual bool visit(WorldVisit visit) = 0;

    /// Lets it run at `scale` times its rate from now on, 0 to kMostTimeScale; at 0 it stands
    /// still. Visits are answered meanwhile.
    virtual void set_time_scale(double scale) = 0;
    [[nodiscard]] virtual double time_scale() const = 0;

    /// So many ticks more while it stands still.
    virtual void step_ticks(unsigned ticks) = 0;

    /// Figures as they were a moment ago, null before the first tick. The loop never waits for its
    /// readers.
    [[nodiscard]] virtual std::shared_ptr<const LoopStats> published() const = 0;
};

/// Visits that wait for their turn.
class VisitQueue {
  public:
    /// From any thread.
    bool push(WorldVisit visit) { return visits_.push(std::move(visit)); }

    /// On the loop's thread: one visit, if any waits.
    void answer(const World& world) {
        if (waiting_.size() < kMostVisits) {
            visits_.take_all(taken_);
            std::move(taken_.begin(), taken_.end(), std::back_inserter(waiting_));
            taken_.clear();
        }
        if (!waiting_.empty()) {
            waiting_.front()(world);
            waiting_.pop_front();
        }
    }

  private:
    mailbox::BoundedQueue<WorldVisit> visits_{kMostVisits};
    std::vector<WorldVisit> taken_;
    std::deque<WorldVisit> waiting_;
};

}  // namespace zoned::app
