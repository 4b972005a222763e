// Scene::Impl: the parts of a Scene; shared by the files that implement its parts.
#pragma once

#include "server/compute/team.h"
#include "server/physics/bodies/bodies.h"
#include "server/physics/contacts/contact_graph.h"
#include "server/physics/contacts/islands.h"
#include "server/physics/joints/joint_table.h"
#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/solver/contact_solver.h"
#include "server/physics/solver/substep_policy.h"
#include "server/physics/solver/torn_islands.h"
#include "server/spatial/box_index.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace zoned::physics {

class VariantStepper;

struct Scene::Impl {
    explicit Impl(const PhysicsSettings& s);
    ~Impl();

    /// A change of a pair to report.
    enum class TouchChange : std::uint8_t {
        kNone,
        kBegan,
        kLasts,
        kEnded
    };

    PhysicsSettings settings;
    compute::Team alone;           ///< of the caller only
    compute::Team* team = &alone;  ///< the threads that work at a step
    Bodies bodies;
    ContactGraph graph;
    JointTable joints;
    /// By row: holds the body in the same way as its fat box does. Boxes about round or slanting
    /// bodies overlap at their corners where no body is: in a pile a third of all pairs.
    std::vector<Ball> fat_balls;
    /// Fat boxes by BodyKind. Pairs within the static and within the kinematic ones are never
    /// looked for.
    std::array<spatial::BoxIndex, 3> boxes;
    spatial::BoxGrid resting;                ///< particles asleep
    std::vector<std::uint32_t> disturbed;    ///< scratch: bodies to wake
    std::vector<std::uint32_t> planes;       ///< rows of half-spaces, which have no box
    std::vector<std::uint32_t> pending;      ///< rows whose fat box is new, and stale ones
    std::vector<std::uint8_t> pending_mark;  ///< by row: its fat box is new since pairs were found
    std::uint32_t unpaired = 0;  ///< bodies still pending, because there are too many pairs
    SubstepPolicy substep_policy;
    TornIslands torn;
    ContactSolver solver;
    std::unique_ptr<VariantStepper> stepper;  ///< null with SolverVariant::kSoftStep
    std::unique_ptr<VariantStepper>
        exact;                       ///< for islands that SubstepPolicy leaves to it, else null
    PhysicsSettings exact_settings;  ///< of those
    Islands islands;
    Waker waker;
    std::vector<ContactEvent> events;
    std::vector<ContactEvent> left_contacts;  ///< ended between steps: reported by the next one
    std::vector<JointBreak> breaks;
    std::vector<SensorEvent> sensor_events;
    std::vector<SensorEvent> left_sensors;  ///< between steps: reported by the next one
    ContactSet parts;                       ///< scratch of find_chain
    std::vector<BodyId> moved;
    std::vector<std::uint32_t> stopped;  ///< rows put to sleep within the step
    std::uint32_t substeps = 0;          ///< most that an island got in this step
    std::uint64_t contact_sweeps = 0;    ///< of this step, see StepStats
    std::uint64_t joint_sweeps = 0;      ///< the same
    std::uint32_t substep_limited = 0;   ///< the same
    std::uint32_t far_bodies = 0;
    std::uint32_t held_back = 0;
    std::uint32_t quarantined = 0;  ///< since the last step began

    std::array<std::size_t, 4> kind_counts{};  ///< bodies by kind
    std::array<std::size_t, 4> room{};         ///< for how many of them there is room

    // Scratch of a step, kept for its capacity.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> new_pairs;
    std::vector<std::uint32_t> solve_list;
    std::vector<std::uint32_t> active_joints;  ///< with an awake dynamic body
    std::vector<std::uint32_t> broken;
    std::vector<TouchChange> touch_changes;  ///< of the step, by place in ContactGraph::active
    std::vector<std::uint8_t> in_contact;    ///< by row: a contact holds it in this step
    std::vector<StepStart> starts;           ///< by row: as it was before the solve
    std::vector<std::uint32_t> passed;       ///< rows that passed a surface in the last solve
    std::vector<std::uint32_t> guards;       ///< contacts of this step that keep them from it

    /// A surface that presses on a body.
    struct Press {
        Vec3 normal = Vec3::Zero();  ///< into the body
        float blow_mps = 0.0F;       ///< by its speed and what bounces
        bool moves = false;          ///< it is a mover's
    };

