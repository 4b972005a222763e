// Triggers: boxes of the config; the rules are told of entities that come into them and leave them.
#pragma once

#include "server/world/entities.h"
#include "shared/core/state_hash.h"
#include "shared/motion/static_geometry.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::zone {

struct ZoneState;
class RulesContext;

struct Trigger {
    std::string name;
    motion::StaticBox box;      ///< that nothing touches
    std::vector<bool> notices;  ///< by type

    /// Whether a point lies within, its surface included.
    [[nodiscard]] bool holds(const Vec3& point) const {
        const Vec3 local = box.orientation.conjugate() * (point - box.centre);
        return (local.cwiseAbs() - box.half_extents).maxCoeff() <= 0.0F;
    }
};

/// Of one zone, in the order of its settings: owned and shown entities, ascending.
struct TriggerState {
    struct Change {
        std::size_t trigger = 0;
        EntityId entity;
        bool entered = false;
    };

    std::vector<std::vector<EntityId>> inside;
    std::vector<Change> events;  ///< of this tick, in the order of triggers and entities
    std::vector<EntityId> now;   ///< scratch, as are the rest
    std::vector<EntityId> changed;
    std::vector<world::Row> moved;
};

/// Tells the rules of all that has come and gone since the last tick.
void report_triggers(ZoneState& state, RulesContext& context);

}  // namespace zoned::zone
