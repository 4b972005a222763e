#include "server/ai/mind.h"

#include "server/ai/mind_fields.h"

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
    visit_fields(mind, [&hash](const auto& number) {
        if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(number)>>) {
            hash.add(static_cast<std::uint64_t>(number));
        } else {
            hash.add(number);
        }
    });
}

}  // namespace zoned::ai