    std::vector<std::uint32_t> squeezed;  ///< rows that movers may press on
    std::vector<Press> presses;           ///< of one of them
    std::vector<std::uint32_t> refitted;  ///< rows whose new fat box still has to go into `boxes`
    mutable std::vector<std::uint8_t> marks;  ///< of island_of, all zero between calls

    [[nodiscard]] spatial::BoxIndex& boxes_of(std::uint32_t row) {
        return boxes[static_cast<std::size_t>(bodies.kind[row])];
    }

    [[nodiscard]] Placed placed(std::uint32_t row) const {
        return {bodies.shape[row], bodies.position[row], bodies.rotation[row]};
    }

    // scene_bodies.cpp
    /// Makes room, as bodies are added, for what steps will need: then steps allocate only where
    /// bodies are packed closer than kContactsPerBody says.
    void make_room(BodyKind kind);
    void reserve_room(BodyKind kind);
    /// For the bodies that are there, once they were loaded.
    void reserve_all_room();
    void enter_broadphase(std::uint32_t row);
    void leave_broadphase(std::uint32_t row);
    /// Ends a pair, and wakes the other body where they touched.
    void drop_pair(std::uint32_t contact, std::uint32_t other);
    /// Ends all contacts of a body and wakes the bodies that touched it.
    void drop_contacts(std::uint32_t row);
    /// Moves a body at once. Wakes the bodies that it touched; contacts live on where the bodies
    /// stay near each other, so that a small correction is no new touch.
    void teleport(std::uint32_t row, const Vec3& x, const Quat& q);
    void set_velocity(std::uint32_t row, const Vec3& velocity, const Vec3& spin);
    void push(std::uint32_t row, const Vec3& impulse, const Vec3& moment);
    void add_force(std::uint32_t row, const Vec3& force, const Vec3& torque);
    /// Stops a body and puts it to sleep.
    void stop(std::uint32_t row);
    /// Stops a body, puts it to sleep and counts it.
    void quarantine(std::uint32_t row);
    void wake(std::uint32_t row);

    // scene_pairs.cpp
    void set_filter(std::uint32_t row, const Filter& filter);
    void drop_unmet_pairs(std::uint32_t row);
    void wake_who_is_met(std::uint32_t row, const Filter& before);
    void refresh_bounds(float dt);
    void find_pairs(float dt);
    void sort_pending();
    void drop_far_pairs();
    [[nodiscard]] bool found_before(std::uint32_t row, std::uint32_t other) const;
    void meet(std::uint32_t row, std::uint32_t other);
    void meet_fixed(std::uint32_t row);
    void meet_kind(std::uint32_t row, BodyKind kind);
    template <class Meet>
    std::size_t meet_each(std::size_t count, std::size_t most, Meet&& meet_all);
    void fit_bounds_at_rest(std::uint32_t row);
    void mark_pending(std::uint32_t row);
    void hand_over_boxes(BodyKind kind);
    [[nodiscard]] bool near(std::uint32_t a, std::uint32_t b) const;
    void follow_bounds();

    // scene_contacts.cpp
    void update_contacts(float dt);
    void update_contact(std::uint32_t contact, float dt);
    void update_pair(std::uint32_t contact, float dt);
    void take_part(std::uint32_t contact);
    [[nodiscard]] PairMotion motion_of(std::uint32_t a, std::uint32_t b, float dt) const;
    bool reuse_manifold(std::uint32_t contact, const PairMotion& motion);
    void find_manifold(std::uint32_t contact, const PairMotion& motion);
    void approach(std::uint32_t record, const PairMotion& motion);
    void settle_contacts();
    TouchChange settle_pair(std::uint32_t contact);
    [[nodiscard]] TouchChange touch_change_of(const Pair& pair, bool touched, float impulse) const;
    void report_contacts();
    [[nodiscard]] ContactEvent contact_event(std::uint32_t contact) const;
    /// The pair is about to be forgotten: if it touches and a body asked for events, that is one.
    void end_touch(std::uint32_t contact, std::vector<ContactEvent>& out);

    // scene_joints.cpp
    [[nodiscard]] JointPose pose_of(std::uint32_t row) const;
    /// The poses are those at which the definition holds.
    core::Result<JointId> add_joint(const JointDef& def,
                                    const JointPose& pose_a,
                                    const JointPose& pose_b);
    void drop_joint(std::uint32_t index);
    void wake_joint(std::uint32_t index);
    /// Wakes the bodies that joints hold to this one.
    void wake_joined(std::uint32_t row);
    void wake_joined_to_movers();
    void list_joints();
    void break_joints();
    // scene_manifolds.cpp
    /// Finds out what sort of pair it is.
    void classify(std::uint32_t contact);
    void update_chain(std::uint32_t contact, const PairMotion& motion);
    void find_chain(std::uint32_t contact, const PairMotion& motion);

