// LimitCheck: compares how an entity really moves with the limits that its type declares.
#pragma once

#include "server/world/entity_type.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

namespace zoned::replication {

/// The promised bound rests on a_max and dv_max; a truth that exceeds them makes the promise wrong,
/// so it is found here and reported.
class LimitCheck {
  public:
    /// True when between the tick before and `now` the velocity jumped by more than dv_max (beyond
    /// what a_max allows in a tick), or when a_max has been exceeded in kSustainedTicks successive
    /// ticks, which no single impact does. Never across a gap in the observation or a
    /// discontinuity.
    bool exceeded(Tick now,
                  Tick discontinuity_tick,
                  const Vec3& velocity,
                  const world::EntityType& type,
                  float tick_s);

  private:
    static constexpr int kSustainedTicks = 3;

    Vec3 velocity_ = Vec3::Zero();
    Tick tick_ = -1;
    int streak_ = 0;
};

}  // namespace zoned::replication
