#include "shared/wire/record/neighbours.h"

#include "shared/math/array8.h"

#include <algorithm>
#include <bit>

namespace zoned::wire::record {

namespace {

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
    Array8 heaviest = 0.0F;
    for (std::size_t i = 0; i < count_; i += kLanes) {
        const LanePositions& place = places_[i / kLanes];
        const Array8 dx = Array8::load(place[0].data()) - here[0];
        const Array8 dy = Array8::load(place[1].data()) - here[1];
        const Array8 dz = Array8::load(place[2].data()) - here[2];
        const Array8 square = dx * dx + dy * dy + dz * dz + 1.0F;
        const Array8 weight = 1.0F / (square * square);
        weight.store(weights_.data() + i);
        heaviest = heaviest.max(weight);
    }
    const float least = kLeastShare * heaviest.highest();
    std::array<Array8, 2> sums;
    sums.fill(0.0F);
    float weight = 0.0F;
    for (std::size_t i = 0; i < count_; ++i) {
        const float w = weights_[i];
        if (w >= least) {
            const float* values = motion_residuals_[i].moved.data();
            sums[0] += w * Array8::load(values);
            sums[1] += w * Array8::load(values + kLanes);
            weight += w;
        }
    }
    const float scale = 1.0F / weight;
    std::array<float, 16> mean;
    (scale * sums[0]).store(mean.data());
    (scale * sums[1]).store(mean.data() + kLanes);
    auto result = std::bit_cast<MotionResidual>(mean);
    // The mean of turned x (here - place), in two parts.
    const std::array<float, 3> about_origin = cross(result.turned, here);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.carried[axis] = about_origin[axis] - result.carried[axis];
    }
    return result;
}

}  // namespace zoned::wire::record
