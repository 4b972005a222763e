// ParticleFlock: particles that steer by their neighbours instead of falling: birds, fish, insects.
#pragma once

#include "server/compute/stages/flock_stage.h"
#include "shared/math/types.h"

#include <cstddef>
#include <string>
#include <vector>

namespace zoned::compute {
class Device;
}

namespace zoned::physics {

/// The three rules of Reynolds ("Flocks, herds, and schools", SIGGRAPH 1987) with their weights, a
/// home and a path. SI units, coordinates of the zone.
struct FlockDef {
    float radius = 5.0F;              ///< m, > 0: animals within it are neighbours
    float separation_radius = 1.5F;   ///< m, 0..radius: animals within it push off each other
    float separation = 4.0F;          ///< m2/s2: acceleration times distance, of each of these
    float alignment = 1.0F;           ///< 1/s: how fast velocities become that of the neighbours
    float cohesion = 0.5F;            ///< 1/s2: acceleration over the distance to their middle
    float most_acceleration = 15.0F;  ///< m/s2, of all this together, > 0
    float least_speed = 4.0F;         ///< m/s, >= 0, within the box
    float most_speed = 12.0F;         ///< m/s, >= least_speed, > 0
    Vec3d low = Vec3d::Zero();        ///< m, of the box that is its home
    Vec3d high = Vec3d::Ones();       ///< m, above low
    float turn_back = 10.0F;          ///< m/s2, outside of the box
    std::vector<Vec2d> path;          ///< x, z in m, that it flies along; none, or two and more
    bool closed = false;              ///< whether the path leads from its end to its beginning
    float path_width = 20.0F;         ///< m beside it where an animal turns by 45 degrees, > 0
    float follow = 0.5F;              ///< 1/s: how fast velocities turn along the path, > 0
};

/// Why a flock is refused ("radius: must be above 0"); empty: it is not.
std::string unfit(const FlockDef& def);

/// The rules without a step length.
kernels::FlockRules flock_rules_of(const FlockDef& def);

/// Moves the animals of one particle system. Has no state but theirs.
class Flock {
  public:
    /// `def` is fit. No device: null.
    Flock(const FlockDef& def, compute::Device* device);

    /// Another device from now on, or none.
    void use_device(compute::Device* device) { stage_ = compute::FlockStage(device); }

    /// One step of h seconds of the first `count` columns. The same bits on either side and for
    /// any number of threads.
    compute::StageRun step(compute::ParticleColumns& columns,
                           std::size_t count,
                           float h,
                           bool on_device,
                           compute::Team& team);

  private:
    kernels::FlockRules rules_;
    std::vector<float> directions_;
    compute::FlockStage stage_;
    compute::FlockStage cpu_stage_;
};

}  // namespace zoned::physics
