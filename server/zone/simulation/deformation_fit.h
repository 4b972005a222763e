// DeformationFit: the control points by which clients hear of the shape of a soft body.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "shared/wire/declared/deformation_lattice.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::zone {

/// Finds the displacements of control points that put the nodes of one type nearest to where they
/// are: linear least squares, solved by the inverse of the normal equations, which the undeformed
/// nodes alone decide. Control points far from all nodes stay where they are.
class DeformationFit {
  public:
    /// Keeps both.
    DeformationFit(const wire::DeformationLattice& lattice, const physics::soft::SoftDef& rest);

    /// `moved`: displacements of the nodes, as many as those of `rest`. `codes`: of all control
    /// points, as clients have them; those that have to change do. Codes whose places the lattice
    /// keeps within its bound stay as they are, unless `all` are wanted at their best. Returns the
    /// greatest distance that is left between a node and where the codes put it, m.
    float follow(std::span<const Vec3> moved, bool all, std::span<std::uint32_t> codes);

  private:
    void solve(std::span<const Vec3> moved);
    /// Sets `errors_` of all nodes, and returns the greatest.
    float measure(std::span<const Vec3> moved, std::span<const std::uint32_t> codes);

    const wire::DeformationLattice& lattice_;
    std::vector<wire::LatticeWeights> weights_;  // of each node
    Eigen::MatrixXd inverse_;
    std::vector<Vec3> shown_;            // work: displacements that the codes stand for
    std::vector<float> errors_;          // work: distance of each node from where they put it, m
    std::vector<Vec3d> sums_;            // work: right sides
    std::vector<std::uint32_t> wanted_;  // work: the best codes
    std::vector<char> due_;              // work: control points that change
};

}  // namespace zoned::zone
