// Meshes and trees that come back from their parts.
#include "tests/unit/physics/surfaces.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace zoned::physics {
namespace {

using ::testing::HasSubstr;

std::vector<Aabb> random_boxes(std::size_t count, std::uint64_t seed) {
    core::Rng rng(seed);
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 at(rng.range(-9, 9), rng.range(-9, 9), rng.range(-9, 9));
        boxes.push_back({at, at + Vec3(rng.range(0, 1), rng.range(0, 1), rng.range(0, 1))});
    }
    return boxes;
}

/// A tree that leans to the right: so many inner nodes, each with a leaf of one item on its left.
BoxTree::Layout chain(std::uint32_t inner) {
    BoxTree::Layout out;
    for (std::uint32_t i = 0; i < inner; ++i) {
        out.nodes.insert(out.nodes.end(), {0, 1});
    }
    out.nodes.push_back(1);
    for (std::uint32_t i = 0; i <= inner; ++i) {
        out.order.push_back(i);
    }
    return out;
}

TEST(BoxTree, ComesBackFromItsLayoutBitForBit) {
    for (const std::size_t count : {0U, 1U, 4U, 5U, 300U}) {
        const std::vector<Aabb> boxes = random_boxes(count, count);
        const BoxTree built(boxes);
        const auto restored = BoxTree::restore(built.layout(), boxes);
        ASSERT_TRUE(restored.ok()) << restored.error();
        EXPECT_TRUE(restored->same_as(built)) << count;
        EXPECT_EQ(restored->depth(), built.depth());
    }
}

TEST(BoxTree, KnowsItsDepth) {
    EXPECT_EQ(BoxTree().depth(), 0U);
    EXPECT_EQ(BoxTree(random_boxes(3, 1)).depth(), 1U);
    EXPECT_EQ(BoxTree(random_boxes(8, 1)).depth(), 2U + (BoxTree(random_boxes(8, 1)).nodes() > 3));
}

TEST(BoxTree, AnswersAtTheGreatestDepthAndRefusesMore) {
    constexpr auto kMost = static_cast<std::uint32_t>(BoxTree::kMaxDepth - 1);
    std::vector<Aabb> boxes;  // in a row along x: rays from either end pass through all of them
    for (std::uint32_t i = 0; i < kMost + 2; ++i) {
        const auto x = static_cast<float>(i);
        boxes.push_back({Vec3(x, -1, -1), Vec3(x + 1.0F, 1, 1)});
    }
    const auto deepest = BoxTree::restore(chain(kMost), std::span(boxes).first(kMost + 1));
    ASSERT_TRUE(deepest.ok()) << deepest.error();
    EXPECT_EQ(deepest->depth(), BoxTree::kMaxDepth);
    std::size_t found = 0;
    deepest->query({Vec3::Constant(-99), Vec3::Constant(99)}, [&](std::uint32_t) { ++found; });
    EXPECT_EQ(found, kMost + 1);
    for (const float side : {-1.0F, 1.0F}) {
        std::size_t tested = 0;
        deepest->cast(
            Vec3(100.0F * side, 0, 0), Vec3(-side, 0, 0), 300.0F, [&](std::uint32_t, float limit) {
                ++tested;
                return limit;
            });
        EXPECT_EQ(tested, kMost + 1) << side;
    }
    const auto deeper = BoxTree::restore(chain(kMost + 1), boxes);
    ASSERT_FALSE(deeper.ok());
    EXPECT_THAT(deeper.error(), HasSubstr("is too deep"));
}

TEST(BoxTree, TakesNoRandomBytesForATreeThatIsNone) {
    core::Rng rng(11);
    const std::vector<Aabb> boxes = random_boxes(6, 3);
    int taken = 0;
    for (int round = 0; round < 20000; ++round) {
        BoxTree::Layout layout{{}, {0, 1, 2, 3, 4, 5}};
        for (std::uint32_t n = rng.below(8); n > 0; --n) {
            layout.nodes.push_back(static_cast<std::uint8_t>(rng.below(6)));
        }
        const auto tree = BoxTree::restore(layout, boxes);
        if (!tree) {
            continue;
        }
        ++taken;
        std::vector<std::uint32_t> items;
        tree->query({Vec3::Constant(-20), Vec3::Constant(20)},
                    [&](std::uint32_t item) { items.push_back(item); });
        EXPECT_EQ(items, layout.order);
    }
    EXPECT_GT(taken, 0);
}

TEST(Mesh, ComesBackFromItsPartsBitForBit) {
    const MeshInput in = grid_mesh(9, 0.5F, [](float x, float z) { return std::sin(x * z); });
    const auto built = build_mesh(in.vertices, in.indices)->mesh;
    const TriangleMesh::MeshTables& t = built->tables();
    EXPECT_EQ(t.vertices.size(), 100U);
    const MeshParts parts{t.vertices, t.corners, t.bends, t.tree.layout()};
    const auto restored = restore_mesh(parts);
    ASSERT_TRUE(restored.ok()) << restored.error();
    EXPECT_EQ((*restored)->tables().normals, t.normals);
    EXPECT_TRUE((*restored)->tables().tree.same_as(t.tree));
    MeshParts few = parts;
    few.bends.pop_back();
    EXPECT_THAT(restore_mesh(few).error(), HasSubstr("not as many bends"));
    EXPECT_THAT(restore_mesh({}).error(), HasSubstr("has no triangles"));
}

}  // namespace
}  // namespace zoned::physics
