#include "server/replication/limit_check.h"

namespace zoned::replication {

bool LimitCheck::exceeded(Tick now,
                          Tick discontinuity_tick,
                          const Vec3& velocity,
                          const world::EntityType& type,
                          float tick_s) {
    const bool comparable = tick_ == now - 1 && discontinuity_tick < now;
    const float change = (velocity - velocity_).norm();
    velocity_ = velocity;
    tick_ = now;
    if (!comparable) {
        streak_ = 0;
        return false;
    }
    // A thousandth on top: velocities are floats, and an entity that accelerates exactly at its
    // limit must not be reported for rounding.
    const float smooth = type.max_acceleration_mps2 * tick_s * 1.001F + 1e-4F;
    if (change > smooth + type.max_velocity_jump_mps) {
        streak_ = 0;
        return true;
    }
    streak_ = change > smooth ? streak_ + 1 : 0;
    return streak_ >= kSustainedTicks;
}

}  // namespace zoned::replication
