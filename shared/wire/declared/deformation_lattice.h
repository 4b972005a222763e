// DeformationLattice: the control points by which clients hear of a soft body's shape.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::wire {

/// The names of the declared fields of control points, before their numbers.
inline constexpr const char* kControlPointName = "control_point_";

/// How much of the displacement of a control point a place takes.
struct LatticeWeight {
    std::uint32_t point = 0;
    float weight = 0.0F;
};

/// Those of the corners of a cell; their sum is 1.
using LatticeWeights = std::array<LatticeWeight, 8>;

/// A regular lattice over the box of the undeformed body. A place in the box is displaced as the
/// control points at the corners of its cell are, by trilinear weights: free-form deformation
/// (Sederberg and Parry, Free-Form Deformation of Solid Geometric Models, 1986) of the first order.
///
/// All coordinates are those of the undeformed body about its centre of mass, in m; the entity's
/// pose is applied to what comes out.
struct DeformationLattice {
    std::array<std::uint32_t, 3> points{1, 1, 1};  ///< along x, y and z; x runs fastest
    Vec3 lower = Vec3::Zero();
    Vec3 upper = Vec3::Zero();
    float quantum_m = 0.01F;  ///< steps of the coordinates of a displacement, > 0
    float bound_m = 0.05F;    ///< promised: no node is farther from where the lattice puts it

    /// Of a control point that is not displaced.
    static constexpr std::uint32_t kUndisplaced = 0x7F7F7FU;
    /// Steps of a coordinate to either side.
    static constexpr int kMostSteps = 127;

    [[nodiscard]] std::size_t size() const {
        return std::size_t{points[0]} * points[1] * points[2];
    }

    /// A place outside the box has the weights of the nearest one in it.
    [[nodiscard]] LatticeWeights weights_at(const Vec3& place) const;

    /// Three numbers of 8 bits: of x in the lowest, each kMostSteps more than its steps. Beyond the
    /// range the nearest end.
    [[nodiscard]] std::uint32_t code_of(const Vec3& displacement) const;
    [[nodiscard]] Vec3 displacement_of(std::uint32_t code) const;

    /// The displacement with these weights. `codes`: of all control points.
    [[nodiscard]] Vec3 displacement_at(const LatticeWeights& weights,
                                       std::span<const std::uint32_t> codes) const;
};

}  // namespace zoned::wire
