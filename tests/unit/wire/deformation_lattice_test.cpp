#include "shared/wire/declared/deformation_lattice.h"

#include "tests/unit/wire/wire_samples.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

namespace zoned::wire {
namespace {

using testing::random_vector;

DeformationLattice lattice_of(std::array<std::uint32_t, 3> points) {
    DeformationLattice lattice;
    lattice.points = points;
    lattice.lower = Vec3(-1.0F, -2.0F, -0.5F);
    lattice.upper = Vec3(3.0F, 1.0F, 0.5F);
    lattice.quantum_m = 0.02F;
    return lattice;
}

/// Where a control point lies on the undeformed body; in the middle of an axis that has one.
Vec3 place_of(const DeformationLattice& lattice, std::size_t point) {
    Vec3 place = 0.5F * (lattice.lower + lattice.upper);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t count = lattice.points[axis];
        const auto a = static_cast<Eigen::Index>(axis);
        if (count > 1) {
            place[a] = lattice.lower[a] + (lattice.upper[a] - lattice.lower[a]) *
                                              static_cast<float>(point % count) /
                                              static_cast<float>(count - 1);
        }
        point /= count;
    }
    return place;
}

TEST(DeformationLattice, DisplacesLinearlyWhatItsPointsDisplaceLinearly) {
    // Trilinear weights keep linear functions; what is left is the rounding of the codes, half a
    // step of each coordinate at most, and that of floats.
    core::Rng rng(7);
    for (const auto& points : {std::array<std::uint32_t, 3>{4, 3, 2}, {2, 2, 2}, {5, 1, 2}}) {
        const DeformationLattice lattice = lattice_of(points);
        Mat3 bend;
        for (int axis = 0; axis < 3; ++axis) {
            bend.col(axis) = random_vector(rng, 0.2F);
        }
        const auto moved = [&](Vec3 place) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (points[axis] == 1) {  // does not know where along it a place is
                    place[static_cast<Eigen::Index>(axis)] = 0.0F;
                }
            }
            return Vec3(bend * place);
        };
        std::vector<std::uint32_t> codes;
        for (std::size_t point = 0; point < lattice.size(); ++point) {
            codes.push_back(lattice.code_of(moved(place_of(lattice, point))));
        }
        for (int i = 0; i < 500; ++i) {
            const Vec3 place =
                lattice.lower + (lattice.upper - lattice.lower)
                                    .cwiseProduct(Vec3(rng.unit(), rng.unit(), rng.unit()));
            const LatticeWeights weights = lattice.weights_at(place);
            const float sum = std::accumulate(
                weights.begin(), weights.end(), 0.0F, [](float so_far, const LatticeWeight& w) {
                    return so_far + w.weight;
                });
            EXPECT_NEAR(sum, 1.0F, 1.0e-6F);
            const Vec3 off = lattice.displacement_at(weights, codes) - moved(place);
            EXPECT_LE(off.cwiseAbs().maxCoeff(), 0.5F * lattice.quantum_m + 1.0e-5F);
        }
    }
}

TEST(DeformationLattice, PlacesOutsideItsBoxGoWithTheNearestOneInIt) {
    const DeformationLattice lattice = lattice_of({3, 3, 3});
    core::Rng rng(3);
    std::vector<std::uint32_t> codes(lattice.size());
    for (std::uint32_t& code : codes) {
        code = lattice.code_of(random_vector(rng, 1.0F));
    }
    for (int i = 0; i < 200; ++i) {
        const Vec3 far = random_vector(rng, 9.0F);
        const Vec3 near = far.cwiseMax(lattice.lower).cwiseMin(lattice.upper);
        EXPECT_EQ(lattice.displacement_at(lattice.weights_at(far), codes),
                  lattice.displacement_at(lattice.weights_at(near), codes));
    }
}

TEST(DeformationLattice, CodesRoundToTheNearestStepAndEndWhereTheirRangeEnds) {
    const DeformationLattice lattice = lattice_of({2, 2, 2});
    const float reach = lattice.quantum_m * DeformationLattice::kMostSteps;
    EXPECT_EQ(lattice.code_of(Vec3::Zero()), DeformationLattice::kUndisplaced);
    EXPECT_EQ(lattice.displacement_of(DeformationLattice::kUndisplaced), Vec3(Vec3::Zero()));
    core::Rng rng(11);
    for (int i = 0; i < 500; ++i) {
        const Vec3 wanted = random_vector(rng, 1.2F * reach);
        const Vec3 got = lattice.displacement_of(lattice.code_of(wanted));
        const Vec3 within = wanted.cwiseMax(-reach).cwiseMin(reach);
        EXPECT_LE((got - within).cwiseAbs().maxCoeff(), 0.5F * lattice.quantum_m + 1.0e-6F);
    }
    // What is no number, too, has a code that is in range.
    const Vec3 odd(std::numeric_limits<float>::quiet_NaN(),
                   std::numeric_limits<float>::infinity(),
                   -std::numeric_limits<float>::infinity());
    EXPECT_LE(lattice.displacement_of(lattice.code_of(odd)).cwiseAbs().maxCoeff(), reach + 1.0e-6F);
    for (const LatticeWeight& corner : lattice.weights_at(odd)) {
        EXPECT_LT(corner.point, lattice.size());
        EXPECT_TRUE(corner.weight >= 0.0F && corner.weight <= 1.0F);
    }
}

}  // namespace
}  // namespace zoned::wire
