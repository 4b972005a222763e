#include "server/ai/mind.h"

#include "server/ai/mind_fields.h"
#include "shared/core/block_hash.h"

namespace zoned::ai {

void shift(Mind& mind, const Vec3& offset) {
    mind.home += offset;
    mind.target += offset;
    mind.anchor += offset;
    mind.known += offset;
    mind.segment.from += Vec2(offset.x(), offset.z());
    mind.segment.goal += Vec2(offset.x(), offset.z());
    mind.placed += Vec2(offset.x(), offset.z());
}

void hash(core::StateHash& hash, const Mind& mind) {
    core::BlockHash block;
    // Inlined, so that which chain a number enters is known when this is compiled.
    visit_fields(
        mind, [&block](const auto& number) __attribute__((always_inline)) { block.pack(number); });
    hash.add(block.value());
}

void hash_walk(core::StateHash& hash, const Mind& mind) {
    core::BlockHash block;
    block.pack(mind.entity.value);
    visit_walk_fields(
        mind, [&block](const auto& number) __attribute__((always_inline)) { block.pack(number); });
    hash.add(block.value());
}

}  // namespace zoned::ai
