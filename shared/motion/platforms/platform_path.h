// Platform: a box of the world that travels between stops, where it is at each tick.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"
#include "shared/motion/courses.h"
#include "shared/motion/doors.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace zoned::motion {

/// Platforms are displaced by multiples of this, m. Within a kilometre of the origin a float holds
/// a character's coordinate plus such a displacement without rounding, but for the first time that
/// the coordinate passes a power of two. So a character keeps its position on a platform however
/// long it rides.
inline constexpr double kPlatformStep_m = 1.0 / 16384.0;

/// The nearest multiple of kPlatformStep_m.
float on_platform_step(double metres);

/// A stop of a platform.
struct PlatformStop {
    Vec3 offset = Vec3::Zero();  ///< from the first stop, m, multiples of kPlatformStep_m
    Tick at = 0;                 ///< ticks of travel from the first stop

    friend bool operator==(const PlatformStop&, const PlatformStop&) = default;
};

/// The way of a platform and the times at which it travels. The whole platform is a function of the
/// tick, or of the tick and the courses that rules announce. It keeps its orientation. Between two
/// stops its speed is constant.
struct PlatformPath {
    std::vector<PlatformStop> stops;  ///< two or more; the first is zero, `at` ascends
    Tick back = 0;   ///< ticks from the last stop straight to the first; 0: back as it came
    Tick wait = 0;   ///< ticks at each stop
    Tick shift = 0;  ///< ticks of its round that tick 0 has behind it, >= 0
    /// The number in the world of a platform that rules move (PlatformCourses).
    std::optional<std::uint32_t> by_rules = std::nullopt;
    Tick start = 0;  ///< moved by rules: ticks along the way where it stands until they move it

    /// Ticks of travel from the first stop to the last, or round to the first.
    [[nodiscard]] Tick length() const { return stops.back().at + back; }

    /// Ticks until the times repeat.
    [[nodiscard]] Tick period() const;

    /// How far along the way its times have it at a tick, in ticks of travel, [0, length()].
    [[nodiscard]] Tick along_at(Tick tick) const;

    /// Its displacement from the first stop, m. `along` is in [0, length()].
    [[nodiscard]] Vec3 offset(Tick along) const;

    friend bool operator==(const PlatformPath&, const PlatformPath&) = default;
};

/// A solid box that moves: a lift, a ferry.
struct Platform {
    StaticBox box;  ///< at its first stop
    PlatformPath path;
};

/// From a tick on a platform travels from a point of its way to another one and stays there.
struct PlatformCourse {
    Tick from = 0;
    Tick along = 0;  ///< where it is then, ticks along the way
    Tick to = 0;     ///< ticks along the way

    [[nodiscard]] Tick along_at(Tick tick) const;

    friend bool operator==(const PlatformCourse&, const PlatformCourse&) = default;
};

/// By the number of the platform in the world.
using PlatformCourses = Courses<PlatformCourse>;

}  // namespace zoned::motion
