#include "server/ai/ai_step.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai {

namespace {

void add(core::StateHash& hash, const Vec3& v) {
    hash.add(v.x());
    hash.add(v.y());
    hash.add(v.z());
}

void add(core::StateHash& hash, const Mind& mind) {
    hash.add(mind.entity.value);
    hash.add(mind.machine);
    mind.fsm.hash(hash);
    hash.add(mind.doing);
    hash.add(mind.facts);
    for (const float variable : mind.variables) {
        hash.add(variable);
    }
    hash.add(mind.variables_at);
    hash.add(mind.next_decision);
    add(hash, mind.home);
    add(hash, mind.target);
    hash.add(mind.corner);
    hash.add(mind.prey.value);
    hash.add(mind.rng.state);
    hash.add(mind.rng.stream);
    hash.add(mind.entered);
    hash.add(mind.fresh);
    hash.add(mind.far);
    hash.add(mind.aim.move_x);
    hash.add(mind.aim.move_z);
    hash.add(mind.aim.yaw);
    hash.add(mind.aim.buttons);
    add(hash, mind.anchor);
    hash.add(mind.anchor_since);
    hash.add(mind.detour_until);
    hash.add(mind.band);
}

template <class Vector>
auto lower_bound_of(Vector& minds, EntityId entity) {
    return std::lower_bound(
        minds.begin(), minds.end(), entity, [](const Mind& m, EntityId e) { return m.entity < e; });
}

}  // namespace

void shift(Mind& mind, const Vec3& offset) {
    mind.home += offset;
    mind.target += offset;
    mind.anchor += offset;
}

void Minds::add(const Mind& mind) {
    const auto at = lower_bound_of(minds_, mind.entity);
    ZONED_ASSERT(mind.entity && (at == minds_.end() || at->entity != mind.entity),
                 "an entity has one mind");
    minds_.insert(at, mind);
}

Mind Minds::take(EntityId entity) {
    const auto at = lower_bound_of(minds_, entity);
    ZONED_ASSERT(at != minds_.end() && at->entity == entity, "a mind to take exists");
    const Mind mind = *at;
    minds_.erase(at);
    return mind;
}

const Mind* Minds::find(EntityId entity) const {
    const auto at = lower_bound_of(minds_, entity);
    return at == minds_.end() || at->entity != entity ? nullptr : &*at;
}

void Minds::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(minds_.size()));
    for (const Mind& mind : minds_) {
        ai::add(hash, mind);
    }
}

}  // namespace zoned::ai
