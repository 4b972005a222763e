#include "server/ai/mind.h"

namespace zoned::ai {

namespace {

template <class Vector>
void add(core::StateHash& hash, const Vector& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) {
        hash.add(v[i]);
    }
}

void add(core::StateHash& hash, const Leg& leg) {
    add(hash, leg.from);
    add(hash, leg.direction);
    hash.add(leg.length);
    hash.add(leg.speed);
    hash.add(leg.lag_m);
    hash.add(leg.since);
    add(hash, leg.goal);
}

}  // namespace

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
    hash.add(mind.next_steering);
    hash.add(mind.aim.move_x);
    hash.add(mind.aim.move_z);
    hash.add(mind.aim.yaw);
    hash.add(mind.aim.buttons);
    add(hash, mind.anchor);
    hash.add(mind.anchor_since);
    hash.add(mind.detour_until);
    hash.add(mind.band);
    hash.add(static_cast<std::uint8_t>(mind.tier));
    hash.add(mind.unseen_since);
    add(hash, mind.leg);
    add(hash, mind.placed);
    hash.add(mind.next_event);
    // Only of minds that can have them, so that others hash as they always did.
    if (mind.degrees != decltype(mind.degrees){}) {
        for (const float degree : mind.degrees) {
            hash.add(degree);
        }
    }
    if (mind.ward || !mind.noticed || mind.known_at != 0) {
        hash.add(mind.ward.value);
        hash.add(mind.noticed);
        add(hash, mind.known);
        hash.add(mind.known_at);
    }
}

}  // namespace zoned::ai
