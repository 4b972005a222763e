#include "shared/wire/record/neighbours.h"

#include <Eigen/Core>

#include <algorithm>
#include <bit>

namespace zoned::wire::record {

namespace {

using Lanes = Eigen::Array<float, 8, 1>;

static_assert(sizeof(MotionResidual) == 16 * sizeof(float), "a motion_residual is two registers");

// So far away that such a lane weighs nothing beside any real one.
constexpr float kNowhere = 1e9F;
// Bodies that weigh less than this beside the nearest one are passed over.
constexpr float kLeastShare = 1.0F / 64.0F;

std::array<float, 3> cross(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

/// Differences of places are exact wherever the bodies are.
std::array<float, 3> Neighbours::from_origin(const std::array<std::int32_t, 3>& position) const {
    return {static_cast<float>(position[0] - origin_[0]),
            static_cast<float>(position[1] - origin_[1]),
            static_cast<float>(position[2] - origin_[2])};
}

void Neighbours::note(const std::array<std::int32_t, 3>& position,
                      const MotionResidual& motion_residual) {
    const std::size_t lane = count_ % kLanes;
    const std::size_t block = count_ / kLanes;
    if (block == places_.size()) {
        places_.emplace_back();
        motion_residuals_.resize(motion_residuals_.size() + kLanes);
        weights_.resize(motion_residuals_.size());
    }
    if (lane == 0) {
        for (auto& axis : places_[block]) {
            axis.fill(kNowhere);
        }
    }
    if (count_ == 0) {
        origin_ = position;
    }
    const std::array<float, 3> place = from_origin(position);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        places_[block][axis][lane] = place[axis];
    }
    motion_residuals_[count_] = motion_residual;
    motion_residuals_[count_].carried = cross(motion_residual.turned, place);
    ++count_;
}

MotionResidual Neighbours::near(const std::array<std::int32_t, 3>& position) const {
    const std::array<float, 3> here = from_origin(position);
    Lanes heaviest = Lanes::Zero();
    for (std::size_t i = 0; i < count_; i += kLanes) {
        const LanePositions& place = places_[i / kLanes];
        const Lanes dx = Eigen::Map<const Lanes>(place[0].data()) - here[0];
        const Lanes dy = Eigen::Map<const Lanes>(place[1].data()) - here[1];
        const Lanes dz = Eigen::Map<const Lanes>(place[2].data()) - here[2];
        const Lanes square = dx * dx + dy * dy + dz * dz + 1.0F;
        const Lanes weight = 1.0F / (square * square);
        Eigen::Map<Lanes>(weights_.data() + i) = weight;
        heaviest = heaviest.max(weight);
    }
    const float least = kLeastShare * heaviest.maxCoeff();
    std::array<Lanes, 2> sums;
    sums.fill(Lanes::Zero());
    float weight = 0.0F;
    for (std::size_t i = 0; i < count_; ++i) {
        const float w = weights_[i];
        if (w >= least) {
            const float* values = motion_residuals_[i].moved.data();
            sums[0] += w * Eigen::Map<const Lanes>(values);
            sums[1] += w * Eigen::Map<const Lanes>(values + kLanes);
            weight += w;
        }
    }
    const float scale = 1.0F / weight;
    std::array<float, 16> mean;
    Eigen::Map<Lanes>(mean.data()) = scale * sums[0];
    Eigen::Map<Lanes>(mean.data() + kLanes) = scale * sums[1];
    auto result = std::bit_cast<MotionResidual>(mean);
    // The mean of turned x (here - place), in two parts.
    const std::array<float, 3> about_origin = cross(result.turned, here);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.carried[axis] = about_origin[axis] - result.carried[axis];
    }
    return result;
}

}  // namespace zoned::wire::record
