#include "tests/bench/motion_traces.h"

#include "shared/core/rng.h"

#include <cmath>
#include <numbers>

namespace zoned::bench {

namespace {

constexpr float kTracedTick = 1.0F / 30.0F;

world::EntityType traced_ball() {
    world::EntityType type;
    type.name = "ball";
    type.shape = world::TypeShape::kSphere;
    type.radius = 0.25F;
    type.max_velocity_jump_mps = 20.0F;
    return type;
}

MotionTrace empty_trace(const std::string& motion, const world::EntityType& type) {
    MotionTrace trace;
    trace.motion = motion;
    trace.tick_s = kTracedTick;
    trace.type = type;
    trace.ground = std::make_shared<const motion::StaticGeometry>();
    return trace;
}

/// One body of orbit_trace.
struct DriftingOrbit {
    Vec3 centre;
    Vec3 drift;
    Vec3 axis;
    Vec3 arm;  // from the centre at time 0, across the axis
    float rate = 0.0F;
    Vec3 spin;

    [[nodiscard]] TracedState at(float t) const {
        const Vec3 r = Eigen::AngleAxisf(rate * t, axis) * arm;
        TracedState s;
        s.state.position = centre + drift * t + r;
        s.state.velocity = drift + rate * axis.cross(r);
        s.state.acceleration = -rate * rate * r;
        s.state.angular_velocity = spin;
        const float turn = spin.norm();
        if (turn > 0.0F) {
            s.state.orientation = Quat(Eigen::AngleAxisf(turn * t, spin / turn));
        }
        return s;
    }
};

Vec3 any_direction(core::Rng& rng) {
    const float y = rng.range(-1.0F, 1.0F);
    const float turn = rng.range(0.0F, 2.0F * std::numbers::pi_v<float>);
    const float flat = std::sqrt(1.0F - y * y);
    return {flat * std::cos(turn), y, flat * std::sin(turn)};
}

Vec3 any_place(core::Rng& rng, float extent) {
    const float x = rng.range(-extent, extent);
    return {x, 0.0F, rng.range(-extent, extent)};
}

}  // namespace

MotionTrace orbit_trace(int entities, int ticks) {
    MotionTrace trace = empty_trace("orbit", traced_ball());
    trace.type.max_acceleration_mps2 = 60.0F;  // 10 m at 2 rad/s are 40 m/s2
    core::Rng rng(250);
    std::vector<DriftingOrbit> orbits;
    for (int i = 0; i < entities; ++i) {
        DriftingOrbit o;
        o.centre = any_place(rng, 100.0F) + Vec3(0.0F, 50.0F, 0.0F);
        o.axis = any_direction(rng);
        o.arm = o.axis.cross(any_direction(rng)).normalized() * rng.range(1.0F, 10.0F);
        o.rate = rng.range(0.5F, 2.0F);
        o.drift = rng.range(0.0F, 1.0F) * any_direction(rng);
        if (i % 3 == 0) {
            o.drift += rng.range(-3.0F, 3.0F) * o.axis;
        }
        o.spin = rng.range(0.0F, 3.0F) * any_direction(rng);
        orbits.push_back(o);
    }
    for (int tick = 0; tick < ticks; ++tick) {
        auto& frame = trace.frames.emplace_back();
        for (const DriftingOrbit& orbit : orbits) {
            frame.push_back(orbit.at(static_cast<float>(tick) * kTracedTick));
        }
    }
    return trace;
}

MotionTrace throw_trace(int entities, int ticks) {
    MotionTrace trace = empty_trace("throw", traced_ball());
    constexpr int kEvery = 60;
    core::Rng rng(251);
    std::vector<TracedState> now(static_cast<std::size_t>(entities));
    for (TracedState& s : now) {
        s.state.position = any_place(rng, 50.0F);
        s.state.position.y() = trace.type.radius;
        s.at_rest = true;
    }
    const Vec3 pull(0.0F, -trace.gravity_mps2, 0.0F);
    for (int tick = 0; tick < ticks; ++tick) {
        for (std::size_t i = 0; i < now.size(); ++i) {
            TracedState& s = now[i];
            const Vec3 before = s.state.velocity;
            if ((tick + static_cast<int>(i) * 7) % kEvery == 0) {
                s.state.velocity = rng.range(1.0F, 6.0F) * any_direction(rng);
                s.state.velocity.y() = rng.range(2.0F, 8.0F);
                s.at_rest = false;
            }
            if (!s.at_rest) {
                s.state.velocity += pull * kTracedTick;
                s.state.position += s.state.velocity * kTracedTick;
            }
            if (s.state.position.y() < trace.type.radius) {
                s.state.position.y() = trace.type.radius;
                s.state.velocity.setZero();
                s.at_rest = true;
            }
            s.state.acceleration =
                s.at_rest ? Vec3(Vec3::Zero()) : Vec3((s.state.velocity - before) / kTracedTick);
        }
        trace.frames.push_back(now);
    }
    return trace;
}

MotionTrace walk_trace(int entities, int ticks) {
    world::EntityType type;
    type.name = "walker";
    type.kind = world::EntityKind::kCharacter;
    type.shape = world::TypeShape::kCapsule;
    type.max_acceleration_mps2 = 40.0F;
    MotionTrace trace = empty_trace("walk", type);
    constexpr float kSpeed = 4.0F;
    constexpr float kStep = 20.0F * kTracedTick;  // of velocity, in a tick
    core::Rng rng(252);
    std::vector<TracedState> now(static_cast<std::size_t>(entities));
    std::vector<Vec3> wanted(now.size(), Vec3::Zero());
    std::vector<int> until(now.size(), 0);
    for (TracedState& s : now) {
        s.state.position = any_place(rng, 50.0F);
    }
    for (int tick = 0; tick < ticks; ++tick) {
        for (std::size_t i = 0; i < now.size(); ++i) {
            motion::KinematicState& s = now[i].state;
            if (tick >= until[i]) {
                until[i] = tick + 30 + static_cast<int>(rng.below(61));
                const float turn = rng.range(0.0F, 2.0F * std::numbers::pi_v<float>);
                wanted[i] = kSpeed * Vec3(std::sin(turn), 0.0F, std::cos(turn));
                s.orientation = Quat(Eigen::AngleAxisf(turn, Vec3::UnitY()));
            }
            const Vec3 missing = wanted[i] - s.velocity;
            const float size = missing.norm();
            const Vec3 change = size > kStep ? Vec3(missing * (kStep / size)) : missing;
            s.velocity += change;
            s.acceleration = change / kTracedTick;
            s.position += s.velocity * kTracedTick;
        }
        trace.frames.push_back(now);
    }
    return trace;
}

}  // namespace zoned::bench
