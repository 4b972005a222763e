#include "server/spatial/box_grid.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <set>

namespace zoned::spatial {
namespace {

Aabb random_box(core::Rng& rng) {
    // Sizes over four decades, from pebbles to slabs of 300 m, clustered so that many overlap.
    const float size =
        std::pow(10.0F, rng.range(-1.5F, 1.0F)) * (rng.below(20) == 0 ? 30.0F : 1.0F);
    const Vec3 half = 0.5F * size * Vec3(rng.unit(), rng.unit(), rng.unit());
    const Vec3 centre(rng.range(-40, 40), rng.range(-5, 5), rng.range(-40, 40));
    return {centre - half, centre + half};
}

TEST(BoxGrid, FindsTheSamePairsAsComparingAllUnderRandomChange) {
    core::Rng rng(3);
    BoxGrid grid(4.0F);
    std::vector<Aabb> boxes(400);
    std::vector<bool> present(400, false);
    std::size_t compared = 0;
    for (int round = 0; round < 40; ++round) {
        for (int change = 0; change < 300; ++change) {
            const std::uint32_t row = rng.below(400);
            if (!present[row]) {
                boxes[row] = random_box(rng);
                grid.insert(row, boxes[row]);
                present[row] = true;
            } else if (rng.below(4) == 0) {
                grid.remove(row);
                present[row] = false;
            } else {
                const Vec3 move(rng.range(-3, 3), rng.range(-1, 1), rng.range(-3, 3));
                boxes[row] = rng.below(5) == 0
                                 ? random_box(rng)
                                 : Aabb{boxes[row].lower + move, boxes[row].upper + move};
                grid.update({&row, 1}, boxes);
            }
        }
        for (std::uint32_t a = 0; a < 400; ++a) {
            if (!present[a]) {
                continue;
            }
            std::multiset<std::uint32_t> found;
            grid.query(boxes[a], [&](std::uint32_t b) { found.insert(b); });
            std::multiset<std::uint32_t> expected;
            for (std::uint32_t b = 0; b < 400; ++b) {
                if (present[b] && boxes[a].overlaps(boxes[b])) {
                    expected.insert(b);
                }
            }
            ASSERT_EQ(found, expected) << round << " " << a;  // a multiset: none twice
            compared += expected.size();
        }
    }
    EXPECT_GT(compared, 50000U);
}

TEST(BoxGrid, HandlesFarCoordinatesThatShareKeys) {
    BoxGrid grid(4.0F);
    std::uint32_t row = 0;
    for (const float x : {-9.0e5F, 0.0F, 9.0e5F}) {
        for (int i = 0; i < 20; ++i) {
            const Vec3 c(x, static_cast<float>(i) * 0.5F, 0);
            grid.insert(row++, {c - Vec3::Constant(0.2F), c + Vec3::Constant(0.2F)});
        }
    }
    int found = 0;
    grid.query({Vec3(-1, -1, -1), Vec3(1, 4.05F, 1)}, [&](std::uint32_t r) {
        EXPECT_GE(r, 20U);
        EXPECT_LT(r, 40U);
        ++found;
    });
    EXPECT_EQ(found, 9);  // centres 0, 0.5, ... 4.0 reach down to at most 3.8
}

TEST(BoxGrid, CastVisitsEveryBoxOnTheRay) {
    core::Rng rng(8);
    BoxGrid grid(4.0F);
    std::vector<Aabb> boxes;
    for (std::uint32_t row = 0; row < 3000; ++row) {
        boxes.push_back(random_box(rng));
        grid.insert(row, boxes.back());
    }
    for (int i = 0; i < 200; ++i) {
        const Vec3 origin(rng.range(-60, 60), rng.range(-5, 5), rng.range(-60, 60));
        const Vec3 direction =
            Vec3(rng.range(-1, 1), rng.range(-0.2F, 0.2F), rng.range(-1, 1)).normalized();
        const float length = rng.range(1, 60);
        std::set<std::uint32_t> visited;
        grid.cast({origin, direction, Vec3::Zero()}, length, [&](std::uint32_t row, float limit) {
            visited.insert(row);
            return limit;
        });
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            // A sampled point inside the box proves that the ray meets it.
            for (float t = 0; t <= length; t += 0.05F) {
                if (boxes[row].grown(-1e-4F).contains(origin + t * direction)) {
                    ASSERT_TRUE(visited.contains(row));
                    break;
                }
            }
        }
    }
}

}  // namespace
}  // namespace zoned::spatial
