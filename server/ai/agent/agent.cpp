#include "server/ai/agent/agent.h"

#include "server/ai/agent/agent_fields.h"
#include "shared/core/block_hash.h"

namespace zoned::ai {

void shift(Agent& agent, const Vec3& offset) {
    agent.home += offset;
    agent.target += offset;
    agent.anchor += offset;
    agent.known += offset;
    agent.segment.from += Vec2(offset.x(), offset.z());
    agent.segment.goal += Vec2(offset.x(), offset.z());
    agent.placed += Vec2(offset.x(), offset.z());
}

void hash(core::StateHash& hash, const Agent& agent) {
    core::BlockHash block;
    // Inlined, so that the hash chain of each number is known at compile time.
    visit_fields(
        agent, [&block](const auto& number) __attribute__((always_inline)) { block.pack(number); });
    hash.add(block.value());
}

void hash_walk(core::StateHash& hash, const Agent& agent) {
    core::BlockHash block;
    block.pack(agent.entity.value);
    visit_walk_fields(
        agent, [&block](const auto& number) __attribute__((always_inline)) { block.pack(number); });
    hash.add(block.value());
}

}  // namespace zoned::ai
