// The promises of the tree of boxes beyond those of all kinds.
#include "server/spatial/aabb_tree.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace zoned::spatial {
namespace {

Aabb cube_around(const Vec3& middle, float half = 0.5F) {
    return Aabb{middle, middle}.grown(half);
}

TEST(AabbTree, StaysConsistentWhateverIsDoneToIt) {
    core::Rng rng(5);
    AabbTree tree;
    std::vector<Aabb> boxes(700);
    std::vector<std::uint32_t> batch;
    for (int round = 0; round < 300; ++round) {
        // Grows for a while, then shrinks to nothing, three times.
        const bool grows = round % 100 < 50;
        batch.clear();
        for (int i = 0; i < 40; ++i) {
            const std::uint32_t row = rng.below(700);
            const Vec3 at(rng.range(-20, 20), rng.range(-20, 20), rng.range(-20, 20));
            if (!tree.contains(row)) {
                if (grows) {
                    boxes[row] = cube_around(at, rng.unit());
                    tree.insert(row, boxes[row]);
                }
            } else if (!grows && rng.below(3) != 0) {
                tree.remove(row);
                std::erase(batch, row);
            } else {
                boxes[row] = rng.below(2) == 0 ? cube_around(at) : boxes[row].grown(0.1F);
                batch.push_back(row);
            }
        }
        tree.update(batch, boxes);
        ASSERT_TRUE(tree.consistent()) << "round " << round;
        if (round % 10 == 9) {
            tree.rebuild();
            ASSERT_TRUE(tree.consistent()) << "rebuilt in round " << round;
        }
    }
}

TEST(AabbTree, BuildsTreesOfEverySizeThatHoldAllBoxes) {
    core::Rng rng(6);
    for (const bool alike : {false, true}) {
        for (std::uint32_t n = 0; n < 600; n = n < 80 ? n + 1 : n + 37) {
            AabbTree tree;
            for (std::uint32_t row = 0; row < n; ++row) {
                const Vec3 at(rng.range(-9, 9), rng.range(-9, 9), rng.range(-9, 9));
                tree.insert(row, alike ? cube_around(Vec3::Zero()) : cube_around(at));
            }
            tree.rebuild();
            ASSERT_TRUE(tree.consistent()) << n;
            std::uint32_t found = 0;
            tree.query(cube_around(Vec3::Zero(), 100.0F), [&](std::uint32_t) { ++found; });
            ASSERT_EQ(found, n);
        }
    }
}

/// The cost of a tree after boxes have wandered for a while against one built afresh.
TEST(AabbTree, IsWorthItsQueriesAfterBoxesHaveMixed) {
    core::Rng rng(7);
    constexpr std::uint32_t kBoxes = 2000;
    AabbTree tree;
    std::vector<Aabb> boxes(kBoxes);
    std::vector<std::uint32_t> rows(kBoxes);
    std::iota(rows.begin(), rows.end(), 0U);
    for (std::uint32_t row = 0; row < kBoxes; ++row) {
        boxes[row] = cube_around(Vec3(rng.range(-20, 20), rng.range(0, 5), rng.range(-20, 20)));
        tree.insert(row, boxes[row]);
    }
    for (int round = 0; round < 1000; ++round) {
        for (Aabb& box : boxes) {
            Vec3 move(rng.range(-0.2F, 0.2F), rng.range(-0.2F, 0.2F), rng.range(-0.2F, 0.2F));
            const Vec3 next = 0.5F * (box.lower + box.upper) + move;
            if (next.cwiseAbs().maxCoeff() > 20.0F) {
                move = -move;
            }
            box = {box.lower + move, box.upper + move};
        }
        tree.update(rows, boxes);
    }
    ASSERT_TRUE(tree.consistent());
    const double worn = tree.cost();
    tree.rebuild();
    // The tree is built again when it has grown by half.
    EXPECT_LT(worn, 1.6 * tree.cost());
}

TEST(AabbTree, VisitsNearBoxesFirst) {
    AabbTree tree;
    for (std::uint32_t row = 0; row < 200; ++row) {
        tree.insert(row, cube_around(Vec3(2.0F * static_cast<float>(row), 0, 0)));
    }
    int visits = 0;
    const auto stop_at_first = [&](std::uint32_t row, float limit) {
        ++visits;
        return std::min(limit, 2.0F * static_cast<float>(row) + 0.5F);
    };
    tree.cast({Vec3(-1, 0, 0), Vec3::UnitX(), Vec3::Zero()}, 1000.0F, stop_at_first);
    EXPECT_EQ(visits, 1);
    visits = 0;
    tree.nearest(Vec3(-1, 0, 0), 1000.0F, stop_at_first);
    EXPECT_EQ(visits, 1);
}

}  // namespace
}  // namespace zoned::spatial
