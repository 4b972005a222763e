#include "server/zone/simulation/deformation_fit.h"

#include <Eigen/Cholesky>

#include <algorithm>

namespace zoned::zone {

namespace {

/// Share of the greatest diagonal element that is added to all of them (ridge regression): a control
/// point without nodes has an equation then, and one with a node of its own loses a thousandth of
/// its displacement at most.
constexpr double kRidge = 1.0e-3;

}  // namespace

DeformationFit::DeformationFit(const wire::DeformationLattice& lattice,
                               const physics::soft::SoftDef& rest)
    : lattice_(lattice),
      shown_(lattice.size()),
      errors_(rest.nodes.size()),
      sums_(lattice.size()),
      wanted_(lattice.size()),
      due_(lattice.size()) {
    const auto size = static_cast<Eigen::Index>(lattice.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    weights_.reserve(rest.nodes.size());
    for (const physics::soft::SoftNode& node : rest.nodes) {
        const wire::LatticeWeights& w = weights_.emplace_back(lattice.weights_at(node.position));
        for (const wire::LatticeWeight& a : w) {
            for (const wire::LatticeWeight& b : w) {
                normal(a.point, b.point) +=
                    static_cast<double>(a.weight) * static_cast<double>(b.weight);
            }
        }
    }
    normal.diagonal().array() += kRidge * normal.diagonal().maxCoeff();
    inverse_ = normal.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
}

void DeformationFit::solve(std::span<const Vec3> moved) {
    std::fill(sums_.begin(), sums_.end(), Vec3d::Zero());
    for (std::size_t node = 0; node < moved.size(); ++node) {
        for (const wire::LatticeWeight& corner : weights_[node]) {
            sums_[corner.point] += static_cast<double>(corner.weight) * moved[node].cast<double>();
        }
    }
    for (std::size_t point = 0; point < wanted_.size(); ++point) {
        Vec3d at = Vec3d::Zero();
        for (std::size_t k = 0; k < sums_.size(); ++k) {
            at +=
                inverse_(static_cast<Eigen::Index>(point), static_cast<Eigen::Index>(k)) * sums_[k];
        }
        wanted_[point] = lattice_.code_of(at.cast<float>());
    }
}

float DeformationFit::measure(std::span<const Vec3> moved, std::span<const std::uint32_t> codes) {
    for (std::size_t point = 0; point < codes.size(); ++point) {
        shown_[point] = lattice_.displacement_of(codes[point]);
    }
    float worst = 0.0F;
    for (std::size_t node = 0; node < moved.size(); ++node) {
        Vec3 at = Vec3::Zero();
        for (const wire::LatticeWeight& corner : weights_[node]) {
            at += corner.weight * shown_[corner.point];
        }
        errors_[node] = (moved[node] - at).norm();
        worst = std::max(worst, errors_[node]);
    }
    return worst;
}

float DeformationFit::follow(std::span<const Vec3> moved,
                             bool all,
                             std::span<std::uint32_t> codes) {
    float left = measure(moved, codes);
    if (left <= lattice_.bound_m && !all) {
        return left;
    }
    solve(moved);
    if (!all) {
        // Only the control points about the nodes that are too far off.
        std::fill(due_.begin(), due_.end(), char{0});
        for (std::size_t node = 0; node < moved.size(); ++node) {
            if (errors_[node] > lattice_.bound_m) {
                for (const wire::LatticeWeight& corner : weights_[node]) {
                    due_[corner.point] |= static_cast<char>(corner.weight > 0.0F);
                }
            }
        }
        for (std::size_t point = 0; point < codes.size(); ++point) {
            codes[point] = due_[point] != 0 ? wanted_[point] : codes[point];
        }
        left = measure(moved, codes);
    }
    if (all || left > lattice_.bound_m) {
        std::copy(wanted_.begin(), wanted_.end(), codes.begin());
        left = measure(moved, codes);
    }
    return left;
}

}  // namespace zoned::zone
