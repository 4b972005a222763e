// Doors: boxes of the world that are there at some ticks and not at others.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <vector>

namespace zoned::motion {

/// A static oriented box: wall, floor slab or ramp.
struct StaticBox {
    Vec3 centre = Vec3::Zero();        ///< m
    Vec3 half_extents = Vec3::Ones();  ///< m, each > 0
    Quat orientation = Quat::Identity();
    float friction = 0.6F;
    float restitution = 0.0F;
};

/// When a door stands open: a function of the tick alone, so that whoever knows the timetable knows
/// the door, at any tick of the past or the future.
struct Timetable {
    /// Ticks [from, to) of a period.
    struct OpenSpan {
        Tick from = 0;
        Tick to = 0;

        friend bool operator==(const OpenSpan&, const OpenSpan&) = default;
    };

    Tick period = 1;             ///< ticks, > 0
    Tick shift = 0;              ///< of tick 0 from the beginning of a period, [0, period)
    std::vector<OpenSpan> open;  ///< ascending, apart, within [0, period]; two that touch are one

    /// For any tick, negative ones too.
    [[nodiscard]] bool open_at(Tick tick) const;

    /// The first tick after `tick` at which it is the other way than the tick before; kNever where
    /// there is none.
    [[nodiscard]] Tick next_change(Tick tick) const;

    /// Later than any tick.
    static constexpr Tick kNever = INT64_MAX;

    friend bool operator==(const Timetable&, const Timetable&) = default;

  private:
    [[nodiscard]] Tick phase(Tick tick) const;
};

/// Solid while it is shut, not there while it is open: a gate, a shutter, but a bridge as well,
/// which is walked on while it is "shut".
struct Door {
    StaticBox box;
    Timetable times;

    [[nodiscard]] bool shut_at(Tick tick) const { return !times.open_at(tick); }
};

/// In place of a tick: no door is there.
inline constexpr Tick kAllDoorsOpen = INT64_MIN;

}  // namespace zoned::motion
