#include "server/replication/limit_check.h"

namespace zoned::replication {

namespace {

/// A thousandth on top: velocities are floats, and an entity that accelerates exactly at its limit
/// must not be reported for rounding. Positions within a zone round to 0.1 mm.
constexpr float kSlack = 1.001F;

}  // namespace

bool LimitCheck::exceeded(Tick now,
                          Tick discontinuity_tick,
                          const Vec3& position,
                          const Vec3& velocity,
                          const Vec3& spin,
                          const world::EntityType& type,
                          float tick_s) {
    const MotionStart end{now, position, velocity};
    const bool comparable = before_.tick == now - 1 && discontinuity_tick < now;
    const bool spun =
        !type.upright() && (spin - spin_before_).norm() > type.max_spin_jump_rps() * kSlack;
    const bool left = comparable && (spun || leaves(before_, end, type, tick_s) ||
                                     leaves(window_, end, type, tick_s));
    // The window begins anew after a report, so that one impact is reported once.
    if (!comparable || left || now % kWindowTicks == 0) {
        window_ = end;
    }
    before_ = end;
    spin_before_ = spin;
    return left;
}

bool LimitCheck::leaves(const MotionStart& start,
                        const MotionStart& end,
                        const world::EntityType& type,
                        float tick_s) {
    const float w = static_cast<float>(end.tick - start.tick) * tick_s;
    const float change = (end.velocity - start.velocity).norm();
    // Positions follow the velocity at the end of a tick (semi-implicit Euler), which a constant
    // acceleration takes a tick farther than its parabola.
    const float place = (end.position - start.position - start.velocity * w).norm();
    const float a_max = type.max_acceleration_mps2 * kSlack;
    const float dv_max = type.max_velocity_jump_mps * kSlack;
    return change > dv_max + a_max * w + 1e-4F ||
           place > dv_max * w + 0.5F * a_max * w * (w + tick_s) + 1e-3F;
}

}  // namespace zoned::replication
