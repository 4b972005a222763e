#include "server/zone/simulation/approaching_props.h"

#include <cmath>

namespace zoned::zone {

namespace {

/// Nothing that matters here is faster, m/s; what is, is found a tick or two later.
constexpr float kFastProp = 25.0F;
constexpr float kApproachSlack = 0.05F;

}  // namespace

bool is_prop(const ZoneState& state, world::Row row) {
    return (*state.settings.types)[state.entities.type[row]].kind == world::EntityKind::kProp;
}

std::vector<world::Row> approached(const ZoneState& state, world::Row row, bool ghosts) {
    const world::Entities& e = state.entities;
    const float time = static_cast<float>(kLookaheadTicks) * state.settings.dt;
    const float radius = (*state.settings.types)[e.type[row]].extent();
    // Of a ghost the body is a step ahead of the column, which is as its owner sent it.
    const Vec3 at = state.scene.state(e.body[row]).position;
    const float reach = radius + (e.velocity[row].norm() + kFastProp) * time + kApproachSlack;
    std::vector<BodyId> bodies;
    state.scene.overlap(Aabb{at, at}.grown(reach), bodies);
    std::vector<world::Row> rows;
    for (const BodyId body : bodies) {
        const world::Row other = e.find(EntityId(state.scene.user(body)));
        if (other == world::kNoRow || other == row || !is_prop(state, other) ||
            e.has(other, world::kGhost) != ghosts) {
            continue;
        }
        const Vec3 apart = state.scene.state(body).position - at;
        const Vec3 closing = e.velocity[row] - e.velocity[other];
        const float gap = apart.norm() - radius - (*state.settings.types)[e.type[other]].extent();
        if (closing.dot(apart) > 0.0F && gap <= closing.norm() * time + kApproachSlack) {
            rows.push_back(other);
        }
    }
    return rows;
}

}  // namespace zoned::zone
