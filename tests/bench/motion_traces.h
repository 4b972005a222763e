// MotionTraces: recorded and analytic motions of many entities, for the replication benchmarks.
#pragma once

#include "server/world/entity_type.h"
#include "shared/motion/kinematic_state.h"
#include "shared/motion/static_geometry.h"

#include <memory>
#include <string>
#include <vector>

namespace zoned::bench {

/// One entity at one tick, with the values that its own simulation knew.
struct TracedState {
    motion::KinematicState state;
    bool at_rest = false;
};

struct MotionTrace {
    std::string motion;  ///< its name in rows
    float tick_s = 1.0F / 30.0F;
    world::EntityType type;  ///< of all entities
    float gravity_mps2 = kGravity;
    std::shared_ptr<const motion::StaticGeometry> ground;
    std::vector<std::vector<TracedState>> frames;  ///< [tick][entity]
};

/// Bodies around centres that drift: radii of 1 to 10 m, a third of them on helices; 30 Hz.
MotionTrace orbit_trace(int entities, int ticks);

/// Balls thrown every two seconds onto level ground, which stops them; 30 Hz. Flight is
/// semi-implicit Euler, as the physics flies.
MotionTrace throw_trace(int entities, int ticks);

/// Walkers at 4 m/s who take a new direction every 1 to 3 s and turn to it with 20 m/s2; 30 Hz.
MotionTrace walk_trace(int entities, int ticks);

/// The cubes of cubes901_`which` ("A" or "B"), 60 Hz. The trace has no velocities: central
/// differences over four frames stand for what its simulation knew. Its positions are on a grid of
/// 1/512 m, so these velocities are off by 0.015 m/s rms. There are no frames where the data is
/// missing (`why` gives the reason).
MotionTrace cubes_trace(const std::string& which, int ticks, std::string& why);

/// The world of config/valley.txtpb without players, simulated by its zones; 30 Hz. With
/// `characters`, the walking characters; else the props, each thrown once, in turn, by up to 6 m/s.
/// Entities that stay in their zone all the time, at most `most`.
MotionTrace valley_trace(bool characters, std::size_t most, int ticks);

}  // namespace zoned::bench
