// CurrentZone: which zone a thread steps now, for the file of a crash.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::app {

/// Null where the thread steps none. A signal handler of the same thread may read it.
inline thread_local const zone::ZoneState* current_zone = nullptr;

/// Names the zone for as long as it lives.
class CurrentZone {
  public:
    explicit CurrentZone(const zone::ZoneState& state) : before_(current_zone) {
        current_zone = &state;
    }

    ~CurrentZone() { current_zone = before_; }

    CurrentZone(const CurrentZone&) = delete;
    CurrentZone& operator=(const CurrentZone&) = delete;

  private:
    const zone::ZoneState* before_;
};

}  // namespace zoned::app
