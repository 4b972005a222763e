#include "shared/wire/declared/deformation_lattice.h"

#include <algorithm>
#include <cmath>

namespace zoned::wire {

LatticeWeights DeformationLattice::weights_at(const Vec3& place) const {
    std::array<std::uint32_t, 3> cell{};
    std::array<float, 3> along{};
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t cells = points[static_cast<std::size_t>(axis)] - 1;
        const float extent = upper[axis] - lower[axis];
        if (cells == 0 || !(extent > 0.0F)) {
            continue;
        }
        // In this order one end is taken for what is no number, too.
        const float at = std::max(0.0F, std::min(1.0F, (place[axis] - lower[axis]) / extent)) *
                         static_cast<float>(cells);
        const std::uint32_t from = std::min(static_cast<std::uint32_t>(at), cells - 1);
        cell[static_cast<std::size_t>(axis)] = from;
        along[static_cast<std::size_t>(axis)] = at - static_cast<float>(from);
    }
    LatticeWeights out;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        LatticeWeight& to = out[corner];
        to.weight = 1.0F;
        std::uint32_t stride = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::uint32_t far_side = corner >> axis & 1U;
            to.weight *= far_side != 0 ? along[axis] : 1.0F - along[axis];
            to.point += stride * std::min(cell[axis] + far_side, points[axis] - 1);
            stride *= points[axis];
        }
    }
    return out;
}

std::uint32_t DeformationLattice::code_of(const Vec3& displacement) const {
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        constexpr auto kMost = static_cast<float>(kMostSteps);
        // Takes one end for what is no number, too.
        const float steps =
            std::max(-kMost, std::min(kMost, std::floor(displacement[axis] / quantum_m + 0.5F)));
        code |= static_cast<std::uint32_t>(static_cast<int>(steps) + kMostSteps) << 8 * axis;
    }
    return code;
}

Vec3 DeformationLattice::displacement_of(std::uint32_t code) const {
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
        const int steps = static_cast<int>(code >> 8 * axis & 0xFFU) - kMostSteps;
        out[axis] = quantum_m * static_cast<float>(steps);
    }
    return out;
}

Vec3 DeformationLattice::displacement_at(const LatticeWeights& weights,
                                         std::span<const std::uint32_t> codes) const {
    Vec3 out = Vec3::Zero();
    for (const LatticeWeight& corner : weights) {
        if (corner.weight > 0.0F) {
            out += corner.weight * displacement_of(codes[corner.point]);
        }
    }
    return out;
}

}  // namespace zoned::wire
