// HerdDrift: where animals of a herd are that nobody sees.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/world/entities.h"

#include <span>

namespace zoned::ai {

/// Where those neighbours are whom nobody sees: their rows say where they were put last, their
/// agents where they are now.
struct HerdDrift {
    const AgentStore& agents;
    std::span<const Slot> slots;  ///< by row: of whoever dozes there; others may be in the way
    Tick now;
    float dt;       ///< s
    float reach_m;  ///< nobody is farther than this from its row

    /// Of a row that dozes; null: it has no agent here.
    [[nodiscard]] const PathSegment* segment_of(const world::Entities& entities,
                                                world::Row row) const;
};

}  // namespace zoned::ai
