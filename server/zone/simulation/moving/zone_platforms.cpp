#include "server/zone/simulation/moving/zone_platforms.h"

#include "server/zone/simulation/type_body.h"
#include "shared/core/assert.h"

namespace zoned::zone {

namespace {

/// A body that is farther than this from where it was a tick ago has missed ticks, m.
constexpr float kMissed_m = 0.01F;

bool moves(const motion::StaticGeometry& statics, std::uint32_t platform, Tick tick) {
    const Tick before = statics.along_at(platform, tick - 1);
    return statics.along_at(platform, tick) != before ||
           before != statics.along_at(platform, tick - 2);
}

}  // namespace

void add_platforms(ZoneState& state) {
    const motion::StaticGeometry& statics = *state.settings.statics;
    if (statics.platforms().empty()) {
        return;
    }
    state.fixed_ground =
        std::make_unique<const motion::StaticGeometry>(statics.without_platforms());
    for (std::uint32_t platform = 0; platform < statics.platforms().size(); ++platform) {
        const motion::StaticBox box = statics.platform_box(platform, state.now);
        physics::BodyDef def;
        def.kind = physics::BodyKind::kKinematic;
        def.shape = physics::Shape::box(box.half_extents);
        def.position = box.centre;
        def.orientation = box.orientation;
        def.material = {box.friction, box.restitution};
        def.filter.category = kMovingCategory;
        const auto body = state.scene.add(def);
        ZONED_ASSERT(body.ok(), "platforms were checked when the config was read");
        state.platforms.push_back(*body);
    }
}

std::uint32_t moving_platforms(const ZoneState& state) {
    std::uint32_t count = 0;
    for (std::uint32_t platform = 0; platform < state.platforms.size(); ++platform) {
        count += moves(*state.settings.statics, platform, state.now) ? 1U : 0U;
    }
    return count;
}

std::uint32_t steer_platforms(ZoneState& state) {
    const motion::StaticGeometry& statics = *state.settings.statics;
    std::uint32_t count = 0;
    for (std::uint32_t platform = 0; platform < state.platforms.size(); ++platform) {
        const BodyId id = state.platforms[platform];
        physics::BodyState body = state.scene.state(id);
        const Vec3 before = statics.platform_box(platform, state.now - 1).centre;
        if ((body.position - before).norm() > kMissed_m) {
            // The world was frozen: it goes on from where the others see it.
            body.position = before;
            state.scene.set_state(id, body);
        }
        const Vec3 target = statics.platform_box(platform, state.now).centre;
        // Computed from the body's own position, so that rounding never adds up.
        state.scene.set_velocity(id, (target - body.position) / state.settings.dt, Vec3::Zero());
        count += target != before ? 1U : 0U;
    }
    return count;
}

}  // namespace zoned::zone
