// The promises of sort and sweep beyond those of all kinds.
#include "server/spatial/sort_and_sweep.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace zoned::spatial {
namespace {

TEST(SortAndSweep, SortsAlongTheAxisInWhichBoxesAreSpreadMost) {
    SortAndSweep sweep;
    std::vector<Aabb> boxes(300);
    std::vector<std::uint32_t> rows(300);
    std::iota(rows.begin(), rows.end(), 0U);
    for (std::uint32_t row = 0; row < 300; ++row) {
        const Vec3 at(0.1F * static_cast<float>(row % 7), 0, static_cast<float>(row));
        boxes[row] = {at, at + Vec3::Ones()};
        sweep.insert(row, boxes[row]);
    }
    EXPECT_EQ(sweep.axis(), 2);
    for (std::uint32_t row = 0; row < 300; ++row) {
        const Vec3 at(0, 5.0F * static_cast<float>(row), static_cast<float>(row % 11));
        boxes[row] = {at, at + Vec3::Ones()};
    }
    sweep.update(rows, boxes);
    EXPECT_EQ(sweep.axis(), 1);
}

}  // namespace
}  // namespace zoned::spatial
