// SoftBodies: the soft bodies of one zone; add them, step them before the rigid scene, read states.
#pragma once

#include "server/physics/soft/rigid_hull.h"
#include "server/physics/soft/soft_def.h"
#include "shared/core/result.h"
#include "shared/core/state_hash.h"
#include "shared/math/aabb.h"

#include <memory>
#include <span>

namespace zoned::compute {
class Team;
}

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::physics {
class Scene;
}

namespace zoned::physics::soft {

struct SoftSettings {
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);  ///< m/s2
    float sleep_speed_mps = 0.02F;               ///< a body with no node faster over a step ...
    float sleep_after_s = 0.5F;                  ///< ... for this long sleeps; 0 = sleeping off
    /// The longest that step() will be called with, s: springs that semi-implicit Euler could not
    /// bear then are refused (see why_unstable); 0: nobody says, and none of them are taken.
    float step_s = 0.0F;
};

/// Counts for the zone's census, and of the last step.
struct SoftStats {
    std::uint32_t bodies = 0;
    std::uint32_t awake = 0;            ///< after the step
    std::uint32_t rigid = 0;            ///< stepped down to rigid bodies
    std::uint32_t nodes = 0;            ///< of those that are awake
    std::uint32_t springs = 0;          ///< of those that are awake
    std::uint32_t contacts = 0;         ///< nodes near rigid bodies, and those held off soft ones
    std::uint32_t substeps = 0;         ///< in the step, of those that are awake
    std::uint32_t newton_steps = 0;     ///< of implicit Euler, of those that are awake
    std::uint32_t gradient_passes = 0;  ///< conjugate gradients within them
    std::uint32_t torn = 0;             ///< springs that broke in the step
    std::uint32_t quarantined = 0;      ///< bodies put to sleep as their state became not finite
    bool skipped = false;               ///< nothing was awake: no pass ran
};

/// A soft body in transfer from one SoftBodies to another, whole: nodes, springs, tears, plastic
/// set, and whether it sleeps.
class SoftParcel {
  public:
    SoftParcel();
    SoftParcel(SoftParcel&&) noexcept;
    SoftParcel& operator=(SoftParcel&&) noexcept;
    ~SoftParcel();

    [[nodiscard]] bool empty() const { return body_ == nullptr; }

  private:
    friend class SoftBodies;
    std::unique_ptr<SoftBody> body_;
};

/// Soft bodies meet each other where both collide, see SoftPairs. Those that touch are solved with
/// the same substeps, and sleep and wake together.
///
/// Deterministic: the same calls in the same order give the same bits for any number of threads. No
/// allocation in step() after warm-up but where something tears. Without bodies it is one null
/// pointer.
class SoftBodies {
  public:
    explicit SoftBodies(const SoftSettings& settings = {});
    SoftBodies(SoftBodies&&) noexcept;
    SoftBodies& operator=(SoftBodies&&) noexcept;
    ~SoftBodies();

    /// Fails with the place and the reason, see why_unfit and why_unstable.
    core::Result<SoftId> add(const SoftDef& def);
    void remove(SoftId id);
    [[nodiscard]] bool contains(SoftId id) const;
    [[nodiscard]] bool empty() const;  ///< true: a zone need not step it

    /// The team must outlive this, or be taken back by nullptr.
    void work_with(compute::Team* team);

    /// One step of `dt` > 0 s. With a scene, nodes meet its bodies where these are now and push
    /// them: it is to be stepped by the same dt afterwards. Nothing happens, and stats().skipped is
    /// set, where dt is not positive and finite.
    SoftStats step(float dt, Scene* scene);

