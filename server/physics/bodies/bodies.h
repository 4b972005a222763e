// Bodies: the columns of all rigid bodies of a scene, and the ids that name their rows.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/math/aabb.h"

#include <cstdint>
#include <vector>

namespace zoned::physics {

inline constexpr std::uint32_t kNoIndex = 0xFFFFFFFFU;
inline constexpr std::uint32_t kMaxBodies = (1U << 20) - 2;

/// One row per body; rows of removed bodies are reused with a higher generation. All columns have
/// the same length.
struct Bodies {
    // Identity.
    std::vector<std::uint16_t> generation;
    std::vector<std::uint8_t> alive;
    std::vector<BodyKind> kind;
    std::vector<std::uint32_t> user;
    // State.
    std::vector<Vec3> position;
    std::vector<Quat> orientation;
    std::vector<Vec3> velocity;
    std::vector<Vec3> angular_velocity;
    std::vector<Vec3> force;       ///< of this step at the centre of mass, N, world axes
    std::vector<Vec3> torque;      ///< of this step, N m, world axes
    std::vector<float> still_s;    ///< how long it has been slower than the sleep speeds
    std::vector<float> settled_s;  ///< how long it has stayed near `settled_at`
    std::vector<Vec3> settled_at;
    std::vector<Quat> settled_turn;
    std::vector<std::uint8_t> substep_level;     ///< level of its island in the last step
    std::vector<std::uint8_t> substep_patience;  ///< steps until its island may go down a level
    /// The factor by which contacts scale its inverse mass and inertia in this step: 1, or less
    /// where its island holds a body that is too heavy (see SubstepPolicy).
    std::vector<float> inv_mass_scale;
    std::vector<std::uint8_t> awake;   ///< dynamic: simulated; kinematic: moves
    std::vector<std::uint8_t> listed;  ///< in `awake_list` or `mover_list`
    // Constants of the body.
    std::vector<Shape> shape;
    std::vector<Material> material;
    std::vector<Filter> filter;
    std::vector<Damping> damping;
    std::vector<std::uint8_t> sensor;
    std::vector<std::uint8_t> events;  ///< see BodyDef::events
    std::vector<float> inv_mass;       ///< 0 unless dynamic
    std::vector<Vec3> inertia;         ///< principal moments
    std::vector<Vec3> inv_inertia;     ///< their inverses; 0 unless dynamic
    std::vector<std::uint8_t> round;   ///< all principal moments equal: its tensor never turns
    std::vector<float> radius;         ///< bounding radius
    std::vector<float> inner;          ///< see inner_radius
    /// From principal to body axes, as far as there are bodies whose axes differ; empty mostly.
    std::vector<Quat> tilt;
    std::uint32_t reporting = 0;  ///< bodies with `events`
    // Derived from the pose.
    std::vector<Mat3> rotation;
    std::vector<Aabb> bounds;  ///< tight
    std::vector<Aabb> fat;     ///< the boxes in the broadphase
    // Links of other structures.
    std::vector<std::uint32_t> first_contact;  ///< head of the list in ContactGraph
    std::vector<std::uint32_t> first_joint;    ///< head of the list in JointTable
    std::vector<std::uint32_t> solver_slot;    ///< row in the solver's arrays in this step

    std::vector<std::uint32_t> free_rows;
    std::vector<std::uint32_t> forced;  ///< rows that may have a force or torque
    std::uint32_t count = 0;
    std::uint32_t awake_dynamic = 0;
    std::uint32_t awake_particles = 0;
    std::uint32_t slowed = 0;  ///< whose speed or spin was cut to the most there is, since asked
    /// Rows of awake dynamic bodies, ascending after `compact_lists`; may hold stale rows between
    /// steps.
    std::vector<std::uint32_t> awake_list;
    std::vector<std::uint32_t> mover_list;     ///< the same for kinematic bodies that move
    std::vector<std::uint32_t> particle_list;  ///< the same for particles

    [[nodiscard]] std::uint32_t rows() const { return static_cast<std::uint32_t>(alive.size()); }

    [[nodiscard]] BodyId id_of(std::uint32_t row) const {
        return BodyId((static_cast<std::uint32_t>(generation[row]) << 20) | (row + 1));
    }

    /// The row of an id, or kNoIndex when no such body lives.
    [[nodiscard]] std::uint32_t row_of(BodyId id) const;

    [[nodiscard]] bool is_dynamic(std::uint32_t row) const {
        return kind[row] == BodyKind::kDynamic;
    }

    [[nodiscard]] bool is_particle(std::uint32_t row) const {
        return kind[row] == BodyKind::kParticle;
    }

    /// Whether its principal axes are not the body's.
    [[nodiscard]] bool tilted(std::uint32_t row) const {
        return row < tilt.size() && !tilt[row].vec().isZero(0.0F);
    }

    /// The principal axes of a body that stands turned like this, world coordinates: the axes that
    /// `inertia` and `inv_inertia` are about.
    [[nodiscard]] Mat3 inertia_axes(std::uint32_t row, const Mat3& turned) const {
        return tilted(row) ? Mat3(turned * tilt[row].toRotationMatrix()) : turned;
    }

    [[nodiscard]] bool is_plane(std::uint32_t row) const {
        return shape[row].kind == ShapeKind::kPlane;
    }

    /// Awake and dynamic: the solver may move it.
    [[nodiscard]] bool simulated(std::uint32_t row) const {
        return awake[row] != 0 && is_dynamic(row);
    }

    /// Another shape; its pose has to be set anew.
    void set_shape(std::uint32_t row, const Shape& to);

    /// A fresh row, not yet awake; kNoIndex when all ids are taken.
    std::uint32_t create(const BodyDef& def);
    void destroy(std::uint32_t row);

    void add_force(std::uint32_t row, const Vec3& f, const Vec3& t);
    void clear_forces();
    void set_pose(std::uint32_t row, const Vec3& x, const Quat& q);

    /// It has not been at rest until now.
    void stir(std::uint32_t row) { still_s[row] = settled_s[row] = 0.0F; }

    void mark_awake(std::uint32_t row);
    void mark_asleep(std::uint32_t row);
    /// Drops rows that are asleep or gone from both lists and sorts them.
    void compact_lists();

  private:
    std::uint32_t append_row();
    void set_inertia(std::uint32_t row, const BodyDef& def);
    std::vector<std::uint32_t>& list_of(BodyKind kind);
};

}  // namespace zoned::physics