    // scene_sensors.cpp
    void look_into_sensor(std::uint32_t contact);
    void note_sensing(std::uint32_t contact);
    void end_sensing(std::uint32_t contact, std::vector<SensorEvent>& out);
    [[nodiscard]] SensorEvent sensor_event(std::uint32_t contact) const;

    // scene_particles.cpp
    struct ParticleFlight;
    struct Bump;
    void step_particles(float dt);
    void step_particle(std::uint32_t row, float dt);
    /// Kept apart from the code of particles that fly by the default.
    [[nodiscard, gnu::noinline, gnu::cold]] bool bend_flight(std::uint32_t row,
                                                             const Vec3& pull,
                                                             float dt,
                                                             ParticleFlight& flight) const;
    [[nodiscard]] bool meets_particle(std::uint32_t row, std::uint32_t other) const;
    void find_bump(std::uint32_t row, const ParticleFlight& flight, Bump& bump) const;
    void find_moving_bump(std::uint32_t row,
                          const ParticleFlight& flight,
                          float dt,
                          Bump& bump) const;
    void ride(std::uint32_t row, const Bump& bump, const Vec3& from, ParticleFlight& flight) const;
    void land(std::uint32_t row, const Bump& bump, float time, ParticleFlight& flight) const;
    void bounce(std::uint32_t row, const Bump& bump, ParticleFlight& flight) const;
    void rest_particle(std::uint32_t row);
    /// Wakes the particles that rest on or near a body.
    void disturb_particles(std::uint32_t row);
    void lift_out(std::uint32_t row);
    template <class Change>
    void exchange(std::uint32_t row, Change&& change);
    [[nodiscard]] float deepest_overlap(std::uint32_t row, std::uint32_t other, Vec3& out);

    // scene_solve.cpp
    void solve(float dt);
    void mark_held();
    void solve_by_substep_policy(float dt);
    void solve_batch(const SubstepPolicy::SubstepBatch& batch, float dt);
    void count_sweeps(std::span<const std::uint32_t> contacts,
                      std::size_t joints_here,
                      std::uint64_t passes);
    /// Solves islands with joints, those that it tears again with more substeps.
    void solve_jointed(const SubstepPolicy::SubstepBatch& batch, float dt);
    /// False, and nothing is changed, where there is no exact answer.
    bool solve_exactly(std::span<const std::uint32_t> contacts, float dt);
    /// The solve by an alternative to ContactSolver; writes `broken`.
    void solve_by_variant(float dt);

    // scene_squeeze.cpp
    void limit_squeezed(float dt);
    void list_presses(std::uint32_t row);
    [[nodiscard]] float fastest_squeeze() const;
    void slow_squeezed(std::uint32_t row, float blow_mps, float dt);

    // scene_tunnelling.cpp
    void note_starts();
    /// Takes back motion of the solve through static geometry.
    void hold_back(float dt);
    struct GuardedPoint;
    struct Surface;
    template <class Visit>
    void for_each_guarded(std::uint32_t row, float dt, Visit&& visit) const;
    [[nodiscard]] Surface surface_passed(std::uint32_t row,
                                         const GuardedPoint& point,
                                         float dt,
                                         Vec3& before) const;
    void solve_guarded(const SubstepPolicy::SubstepBatch& batch, float dt);
    void guard(std::uint32_t row, float dt);
    void add_guard(std::uint32_t row, const GuardedPoint& point, const Surface& wall);
    void drop_guards();
    /// Shortens the path to where it meets static geometry that the body collides with.
    [[nodiscard]] Surface first_surface(std::uint32_t row,
                                        const Filter& filter,
                                        const Vec3& from,
                                        const Vec3& way) const;

    // scene_snapshot.cpp
    template <class Archive>
    void serialize(Archive& archive);
    [[nodiscard]] bool is_sound() const;

    // scene_step.cpp
    StepStats step(float dt);
    void list_moved();
    /// Reads and clears the count of quarantined bodies.
    StepStats stats_of(bool skipped, std::uint32_t island_count);
};

}  // namespace zoned::physics