    // All functions from here on ask for bodies that are there.
    [[nodiscard]] std::uint32_t user(SoftId id) const;
    [[nodiscard]] std::size_t node_count(SoftId id) const;  ///< grows where a mesh is torn
    [[nodiscard]] Vec3 position(SoftId id, std::size_t node) const;
    [[nodiscard]] Vec3 velocity(SoftId id, std::size_t node) const;
    [[nodiscard]] float mass(SoftId id, std::size_t node) const;
    [[nodiscard]] std::span<const SoftFace> faces(SoftId id) const;
    [[nodiscard]] std::size_t spring_count(SoftId id) const;  ///< that have not broken
    [[nodiscard]] std::uint32_t torn(SoftId id) const;        ///< springs that have broken
    /// The drawn vertices, or the nodes where there are none: as many as find room in `out`.
    std::size_t vertices(SoftId id, std::span<Vec3> out) const;
    [[nodiscard]] std::size_t vertex_count(SoftId id) const;
    /// How the drawn vertices hang on the nodes; empty: the nodes are drawn.
    [[nodiscard]] std::span<const SoftVertex> hung_vertices(SoftId id) const;
    /// Triangles of the drawn vertices, or of the nodes where those are drawn: the faces, else the
    /// boundary of the tetrahedra, else segments of a rope, whose last two corners are one.
    [[nodiscard]] std::span<const SoftFace> drawn_faces(SoftId id) const;
    [[nodiscard]] Aabb bounds(SoftId id) const;  ///< of the nodes, grown by the thickness
    [[nodiscard]] bool asleep(SoftId id) const;
    [[nodiscard]] double volume(SoftId id) const;  ///< within the faces, m3
    /// Kinetic and potential (springs, tetrahedra, gas over its first state, weight), J.
    [[nodiscard]] double energy(SoftId id) const;

    // Reached by no world yet: game rules that grip single nodes will use the next three.

    /// Impulse in N s on one node; wakes the body. Ignored where the node is pinned.
    void apply_impulse(SoftId id, std::size_t node, const Vec3& impulse);
    /// Leads a pinned node: it moves with this velocity from now on; wakes the body. Ignored where
    /// the node is free or the velocity is not finite.
    void lead(SoftId id, std::size_t node, const Vec3& velocity);
    /// Pins a node where it is, or frees it; wakes the body.
    void pin(SoftId id, std::size_t node, bool pinned);

    /// Puts a node elsewhere, with the velocity that it has; wakes the body. Ignored where the
    /// place is not finite.
    void move_node(SoftId id, std::size_t node, const Vec3& position);

    void wake(SoftId id);
    /// At rest where it is until something moves it, whatever forces act within it.
    void sleep(SoftId id);
    /// Adds a velocity, m/s, to all nodes that are not pinned; wakes the body. Ignored where it is
    /// not finite.
    void push(SoftId id, const Vec3& change);
    /// Moves all nodes, pinned ones too, as one rigid thing: turned by `turn` about the centre of
    /// mass, that to `position`, then at rest. Wakes the body. Ignored where an argument is not
    /// finite.
    void place(SoftId id, const Vec3& position, const Quat& turn);

    /// Removes the body and gives it away.
    SoftParcel take(SoftId id);
    /// Takes in a body that is not empty, moved by `shift` m (from the coordinates of the other).
    SoftId give(SoftParcel parcel, const Vec3& shift);

    /// The turn that leads the nodes of `rest`, the definition that the body was made from, nearest
    /// to where they are now: the rotation R that minimises the sum of m |R q - x|^2, both about
    /// their centres of mass. Begins at `guess`; about axes that the nodes do not determine (a
    /// straight rope's own) it stays there.
    [[nodiscard]] Quat best_fit_turn(SoftId id, const SoftDef& rest, const Quat& guess) const;

    [[nodiscard]] RigidHull rigid_hull(SoftId id) const;
    /// See rigid_body_of.
    [[nodiscard]] core::Result<BodyDef> rigid_body(SoftId id) const;
    /// From now on the body is not stepped: the caller simulates the hull that it gets.
    RigidHull step_down(SoftId id);
    [[nodiscard]] bool rigid(SoftId id) const;  ///< it has stepped down
    /// Whether it pushed a body in the last step that pushes back.
    [[nodiscard]] bool touches_bodies(SoftId id) const;
    /// Takes the body back: moved as the hull was since step_down, turned by `turn`. Linear and
    /// angular momentum are those of the hull. Ignored where it had not stepped down or an argument
    /// is not finite.
    void step_up(SoftId id,
                 const Vec3& position,
                 const Quat& turn,
                 const Vec3& velocity,
                 const Vec3& angular_velocity);

    [[nodiscard]] SoftStats stats() const;
    void hash(core::StateHash& hash) const;

    /// All that later steps depend on, between two steps.
    void save(core::FieldWriter& archive) const;
    /// Takes the place of all bodies here.
    void load(core::FieldReader& archive);

  private:
    template <class Archive>
    void serialize(Archive& archive);

    struct Impl;
    std::unique_ptr<Impl> impl_;
    SoftSettings settings_;
    std::uint32_t retired_ = 0;  // ids below it are gone
    compute::Team* team_ = nullptr;
};

}  // namespace zoned::physics::soft
