// Tick log: tells overruns with the passes that caused them, limits that entities exceed, and zones
// that stopped; called by the tick loop after a tick.
#pragma once

#include "server/app/world/overload_steps.h"
#include "server/app/world/world.h"

#include <cstdint>
#include <string>

namespace zoned::app {

/// A tick that took longer than its period.
struct Overrun {
    double wall_ms = 0.0;
    double period_ms = 0.0;
    std::string cause;
};

class TickLog {
  public:
    /// At most one line a second; the others are counted into the next one.
    void overrun(const World& world, const Overrun& overrun, double now_s);

    /// Looks for entities that moved beyond what their type declares; at most one line a second.
    void limits(const World& world, double now_s);

    /// Tells what an overload begins to give up, and when that is over.
    void overload(const OverloadSteps::Load& load);

    /// Tells each zone that has stopped once.
    void stopped_zones(const World& world);

  private:
    double overrun_logged_s_ = -1e9;
    std::uint64_t overruns_ = 0;  ///< not told yet
    double limit_logged_s_ = -1e9;
    std::uint64_t limits_ = 0;
    std::size_t stopped_logged_ = 0;
    OverloadSteps overload_;
};

/// The passes that took most of the last tick, over all zones: "physics 12.1 ms, ai 3.0 ms".
[[nodiscard]] std::string slowest_passes(const World& world, std::size_t most);

}  // namespace zoned::app
