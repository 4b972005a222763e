// JointState: the part of a joint that goes on from one step to the next.
#pragma once

#include "server/physics/joints/joint_rows.h"
#include "server/physics/simd/lanes.h"

#include <array>

namespace zoned::physics {

/// A joint that is made anew elsewhere with this state goes on as if it had stayed.
struct JointState {
    std::array<float, kMostRows> impulse{};         ///< per row and substep
    std::array<float, kMostRows> straight_error{};  ///< per row, m or rad: see JointSolver
    std::array<Row8, 2> motion{};                   ///< of a and b when the step ended
    float substep_s = 0.0F;                         ///< length of these substeps
    float force_n = 0.0F;                           ///< size of the force of the last one
};

}  // namespace zoned::physics
