// World: a scene that is checked after each step, from outside and in double precision.
#pragma once

#include "server/physics/scene/scene.h"
#include "tests/scenario/physics_scenes.h"
#include "tests/stability/run.h"

#include <optional>
#include <string>
#include <vector>

namespace zoned::stability {

using physics::BodyDef;
using physics::BodyKind;
using physics::BodyState;
using physics::JointDef;
using physics::JointKind;
using physics::Shape;

inline constexpr float kFrame = 1.0F / 60.0F;
inline constexpr double kG = 9.81;           ///< m/s2
inline constexpr double kGive = 0.005;       ///< of a contact (Settings::error_budget_m), m
inline constexpr double kPush = 3.0;         ///< speed at which a contact undoes an overlap, m/s
inline constexpr double kUndo = 20.0;        ///< speed at which a joint undoes its gap, m/s
inline constexpr float kUndoTime_s = 0.05F;  ///< within which it undoes a small one

/// The limits of a world; a limit that is not set is not checked. Two checks always run: all values
/// are finite, and no body is stopped that should not be.
struct Limits {
    std::optional<double> speed_mps;
    /// Energy above the initial and added energy, as a share of it. Counted are kinetic energy and
    /// that of height above `World::floor_y` when the bodies were added.
    std::optional<double> energy_share;
    std::optional<double> depth_m;  ///< of spheres, boxes and capsules
    std::optional<double> drift_m;  ///< of dynamic bodies from where they were added
    /// Change of linear and angular momentum as a share of the sum of their sizes at the start.
    std::optional<double> momentum_share;
    std::optional<Aabb> inside;  ///< centres of dynamic bodies stay in there
    double quarantined = 0.0;
};

class World {
  public:
    World(Run& run,
          std::string name,
          std::string parameter,
          const physics::PhysicsSettings& settings = {});

    /// Adds a body, which must be accepted, and counts its energy as initial.
    BodyId add(const BodyDef& def);
    void remove(BodyId id);
    JointId join(const JointDef& def);
    /// A static box.
    BodyId wall(const Vec3& centre, const Vec3& half_extents, float friction = 0.5F);
    /// Static box whose top is y = 0.
    void ground(float half_width = 50.0F, float friction = 0.5F);
    /// Six walls of 2 m about the space from -half to half in x and z and from 0 to height; bodies
    /// have to stay in it.
    void room(float half, float height, float friction = 0.5F);

    /// A body as the checks see it: with the deliberate fault, if it is the first dynamic one.
    [[nodiscard]] BodyState watch(BodyId id) const;
    /// The same of a joint's position (Scene::joint_position), if it is the first one; infinite
    /// where the joint is gone.
    [[nodiscard]] double joint_at(JointId id) const;

    /// The number of joints that are gone. No test takes one out, so they broke by themselves. The
    /// deliberate fault counts the first one as gone.
    [[nodiscard]] double joints_gone() const;

    /// Kinetic energy and that of height above `floor_y`, in the last step, J.
    [[nodiscard]] double energy() const { return energy_; }

    /// Thread CPU time of the last step, ms.
    [[nodiscard]] double step_ms() const { return step_ms_; }

    /// Pairs of the broadphase in the last step.
    [[nodiscard]] std::uint32_t pairs() const { return pairs_; }

    /// The deepest overlap as it is now, m.
    [[nodiscard]] double depth_now() const;

    /// Energy put in from outside, J.
    void supply(double energy) { energy_there_ += energy; }

    /// Steps and checks. False when the world is so broken that more steps would show nothing.
    bool step(float dt = kFrame);
    void run(float seconds, float dt = kFrame);
    /// The verdict.
    void finish();

    physics::Scene scene;
    Limits limits;
    float floor_y = 0.0F;
    /// Overlaps are measured once in this many steps; 0: as the count of bodies allows.
    int look_every = 0;
    /// From this step on speed counts, e.g. after thrown bodies have hit.
    std::uint64_t speed_from = 0;
    /// Deliberate faults begin after this step.
    std::uint64_t fault_at = 20;
    Row row;

    struct Known {
        BodyId id;
        BodyDef def;
        Vec3d moments;
        bool solid = false;  ///< a shape whose overlaps can be measured
        Vec3d start;
    };

    [[nodiscard]] const std::vector<Known>& bodies() const { return bodies_; }

    /// Highest speed of a dynamic body in the last step, m/s.
    [[nodiscard]] double speed() const { return speed_; }

  private:
    struct Sums {
        double energy = 0.0;
        Vec3d linear = Vec3d::Zero();
        Vec3d angular = Vec3d::Zero();
        double size = 0.0;          ///< of the terms of the linear momentum
        double angular_size = 0.0;  ///< and of the angular one
    };

    void look();
    [[nodiscard]] BodyState read(const Known& body, bool& spoilt) const;
    void take_motion(const Known& body, const BodyState& s, Sums& sums) const;

    [[nodiscard]] bool faulty() const { return row.steps > fault_at; }

    [[nodiscard]] double deepest(const std::vector<BodyState>& states) const;

    Run& run_;
    Vec3d gravity_;
    std::vector<Known> bodies_;
    std::vector<JointId> joints_;
    double energy_ = 0.0;        ///< J, in the last step
    double step_ms_ = 0.0;       ///< of the last step
    std::uint32_t pairs_ = 0;    ///< of the last step
    double energy_there_ = 0.0;  ///< J, above `reference`
    double scale_ = 0.0;         ///< J
    std::optional<Sums> start_;
    double momentum_share_ = 0.0;
    std::uint64_t not_finite_ = 0;
    std::uint64_t escaped_ = 0;
    double speed_ = 0.0;
    double cpu_ms_ = 0.0;
    std::int64_t told_ns_ = 0;
};

/// A dynamic body of that shape at rest; mass 1, friction 0.5.
BodyDef body_of(const Shape& shape, float mass, const Vec3& position);

physics::PhysicsSettings weightless();

/// A number without its decimals.
std::string whole(double x);

/// Sphere, box or capsule of about one metre by i mod 3, as in the piles.
BodyDef mixed_body(int i, const Vec3& position, float scale = 1.0F);

}  // namespace zoned::stability
