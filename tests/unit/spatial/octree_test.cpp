// The promises of the octree beyond those of all kinds.
#include "server/spatial/octree.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::spatial {
namespace {

Aabb cube_at(const Vec3& middle, float half) {
    return Aabb{middle, middle}.grown(half);
}

TEST(Octree, KeepsToItsLimitOfDepth) {
    OctreeSettings settings;
    settings.max_depth = 3;
    settings.boxes_per_cell = 1;
    Octree tree(settings);
    // The first box makes a root of 64 m; all others are points in one corner.
    tree.insert(0, cube_at(Vec3::Constant(20.0F), 20.0F));
    for (std::uint32_t row = 1; row < 100; ++row) {
        tree.insert(row, cube_at(Vec3::Constant(1.0F), 0.0F));
    }
    EXPECT_EQ(tree.cells(), 4U);
}

TEST(Octree, SplitsCrowdedCellsAndGivesThemUpAgain) {
    core::Rng rng(2);
    Octree tree;
    std::vector<Aabb> boxes;
    tree.insert(0, cube_at(Vec3::Constant(32.0F), 32.0F));
    const std::size_t at_first = tree.cells();
    for (std::uint32_t row = 1; row <= 500; ++row) {
        const Vec3 at(rng.range(0, 64), rng.range(0, 64), rng.range(0, 64));
        tree.insert(row, cube_at(at, 0.5F));
    }
    EXPECT_GT(tree.cells(), at_first + 50);
    for (std::uint32_t row = 1; row <= 500; ++row) {
        tree.remove(row);
    }
    EXPECT_EQ(tree.cells(), at_first);
}

TEST(Octree, FlatOneHasFourChildrenAndStillTellsHeightsApart) {
    OctreeSettings settings;
    settings.flat = true;
    settings.boxes_per_cell = 1;
    settings.max_depth = 1;
    Octree tree(settings);
    for (std::uint32_t row = 0; row < 16; ++row) {
        const Vec3 at(
            row % 2 == 0 ? 1.0F : 3.0F, 10.0F * static_cast<float>(row), row % 4 < 2 ? 1.0F : 3.0F);
        tree.insert(row, cube_at(at, 0.5F));
    }
    EXPECT_LE(tree.cells(), 1U + 1U + 4U + 4U);
    std::vector<std::uint32_t> found;
    tree.query(cube_at(Vec3(2, 70, 2), 2.0F), [&](std::uint32_t row) { found.push_back(row); });
    EXPECT_EQ(found, std::vector<std::uint32_t>{7});
}

}  // namespace
}  // namespace zoned::spatial
