#include "server/physics/particles/particle_flock.h"

#include "server/physics/particles/flock_path.h"

#include <cmath>

namespace zoned::physics {

namespace {

bool is_size(float value) {
    return value >= 0.0F && std::isfinite(value);
}

bool above_zero(float value) {
    return value > 0.0F && std::isfinite(value);
}

std::string unfit_path(const FlockDef& def) {
    if (def.path.empty()) {
        return {};
    }
    if (def.path.size() < 2) {
        return "path: must have two points";
    }
    for (const Vec2d& point : def.path) {
        if (!point.allFinite()) {
            return "path: must be finite";
        }
    }
    return above_zero(def.path_width) && above_zero(def.follow)
               ? std::string()
               : "path_width, follow: must be finite and above 0";
}

}  // namespace

std::string unfit(const FlockDef& def) {
    if (!above_zero(def.radius) || !above_zero(def.most_acceleration) ||
        !above_zero(def.most_speed)) {
        return "radius, most_acceleration, most_speed: must be finite and above 0";
    }
    if (!is_size(def.separation) || !is_size(def.alignment) || !is_size(def.cohesion) ||
        !is_size(def.turn_back)) {
        return "separation, alignment, cohesion, turn_back: must be finite and not below 0";
    }
    if (!(def.separation_radius >= 0.0F && def.separation_radius <= def.radius)) {
        return "separation_radius: must be 0..radius";
    }
    if (!(def.least_speed >= 0.0F && def.least_speed <= def.most_speed)) {
        return "least_speed: must be 0..most_speed";
    }
    if (!def.low.allFinite() || !def.high.allFinite() ||
        !(def.low.array() < def.high.array()).all()) {
        return "low, high: must be finite, low below high";
    }
    return unfit_path(def);
}

kernels::FlockRules flock_rules_of(const FlockDef& def) {
    kernels::FlockRules rules{};
    rules.radius2 = def.radius * def.radius;
    rules.separation2 = def.separation_radius * def.separation_radius;
    rules.separation = def.separation;
    rules.alignment = def.alignment;
    rules.cohesion = def.cohesion;
    rules.most_acceleration = def.most_acceleration;
    rules.least_speed = def.least_speed;
    rules.most_speed = def.most_speed;
    const Vec3 low = def.low.cast<float>();
    const Vec3 high = def.high.cast<float>();
    rules.low_x = low.x();
    rules.low_y = low.y();
    rules.low_z = low.z();
    rules.high_x = high.x();
    rules.high_y = high.y();
    rules.high_z = high.z();
    rules.turn_back = def.turn_back;
    return rules;
}

Flock::Flock(const FlockDef& def, compute::Device* device)
    : rules_(flock_rules_of(def)),
      stage_(device) {
    if (!def.path.empty()) {
        directions_ = directions_along(def, rules_);
    }
}

compute::StageRun Flock::step(compute::ParticleColumns& columns,
                              std::size_t count,
                              float h,
                              bool on_device,
                              compute::Team& team) {
    rules_.h = h;
    return (on_device ? stage_ : cpu_stage_).step(columns, count, rules_, team, directions_);
}

}  // namespace zoned::physics
