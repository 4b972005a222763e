// HerdDrift: the present positions of suspended herd animals.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/world/entities.h"

#include <span>

namespace zoned::ai {

/// The positions of suspended neighbours. Their rows say where they were last put; their agents say
/// where they are now.
struct HerdDrift {
    const AgentStore& agents;
    std::span<const Slot> slots;  ///< by row: the slot of each suspended agent; rows of other
                                  ///< agents may hold any slot
    Tick now;
    float dt;       ///< s
    float reach_m;  ///< no animal is farther than this from its row

    /// The segment of a suspended row; null: the row has no agent here.
    [[nodiscard]] const PathSegment* segment_of(const world::Entities& entities,
                                                world::Row row) const;
};

}  // namespace zoned::ai
