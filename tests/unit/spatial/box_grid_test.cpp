#include "server/spatial/box_grid.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::spatial {
namespace {

TEST(BoxGrid, TellsFarBoxesApartThatShareKeys) {
    // Boxes of 0.1 m go to the level of cells of 0.125 m, and cells 2^19 apart have one key.
    BoxGrid grid(0.5F);
    const Aabb box{Vec3::Constant(0.1F), Vec3::Constant(0.2F)};
    const Vec3 away(0.125F * 524288.0F, 0, 0);
    const Aabb twin{box.lower + away, box.upper + away};
    grid.insert(0, box);
    grid.insert(1, twin);
    std::vector<std::uint32_t> found;
    grid.query(box, [&](std::uint32_t row) { found.push_back(row); });
    grid.query(twin, [&](std::uint32_t row) { found.push_back(row); });
    EXPECT_EQ(found, (std::vector<std::uint32_t>{0, 1}));
    grid.remove(0);
    found.clear();
    grid.query(box, [&](std::uint32_t row) { found.push_back(row); });
    grid.query(twin, [&](std::uint32_t row) { found.push_back(row); });
    EXPECT_EQ(found, (std::vector<std::uint32_t>{1}));
}

TEST(BoxGrid, ReportsABoxOfManyCellsOnce) {
    BoxGrid grid(1.0F);
    // Small boxes put the levels of small cells to use; the large one lies across eight of its own.
    for (std::uint32_t row = 0; row < 100; ++row) {
        const Vec3 at(static_cast<float>(row % 10), 0, static_cast<float>(row / 10));
        grid.insert(row, {at, at + Vec3::Constant(0.1F)});
    }
    grid.insert(100, {Vec3::Constant(-3), Vec3::Constant(3)});
    int found = 0;
    grid.query({Vec3::Constant(-100), Vec3::Constant(100)},
               [&](std::uint32_t row) { found += row == 100 ? 1 : 0; });
    EXPECT_EQ(found, 1);
    found = 0;
    grid.query({Vec3::Constant(-0.5F), Vec3::Constant(0.5F)},
               [&](std::uint32_t row) { found += row == 100 ? 1 : 0; });
    EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace zoned::spatial
