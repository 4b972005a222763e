// LimitCheck: compares how an entity really moves with the limits that its type declares.
#pragma once

#include "server/world/entity_type.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

namespace zoned::replication {

/// The promised bound rests on a_max and dv_max. A true motion that exceeds them makes the promise
/// wrong, so this check finds and reports it.
///
/// The promise grants an update of age D an error of a_max D^2 / 2 + dv_max D. It holds for any
/// motion whose velocity changes by no more than dv_max + a_max w over any window of length w up to
/// D. Several impacts in a row are as good as one, as long as they do not add up to more. The check
/// thus compares the net change over a window, in velocity and in place. Rates of turn have no
/// limit but on what changes within a tick.
class LimitCheck {
  public:
    /// True when the motion within a window that ends at `now` exceeds a limit. Either the velocity
    /// changed by more than dv_max + a_max w. Or the place differs by more than dv_max w + a_max
    /// w^2 / 2 from where the window's first velocity leads (steps onto ledges move without a
    /// velocity). Or its rate of turn changed by too much since the tick before. Windows begin with
    /// the tick before and with the last multiple of kWindowTicks. Never across a gap in the
    /// observation or a discontinuity.
    bool exceeded(Tick now,
                  Tick discontinuity_tick,
                  const Vec3& position,
                  const Vec3& velocity,
                  const Vec3& spin,
                  const world::EntityType& type,
                  float tick_s);

    /// Half a second at 30 Hz: an older update belongs to a connection that hardly works.
    static constexpr Tick kWindowTicks = 16;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(before_, window_, spin_before_);
    }

  private:
    /// Where a window begins.
    struct MotionStart {
        Tick tick = -1;
        Vec3 position = Vec3::Zero();
        Vec3 velocity = Vec3::Zero();
    };

    [[nodiscard]] static bool leaves(const MotionStart& start,
                                     const MotionStart& end,
                                     const world::EntityType& type,
                                     float tick_s);

    MotionStart before_;
    MotionStart window_;
    Vec3 spin_before_ = Vec3::Zero();
};

}  // namespace zoned::replication
