#include "server/ai/steering/herd_drift.h"

namespace zoned::ai {

const PathSegment* HerdDrift::segment_of(const world::Entities& entities, world::Row row) const {
    const EntityId entity = entities.id[row];
    if (row < slots.size() && slots[row] < agents.slots()) {
        const Agent& hinted = agents.at(slots[row]);
        if (hinted.entity == entity) {
            return &hinted.segment;
        }
    }
    const Agent* const agent = agents.find(entity);
    return agent != nullptr ? &agent->segment : nullptr;
}

}  // namespace zoned::ai
