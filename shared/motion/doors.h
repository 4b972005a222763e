// Doors: boxes of the world that are solid at some ticks only.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <optional>
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

/// A door's timetable. It is a function of the tick alone, so every side knows the door at any tick
/// of the past or the future.
struct Timetable {
    /// Ticks [from, to) of a period.
    struct OpenSpan {
        Tick from = 0;
        Tick to = 0;

        friend bool operator==(const OpenSpan&, const OpenSpan&) = default;
    };

    Tick period = 1;  ///< ticks, > 0
    Tick shift = 0;   ///< offset of tick 0 from the beginning of a period, [0, period)
    std::vector<OpenSpan>
        open;  ///< ascending, apart, within [0, period]; touching spans are merged

    /// For any tick, negative ones too.
    [[nodiscard]] bool open_at(Tick tick) const;

    /// The first tick after `tick` at which the door opens or shuts; kNever where there is none.
    [[nodiscard]] Tick next_change(Tick tick) const;

    /// Later than any tick.
    static constexpr Tick kNever = INT64_MAX;

    friend bool operator==(const Timetable&, const Timetable&) = default;

  private:
    [[nodiscard]] Tick phase(Tick tick) const;
};

/// A box that is solid while shut and absent while open: a gate, a shutter, or a bridge, which
/// carries while it is "shut".
struct Door {
    StaticBox box;
    Timetable times;
    /// The number in the world of a door that rules move (DoorCourses); its timetable says how it
    /// is until they do.
    std::optional<std::uint32_t> by_rules = std::nullopt;
};

/// In place of a tick: all doors are open.
inline constexpr Tick kAllDoorsOpen = INT64_MIN;

}  // namespace zoned::motion
