// Scene: the rigid bodies of one zone; add bodies, step, read states, contacts and queries.
#pragma once

#include "server/physics/joints/joint.h"
#include "server/physics/query/query.h"
#include "server/physics/settings/physics_settings.h"
#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"
#include "shared/core/state_hash.h"
#include "shared/math/aabb.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::compute {
class Team;
}

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::physics {

class RowSystem;
struct JointState;

/// Times are measured by the caller (no clock in here); counts of one step.
struct StepStats {
    std::uint32_t bodies = 0;
    std::uint32_t awake = 0;     ///< dynamic bodies awake after the step
    std::uint32_t pairs = 0;     ///< broadphase pairs
    std::uint32_t contacts = 0;  ///< contact points
    std::uint32_t islands = 0;
    std::uint32_t substeps = 0;  ///< of the island that got most
    /// Contact points and joints, each times the passes over it: substeps of its island times
    /// iterations. Islands that are solved exactly count once.
    std::uint64_t contact_sweeps = 0;
    std::uint64_t joint_sweeps = 0;
    std::uint32_t quarantined = 0;  ///< bodies stopped because their state became not finite
    std::uint32_t unpaired = 0;   ///< bodies whose pairs wait because of PhysicsSettings::max_pairs
    std::uint32_t particles = 0;  ///< awake after the step
    /// Islands in which a contact or joint asked for more substeps than there are: it keeps the
    /// error budget no longer (masses too different, springs too stiff, steps too long).
    std::uint32_t substep_limited = 0;
    std::uint32_t far_bodies = 0;  ///< moving ones, so far out that floats are too coarse there
    std::uint32_t held_back = 0;   ///< bodies that would have passed through static geometry
    std::uint32_t slowed = 0;      ///< bodies whose speed or spin was cut to the most there is
    bool skipped = false;          ///< nothing was awake: no pass ran
    VariantStats method;           ///< of the alternatives to kSoftStep
};

/// A contact of this step between bodies with user tags that began, carried a large impulse, or was
/// asked for by one of the bodies with BodyDef::events.
struct ContactEvent {
    BodyId a;
    BodyId b;
    std::uint32_t user_a = 0;
    std::uint32_t user_b = 0;
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitY();  ///< from a to b
    float impulse = 0.0F;         ///< sum of normal impulses in this step, N s
    float approach_speed = 0.0F;  ///< closing speed along the normal before the solve, m/s
    bool began = false;
    bool ended = false;  ///< impulse and depth say nothing; neither began nor ended: it lasts
    float depth = 0.0F;  ///< overlap at the point, m
};

/// A body came into a sensor or left it: they overlap at the start of the step, or no longer do.
/// One of the two is a sensor or has a part that is. Sensors sense the bodies that a contact would
/// push: at least one of the two is dynamic. A body that flies through within a step is not seen.
struct SensorEvent {
    BodyId a;  ///< may have been removed since
    BodyId b;
    std::uint32_t user_a = 0;
    std::uint32_t user_b = 0;
    bool entered = false;
};

using RayHit = QueryHit;

struct BodyState {
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
    Vec3 velocity = Vec3::Zero();
    Vec3 angular_velocity = Vec3::Zero();
    bool asleep = false;
};

/// The past of a body that its next steps depend on, besides its state.
struct BodyHistory {
    float still_s = 0.0F;               ///< how long it has been slower than the sleep speeds
    float settled_s = 0.0F;             ///< how long it has stayed near one place
    Vec3 settled_shift = Vec3::Zero();  ///< how far it is from there, m
    Quat settled_turn = Quat::Identity();
    std::uint8_t substep_level = 0;     ///< of its island in the last step
    std::uint8_t substep_patience = 0;  ///< steps until its island may go down a level
};

/// The simulated form of a body that forces move.
enum class BodyRepresentation : std::uint8_t {
    kFull,
    kParticle,
};

/// Deterministic: the same calls in the same order give the same bits. No allocation in step()
/// after warm-up.
class Scene {
  public:
    explicit Scene(const PhysicsSettings& settings);
    Scene(Scene&&) noexcept;
    Scene& operator=(Scene&&) noexcept;
    ~Scene();

    /// Refuses numbers that are not finite, sizes or masses that are not positive, quaternions far
    /// from unit length.
    core::Result<BodyId> add(const BodyDef& def);
    void remove(BodyId body);  ///< wakes the bodies that touched it; its joints go with it
    [[nodiscard]] bool contains(BodyId body) const;
    /// The tag that the body was added with.
    [[nodiscard]] std::uint32_t user(BodyId body) const;

    [[nodiscard]] BodyState state(BodyId body) const;
    /// Teleports; wakes the body and those that touched it.
    void set_state(BodyId body, const BodyState& state);
    /// For a body that goes on in another scene. Joints are made before the history is set, because
    /// they wake.
    [[nodiscard]] BodyHistory history(BodyId body) const;
    void set_history(BodyId body, const BodyHistory& history);
    /// Kinematic and dynamic bodies; wakes a sleeping body unless the change is exactly zero.
    void set_velocity(BodyId body, const Vec3& velocity, const Vec3& angular_velocity);
    /// Impulse in N s at a world point; wakes the body. Ignored for static and kinematic bodies.
    void apply_impulse(BodyId body, const Vec3& impulse, const Vec3& point);
    /// Force in N at a world point, or at the centre of mass, and torque in N m: they act through
    /// the next step and are gone after it; several add up. Wakes the body. Ignored for static and
    /// kinematic bodies; one that is not finite stops the body (see StepStats::quarantined).
    void apply_force(BodyId body, const Vec3& force, const Vec3& point);
    void apply_force(BodyId body, const Vec3& force);
    void apply_torque(BodyId body, const Vec3& torque);
    /// How much velocity along the unit vector `direction` the body gets at a world point per
    /// impulse in that direction there, 1/kg; 0 for static and kinematic bodies.
    [[nodiscard]] float response(BodyId body, const Vec3& point, const Vec3& direction) const;
    void wake(BodyId body);
    /// Sets which bodies the body meets from the next step on. Contacts that the filters no longer
    /// allow end. A body that it overlaps and now meets is pushed out as other overlaps are. Wakes
    /// the body, bodies that it touched and has to let go, and bodies that a static or kinematic
    /// body now meets.
    void set_filter(BodyId body, const Filter& filter);
    /// Turns a dynamic body into a particle or back; wakes it. Position, velocity, id and tag stay;
    /// orientation and spin are kept frozen while it is a particle. A particle that becomes a body
    /// again is lifted out of static and kinematic bodies that it would overlap. Fails with the
    /// reason for other kinds, sensors, and bodies with joints.
    core::Result<BodyState> set_representation(BodyId body, BodyRepresentation representation);

    /// Another shape about the same centre and axes, for a body that forces move and that is no
    /// particle; mass, moments, material, pose, motion and id stay. Wakes it and the bodies that
    /// touched it. A body that would overlap static and kinematic bodies is lifted out of them.
    /// Fails with the reason where there is no such body or it cannot have the shape.
    core::Result<BodyState> set_shape(BodyId body, const Shape& shape);
    /// Whether it touched another body that can move in the last step.
    [[nodiscard]] bool touches_bodies(BodyId body) const;

    /// Refuses bodies that are not there, two bodies of which none is dynamic, a body and itself,
    /// and numbers that are not finite or out of range; gives the reason. Wakes both bodies.
    core::Result<JointId> add_joint(const JointDef& def);
    /// The same, but the points and axes of the definition hold, and angles and shifts are zero,
    /// with the bodies at the poses `a` and `b` (of the world: the identity), wherever they are
    /// now.
    core::Result<JointId> add_joint(const JointDef& def, const Frame& a, const Frame& b);
    void remove_joint(JointId joint);  ///< wakes both bodies
    [[nodiscard]] bool contains(JointId joint) const;
    /// Angle of a hinge from where it was made, rad in (-pi, pi]; shift of a slider, m; length of a
    /// distance or spring, m; gap of a ball or fixed joint, m.
    [[nodiscard]] float joint_position(JointId joint) const;
    [[nodiscard]] float joint_force(JointId joint) const;  ///< of the last step, N
    /// Takes speed and greatest force of a motor; wakes both bodies. Does nothing and says false
    /// where they are not finite or out of range.
    bool set_motor(JointId joint, float speed, float most);
    /// The state that a joint carries from step to step, for one like it between the same bodies in
    /// another scene. Its motor is set before its state.
    [[nodiscard]] const JointState& joint_state(JointId joint) const;
    void set_joint_state(JointId joint, const JointState& state);
    /// Adds the joints whose bodies are awake to a hash: the impulses and errors that they carry.
    void hash_joints(core::StateHash& hash) const;
    /// Joints that broke in the last step.
    [[nodiscard]] std::span<const JointBreak> joint_breaks() const;

    /// The thread that calls step() leads it, and the threads of the team help where there is much
    /// to do. The result is the same for any number of threads. The team must outlive the scene, or
    /// be taken back by nullptr.
    void work_with(compute::Team* team);

    StepStats step(float dt);

    /// Bodies whose state changed in the last step (awake dynamic and moving kinematic ones, and
    /// those that fell asleep in it), ascending.
    [[nodiscard]] std::span<const BodyId> moved() const;
    [[nodiscard]] std::span<const ContactEvent> contact_events() const;
    /// Of the last step, and of the changes to the bodies before it.
    [[nodiscard]] std::span<const SensorEvent> sensor_events() const;

    /// Rays, moving shapes, overlaps and nearest bodies: see query.h.
    [[nodiscard]] Query query() const;
    /// Nearest hit of a ray within `max_distance`; `ignore_user` is passed through (0 = nobody).
    /// Static, kinematic and dynamic bodies, no sensors.
    [[nodiscard]] bool ray_cast(const Vec3& origin,
                                const Vec3& direction,
                                float max_distance,
                                std::uint32_t ignore_user,
                                RayHit& hit) const;
    /// Appends bodies whose bounding box overlaps `area`, ascending.
    void overlap(const Aabb& area, std::vector<BodyId>& out) const;

    /// The rows of the last step's first solve as they were before it, where
    /// VariantSettings::keep_problem asks for them; null otherwise. Valid until the next step. For
    /// benchmarks, which give one problem to all solvers.
    [[nodiscard]] const RowSystem* problem() const;

    [[nodiscard]] std::uint32_t body_count() const;
    [[nodiscard]] std::uint32_t awake_count() const;  ///< that forces move, particles too
    /// The bodies connected to `body` by contacts of the last step through dynamic bodies, itself
    /// included, ascending.
    void island_of(BodyId body, std::vector<BodyId>& out) const;

    void hash(core::StateHash& hash) const;

    /// All that later steps depend on, between two steps. The archive lends a GeometryTable.
    void save(core::FieldWriter& archive) const;
    /// Takes the place of everything here; the settings are those of the scene that was saved.
    /// After a fault of the archive the scene is of no use.
    void load(core::FieldReader& archive);

  private:
    friend class Query;

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::physics
