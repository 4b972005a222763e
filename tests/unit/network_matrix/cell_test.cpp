#include "tests/network_matrix/cell.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace zoned::network_matrix {
namespace {

std::array<double, 5> settings_of(const Cell& c) {
    return {c.loss, c.jitter_s, c.duplicate, c.reorder, c.outages ? 1.0 : 0.0};
}

TEST(Matrix, HasEveryCombinationOnce) {
    std::set<std::array<double, 5>> seen;
    for (const Cell& cell : all_cells()) {
        seen.insert(settings_of(cell));
    }
    EXPECT_EQ(seen.size(), 6U * 3 * 2 * 2 * 2);
    EXPECT_EQ(all_cells().size(), seen.size());
}

TEST(Matrix, ShowsEveryPairOfSettingsInItsQuickForm) {
    using Pair = std::array<double, 4>;
    const auto pairs_of = [](const std::vector<Cell>& cells) {
        std::set<Pair> pairs;
        for (const Cell& cell : cells) {
            const auto s = settings_of(cell);
            for (std::size_t a = 0; a < s.size(); ++a) {
                for (std::size_t b = a + 1; b < s.size(); ++b) {
                    pairs.insert({static_cast<double>(5 * a + b), s[a], s[b], 0.0});
                }
            }
        }
        return pairs;
    };
    EXPECT_EQ(pairs_of(pairwise_cells()), pairs_of(all_cells()));
    EXPECT_EQ(pairwise_cells().size(), 18U);
}

TEST(Matrix, FindsAServerThatSendsFalsePositions) {
    CellSettings settings;
    settings.config = ZONED_SOURCE_DIR "/config/minimal.txtpb";
    settings.sets = {"testing.corrupt_position.probability=0.2",
                     "testing.corrupt_position.offset_m=3"};
    const Cell cell{0.05, 0.033, 0.05, 0.1, false};
    EXPECT_FALSE(run_cell(cell, settings).report.consistent);
}

}  // namespace
}  // namespace zoned::network_matrix
