// JointRowWriter: joints as rows of a RowSystem, and their impulses back into the joints.
#pragma once

#include "server/physics/joints/joint_table.h"
#include "server/physics/solver_variants/rows/contact_rows.h"

#include <cstdint>
#include <vector>

namespace zoned::physics {

class JointRowWriter {
  public:
    void reserve(std::size_t joints) { spans_.reserve(joints); }

    void clear() { spans_.clear(); }

    /// Appends the rows of a joint at the present poses of its bodies.
    void write(const Bodies& bodies,
               const JointTable& table,
               std::uint32_t joint,
               const VariantBodies& moving,
               const RowParameters& parameters,
               RowSystem& system);
    /// Writes impulses back; `force_n` is the mean of the substeps so far: this is the `count`th.
    void store(const RowSystem& system, double h, int count, JointTable& table) const;

  private:
    struct RowSpan {
        std::uint32_t joint = 0;
        std::uint32_t first = 0;
        std::uint32_t count = 0;
    };

    std::vector<RowSpan> spans_;
};

/// Pose of the body in a slot, relative to `origin`; that of the row where the slot is 0.
JointPose pose_of(const Bodies& bodies,
                  const VariantBodies& moving,
                  std::uint32_t row,
                  const Vec3& origin);

}  // namespace zoned::physics
