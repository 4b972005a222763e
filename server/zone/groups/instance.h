// Instance: a copy of a part of the map, open for some players for a while.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::zone {

/// An instance from its opening to its end, never reused.
using InstanceId = StrongId<struct InstanceTag>;

/// Of a zone in a tick; more are refused.
inline constexpr std::size_t kMostInstanceOrders = 1000;

/// A part of the map that is there several times. Each copy is a zone of its own, farther from all
/// others than any radius reaches.
struct InstanceKind {
    struct Copy {
        ZoneId zone;
        Vec3d origin = Vec3d::Zero();  ///< of its zone, world coordinates, m
    };

    std::string name;
    std::vector<Copy> copies;
    std::vector<Vec3d> entrances;  ///< from the origin of a copy, m; at least one
    Tick close_ticks = 900;        ///< it ends when nobody was there for so long

    /// Null: the zone is no copy of this.
    [[nodiscard]] const Copy* copy_in(ZoneId zone) const {
        const auto at = std::ranges::find(copies, zone, &Copy::zone);
        return at != copies.end() ? &*at : nullptr;
    }
};

struct InstanceSettings {
    std::vector<InstanceKind> kinds;
    Vec3d home = Vec3d::Zero();  ///< where players go from an instance that they did not enter
};

/// One that is open.
struct Instance {
    InstanceId id;
    std::uint16_t kind = 0;
    ZoneId zone;
    Tick empty_since = 0;  ///< 0: somebody is there
    bool ends = false;     ///< its zone is cleared in the coming tick
};

enum class InstanceAct : std::uint8_t {
    kOpen,
    kClose,
    kEnter,
};

struct InstanceOrder {
    InstanceAct act = InstanceAct::kOpen;
    ZoneId zone;      ///< whose rules they are
    EntityId player;  ///< kOpen: who asks, or none
    InstanceId instance;
    std::string kind;
    Vec3d from = Vec3d::Zero();  ///< kEnter: where the player goes back to, world coordinates, m
};

enum class InstanceEvent : std::uint8_t {
    kRefused,  ///< kOpen: no copy is free, or there is no such kind; kClose: it is not open
    kOpened,   ///< told in its zone, which is as the config says
    kReady,    ///< told to those who asked for it
    kEntered,  ///< the player is there; told in its zone, as are the next two
    kLeft,
    kEnds,  ///< at once: players are taken back and entities removed behind this call
};

inline constexpr std::string_view kInstanceEventNames[] =
    {"refused", "opened", "ready", "entered", "left", "ends"};

struct InstanceChange {
    InstanceEvent event = InstanceEvent::kRefused;
    ZoneId zone;  ///< where it is told
    InstanceId instance;
    std::string kind;
    EntityId player;
};

}  // namespace zoned::zone
