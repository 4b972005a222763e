#include "server/ai/leg.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

Leg leg_from(const Vec2& here,
             const Vec2& velocity,
             const Vec2& direction,
             float speed,
             float acceleration,
             Tick tick) {
    Leg leg;
    leg.direction = direction;
    leg.speed = speed;
    leg.since = tick;
    leg.from = here;
    const Vec2 change = direction * speed - velocity;
    const float size = change.norm();
    if (acceleration > 0.0F && size > 0.0F) {
        leg.bend_s = size / acceleration;
        leg.bend = change * (0.5F * acceleration / size);
        leg.from -= leg.bend * (leg.bend_s * leg.bend_s);
    }
    return leg;
}

Tick arrival_of(const Leg& leg, float dt) {
    const float ticks = std::floor(leg.length / (leg.speed * dt));
    return leg.since + 2 + static_cast<Tick>(std::clamp(ticks, 0.0F, 1e9F));
}

}  // namespace zoned::ai
