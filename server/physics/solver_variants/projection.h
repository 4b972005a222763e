// Projection: moves positions apart; velocities follow from the distance moved.
#pragma once

#include "server/physics/joints/joint_table.h"
#include "server/physics/settings/physics_settings.h"
#include "server/physics/solver_variants/rows/contact_rows.h"
#include "server/physics/solver_variants/rows/variant_bodies.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// Position based dynamics of rigid bodies (M. Mueller, M. Macklin, N. Chentanez, S. Jeschke, T.-Y.
/// Kim, "Detailed rigid body simulation with extended position based dynamics", Computer Graphics
/// Forum 39, 2020). In each substep bodies fly freely. Then points of contact and anchors of joints
/// are moved to where they belong, one after the other and at the poses that the bodies have by
/// then: no linearisation survives a pass. A displacement over h is a change of velocity. At last
/// velocities are corrected: points that press keep no speed along the normal, and restitution is
/// given where points met fast enough.
class Projection {
  public:
    struct BodyPlace {
        const Bodies& bodies;
        const ContactGraph& graph;
        const JointTable& joints;
        const PhysicsSettings& settings;
        std::span<const std::uint32_t> joint_list;
        double h = 0.0;  ///< s
    };

    /// The whole of a substep; `system` holds its rows at the start, with velocities after forces,
    /// and in `lambda` afterwards the impulses of the contacts.
    void solve(const BodyPlace& place,
               std::span<const ContactSpan> contacts,
               VariantBodies& moving,
               RowSystem& system);

  private:
    /// One point of one contact.
    struct ProjectionPoint {
        std::uint32_t a = 0, b = 0;  // slots
        std::uint32_t normal_row = 0;
        std::uint32_t tangent_row = kNoIndex;
        Vec3d normal = Vec3d::Zero(), tangent1 = Vec3d::Zero(), tangent2 = Vec3d::Zero();
        Vec3d local_a = Vec3d::Zero(), local_b = Vec3d::Zero();  // arms in the bodies' axes
        Vec3d apart = Vec3d::Zero();  // from a's point to b's when the substep began
        double gap = 0.0;             // then
        double met = 0.0;             // speed along the normal then, before forces
        double friction = 0.0, restitution = 0.0;
        double push = 0.0, rub1 = 0.0, rub2 = 0.0;  // impulses so far, N s
    };

    void list_points(const BodyPlace& place,
                     std::span<const ContactSpan> contacts,
                     const VariantBodies& moving,
                     const RowSystem& system);
    void project_point(ProjectionPoint& point, VariantBodies& moving, RowSystem& system) const;
    void project_joints(const BodyPlace& place, VariantBodies& moving, RowSystem& system) const;
    void correct_velocities(const BodyPlace& place, RowSystem& system);

    double h_ = 0.0;
    std::vector<ProjectionPoint> points_;
    std::vector<Mat3d> axes_;  // by slot: rotation when the substep began
};

}  // namespace zoned::physics
