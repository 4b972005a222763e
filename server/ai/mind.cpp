#include "server/ai/mind.h"

#include "server/ai/mind_fields.h"
#include "shared/core/block_hash.h"

namespace zoned::ai {

void shift(Mind& mind, const Vec3& offset) {
    mind.home += offset;
    mind.target += offset;
    mind.anchor += offset;
    mind.known += offset;
    mind.leg.from += Vec2(offset.x(), offset.z());
    mind.leg.goal += Vec2(offset.x(), offset.z());
    mind.placed += Vec2(offset.x(), offset.z());
}

void hash(core::StateHash& hash, const Mind& mind) {
    core::BlockHash block;
    // Inlined, so that which chain a number enters is known when this is compiled.
    visit_fields(
        mind, [&block](const auto& number) __attribute__((always_inline)) {
            if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(number)>>) {
                block.add(static_cast<std::uint64_t>(number));
            } else {
                block.add(number);
            }
        });
    hash.add(block.value());
}

}  // namespace zoned::ai
