// Neighbours: predicts a body's motion from the bodies near it that are coded already.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::wire::record {

/// The motion of a body, and its difference from its own continued motion. Two registers of eight.
struct MotionResidual {
    std::array<float, 3> moved{};    ///< steps: displacement minus the continued one
    std::array<float, 3> turned{};   ///< rad: turn minus the continued one
    std::array<float, 3> carried{};  ///< steps: from near(): displacement by `turned` of the
                                     ///< neighbours, as one rigid body with each of them
    std::array<float, 3> turn{};     ///< rad: the whole turn since the reference
    std::array<float, 3> error{};    ///< steps: magnitude of the whole prediction's error
    float turn_error = 0.0F;         ///< rad: likewise, mean over the axes
};

/// Bodies that touch share their motion residuals: a push runs through a heap within a tick or two.
/// The mean over the bodies noted, weighted by 1 / distance^4, is that of the few nearest ones
/// whatever their size (inverse distance weighting: D. Shepard, "A two-dimensional interpolation
/// function for irregularly-spaced data", ACM 1968). Bodies that hang together turn together: the
/// rotational residual of one moves the others about it.
class Neighbours {
  public:
    void clear() { count_ = 0; }

    [[nodiscard]] bool empty() const { return count_ == 0; }

    void note(const std::array<std::int32_t, 3>& position, const MotionResidual& motion_residual);

    /// The weighted mean near a place; must not be empty(). Summed in a fixed order: the same bits
    /// for any width of the processor's registers.
    [[nodiscard]] MotionResidual near(const std::array<std::int32_t, 3>& position) const;

  private:
    static constexpr std::size_t kLanes = 8;

    /// Where eight bodies were, axis by axis.
    using LanePositions = std::array<std::array<float, kLanes>, 3>;

    [[nodiscard]] std::array<float, 3> from_origin(
        const std::array<std::int32_t, 3>& position) const;

    std::array<std::int32_t, 3> origin_{};  // where the first body noted was
    std::vector<LanePositions> places_;
    std::vector<MotionResidual> motion_residuals_;
    mutable std::vector<float> weights_;  // of one call of near(), kept for its memory
    std::size_t count_ = 0;
};

}  // namespace zoned::wire::record
