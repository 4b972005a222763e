// All kinds of structures over boxes against comparing everything with everything.
#include "server/spatial/box_index.h"

#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace zoned::spatial {
namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

constexpr BroadphaseKind kKinds[] = {BroadphaseKind::kAllPairs,
                                     BroadphaseKind::kGrid,
                                     BroadphaseKind::kOctree,
                                     BroadphaseKind::kQuadtree,
                                     BroadphaseKind::kSortAndSweep,
                                     BroadphaseKind::kTree};

class EachKind : public testing::TestWithParam<BroadphaseKind> {
  protected:
    BoxIndex index{GetParam(), BroadphaseSettings()};
    core::Rng rng{3};
    std::vector<Aabb> boxes;
    std::vector<bool> present;

    Aabb random_box() {
        // Sizes over four decades, from pebbles to slabs of 300 m, clustered so that many overlap.
        const float size =
            std::pow(10.0F, rng.range(-1.5F, 1.0F)) * (rng.below(20) == 0 ? 30.0F : 1.0F);
        const Vec3 half = 0.5F * size * Vec3(rng.unit(), rng.unit(), rng.unit());
        const Vec3 centre(rng.range(-40, 40), rng.range(-5, 5), rng.range(-40, 40));
        return {centre - half, centre + half};
    }

    void fill(std::uint32_t n) {
        boxes.resize(n);
        present.assign(n, true);
        for (std::uint32_t row = 0; row < n; ++row) {
            boxes[row] = random_box();
            index.insert(row, boxes[row]);
        }
    }

    /// Inserts, removes, moves, throws and grows boxes at random; those that stay go in one batch.
    void stir(int changes) {
        std::vector<std::uint32_t> batch;
        for (int i = 0; i < changes; ++i) {
            const auto row = rng.below(static_cast<std::uint32_t>(boxes.size()));
            if (!present[row]) {
                boxes[row] = random_box();
                index.insert(row, boxes[row]);
                present[row] = true;
            } else if (rng.below(6) == 0) {
                index.remove(row);
                present[row] = false;
                std::erase(batch, row);
            } else {
                const Vec3 move(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
                Aabb& box = boxes[row];
                switch (rng.below(8)) {
                    case 0:
                        box = random_box();
                        break;
                    case 1:
                        box = box.grown(rng.unit());
                        break;
                    default:
                        box = {box.lower + move, box.upper + move};
                }
                batch.push_back(row);
            }
        }
        index.update(batch, boxes);
    }

    void expect_pairs_equal_all_pairs(int round) {
        ASSERT_EQ(index.size(), std::count(present.begin(), present.end(), true));
        std::vector<std::uint32_t> rows;
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            if (present[row]) {
                rows.push_back(row);
            }
        }
        Pairs found;
        index.query_each(
            rows, boxes, [&](std::uint32_t a, std::uint32_t b) { found.emplace_back(a, b); });
        std::sort(found.begin(), found.end());
        Pairs expected;
        for (const std::uint32_t a : rows) {
            for (const std::uint32_t b : rows) {
                if (boxes[a].overlaps(boxes[b])) {
                    expected.emplace_back(a, b);
                }
            }
        }
        // Also that no pair comes twice.
        ASSERT_TRUE(found == expected) << "round " << round;
        compared += expected.size();
    }

    std::size_t compared = 0;
};

TEST_P(EachKind, FindsThePairsOfAllPairsUnderRandomChange) {
    boxes.resize(400);
    present.assign(400, false);
    for (int round = 0; round < 40; ++round) {
        stir(round < 20 ? 300 : 3);  // many changes at once, and few
        expect_pairs_equal_all_pairs(round);
    }
    EXPECT_GT(compared, 50000U);
}

TEST_P(EachKind, FindsThePairsOfACrowdThatDriftsFarAway) {
    fill(300);
    std::vector<std::uint32_t> rows(300);
    for (std::uint32_t row = 0; row < 300; ++row) {
        rows[row] = row;
    }
    for (int round = 0; round < 30; ++round) {
        for (Aabb& box : boxes) {
            // Together, ever faster, to 10^5 m from where they began.
            const float step = 0.5F * std::pow(1.5F, static_cast<float>(round));
            const Vec3 move =
                Vec3(step, -0.5F * step, 0.1F * step) + Vec3(rng.unit(), 0, rng.unit());
            box = {box.lower + move, box.upper + move};
        }
        index.update(rows, boxes);
        expect_pairs_equal_all_pairs(round);
    }
}

TEST_P(EachKind, EmptiesAndFillsAgain) {
    for (int round = 0; round < 3; ++round) {
        fill(200);
        expect_pairs_equal_all_pairs(round);
        std::vector<std::uint32_t> order(200);
        for (std::uint32_t i = 0; i < 200; ++i) {
            order[i] = i;
            std::swap(order[i], order[rng.below(i + 1)]);
        }
        for (const std::uint32_t row : order) {
            index.remove(row);
            present[row] = false;
        }
        EXPECT_EQ(index.size(), 0U);
        index.query({Vec3::Constant(-1e9F), Vec3::Constant(1e9F)},
                    [](std::uint32_t) { FAIL() << "a box is left"; });
    }
}

TEST_P(EachKind, BearsTenThousandBoxesInOnePlace) {
    const Aabb box{Vec3(5, 5, 5), Vec3(6, 6, 6)};
    boxes.assign(10000, box);
    for (std::uint32_t row = 0; row < 10000; ++row) {
        index.insert(row, box);
    }
    std::vector<std::uint32_t> rows{0, 17, 9999};
    index.update(rows, boxes);
    std::size_t found = 0;
    index.query(box, [&](std::uint32_t) { ++found; });
    EXPECT_EQ(found, 10000U);
    found = 0;
    index.query({Vec3::Zero(), Vec3(4.99F, 9, 9)}, [&](std::uint32_t) { ++found; });
    EXPECT_EQ(found, 0U);
    for (std::uint32_t row = 0; row < 10000; ++row) {
        index.remove(row);
    }
    EXPECT_EQ(index.size(), 0U);
}

TEST_P(EachKind, TellsBoxesApartAtTheEndsOfTheWorld) {
    std::uint32_t row = 0;
    for (const float x : {-9.0e5F, 0.0F, 9.0e5F}) {
        for (int i = 0; i < 20; ++i) {
            const Vec3 c(x, static_cast<float>(i) * 0.5F, 0);
            index.insert(row++, {c - Vec3::Constant(0.2F), c + Vec3::Constant(0.2F)});
        }
    }
    index.insert(row, {Vec3::Constant(-1e6F), Vec3(1e6F, -100, 1e6F)});
    std::set<std::uint32_t> found;
    index.query({Vec3(-1, -1, -1), Vec3(1, 4.05F, 1)}, [&](std::uint32_t r) { found.insert(r); });
    EXPECT_EQ(found.size(), 9U);  // centres 0, 0.5, ... 4.0 reach down to at most 3.8
    EXPECT_EQ(*found.begin(), 20U);
    found.clear();
    index.query({Vec3(7, -200, 7), Vec3(8, -99, 8)}, [&](std::uint32_t r) { found.insert(r); });
    EXPECT_EQ(found, std::set<std::uint32_t>{row});
}

TEST_P(EachKind, CountsBoxesThatOnlyTouchAndPointBoxes) {
    index.insert(0, {Vec3::Zero(), Vec3::Ones()});
    index.insert(1, {Vec3(1, 0, 0), Vec3(2, 1, 1)});
    index.insert(2, {Vec3::Constant(0.5F), Vec3::Constant(0.5F)});
    std::set<std::uint32_t> found;
    index.query({Vec3::Zero(), Vec3::Ones()}, [&](std::uint32_t r) { found.insert(r); });
    EXPECT_EQ(found, (std::set<std::uint32_t>{0, 1, 2}));
    found.clear();
    index.query({Vec3::Constant(-INFINITY), Vec3::Constant(INFINITY)},
                [&](std::uint32_t r) { found.insert(r); });
    EXPECT_EQ(found, (std::set<std::uint32_t>{0, 1, 2}));
}

/// When the sweep enters the box, in double arithmetic; infinite for a miss.
double entry_of(const Sweep& sweep, const Aabb& box) {
    double enter = 0.0;
    double leave = INFINITY;
    for (int i = 0; i < 3; ++i) {
        const double o = sweep.origin[i];
        const double d = sweep.direction[i];
        const double lower = static_cast<double>(box.lower[i]) - sweep.half_extents[i];
        const double upper = static_cast<double>(box.upper[i]) + sweep.half_extents[i];
        if (d == 0.0) {
            if (o < lower || o > upper) {
                return INFINITY;
            }
            continue;
        }
        enter = std::max(enter, std::min((lower - o) / d, (upper - o) / d));
        leave = std::min(leave, std::max((lower - o) / d, (upper - o) / d));
    }
    return enter <= leave ? enter : INFINITY;
}

TEST_P(EachKind, CastsMeetWhatBruteForceMeets) {
    fill(1000);
    stir(500);
    int hits = 0;
    for (int i = 0; i < 600; ++i) {
        Sweep sweep;
        sweep.origin = Vec3(rng.range(-60, 60), rng.range(-8, 8), rng.range(-60, 60));
        sweep.direction = Vec3(rng.range(-1, 1), rng.range(-0.3F, 0.3F), rng.range(-1, 1));
        if (i % 5 == 0) {
            sweep.direction = Vec3::Unit(i % 3) * (i % 2 == 0 ? 1.0F : -1.0F);
        }
        sweep.direction.normalize();
        if (i % 2 == 0) {
            sweep.half_extents = 2.0F * Vec3(rng.unit(), rng.unit(), rng.unit());
        }
        const float limit = i % 7 == 0 ? INFINITY : rng.range(1, 80);
        std::set<std::uint32_t> visited;
        const float same = index.cast(sweep, limit, [&](std::uint32_t row, float current) {
            visited.insert(row);
            return current;
        });
        EXPECT_EQ(same, limit);
        double nearest = limit;
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            const double entry = present[row] ? entry_of(sweep, boxes[row]) : INFINITY;
            nearest = std::min(nearest, entry);
            // A clear hit must be visited, a clear miss must not: the box is grown by far more than
            // the rounding of coordinates up to 100 m.
            if (entry < INFINITY && entry <= limit - 1e-3) {
                EXPECT_TRUE(visited.contains(row));
            } else if (!present[row] || entry_of(sweep, boxes[row].grown(1e-3F)) > limit + 1e-3) {
                EXPECT_FALSE(visited.contains(row));
            }
        }
        // Cutting the sweep short at each visit finds the nearest.
        const float found = index.cast(sweep, limit, [&](std::uint32_t row, float current) {
            return std::min(current, static_cast<float>(entry_of(sweep, boxes[row])));
        });
        EXPECT_EQ(found, static_cast<float>(nearest));
        hits += nearest < limit ? 1 : 0;
    }
    EXPECT_GT(hits, 150);
}

TEST_P(EachKind, ACastStopsWhenToldTo) {
    fill(500);
    int visits = 0;
    const float limit = index.cast(
        {Vec3(-60, 0, 0), Vec3::UnitX(), Vec3::Ones()}, 200.0F, [&](std::uint32_t, float) {
            ++visits;
            return -1.0F;
        });
    EXPECT_EQ(limit, -1.0F);
    EXPECT_EQ(visits, 1);
}

TEST_P(EachKind, FindsTheNearestBoxOfAPoint) {
    fill(600);
    stir(300);
    for (int i = 0; i < 500; ++i) {
        const Vec3 point(rng.range(-70, 70), rng.range(-30, 30), rng.range(-70, 70));
        const float limit = i % 3 == 0 ? INFINITY : rng.range(0, 30);
        float expected = limit;
        for (std::uint32_t row = 0; row < boxes.size(); ++row) {
            if (present[row]) {
                expected = std::min(expected, std::sqrt(squared_distance(boxes[row], point)));
            }
        }
        const float found = index.nearest(point, limit, [&](std::uint32_t row, float current) {
            return std::min(current, std::sqrt(squared_distance(boxes[row], point)));
        });
        // A root and its square may differ by a rounding from the original.
        EXPECT_NEAR(found, expected, i % 3 == 0 ? 1e-5F * (1 + expected) : 1e-5F * (1 + limit));
    }
}

TEST_P(EachKind, VisitsInAnOrderThatDependsOnTheCallsAlone) {
    const auto history = [&] {
        rng = core::Rng(11);
        index = BoxIndex(GetParam(), BroadphaseSettings());
        boxes.assign(500, Aabb());
        present.assign(500, false);
        std::vector<std::uint32_t> visits;
        for (int round = 0; round < 10; ++round) {
            stir(400);
            index.query({Vec3(-30, -3, -30), Vec3(30, 3, 30)},
                        [&](std::uint32_t row) { visits.push_back(row); });
        }
        return visits;
    };
    EXPECT_EQ(history(), history());
}

TEST_P(EachKind, MovesBoxesAboutWithoutAllocationAfterWarmUp) {
    constexpr std::uint32_t kBoxes = 1000;
    index.reserve(kBoxes);
    boxes.resize(kBoxes);
    std::vector<std::uint32_t> rows(kBoxes);
    std::vector<std::uint32_t> few;
    few.reserve(kBoxes);
    const auto place = [&](std::uint32_t row) {
        const Vec3 c(rng.range(-15, 15), rng.range(0, 5), rng.range(-15, 15));
        boxes[row] = {c - Vec3::Constant(0.5F), c + Vec3::Constant(0.5F)};
    };
    for (std::uint32_t row = 0; row < kBoxes; ++row) {
        rows[row] = row;
        place(row);
        index.insert(row, boxes[row]);
    }
    std::uint64_t before = 0;
    for (int round = 0; round < 400; ++round) {
        if (round == 200) {
            before = allocation_count();
        }
        few.clear();
        for (std::uint32_t row = 0; row < kBoxes; ++row) {
            const Vec3 move(rng.range(-0.2F, 0.2F), rng.range(-0.2F, 0.2F), rng.range(-0.2F, 0.2F));
            boxes[row] = {boxes[row].lower + move, boxes[row].upper + move};
            if (!(boxes[row].lower.cwiseAbs().maxCoeff() < 17.0F)) {
                place(row);
            }
            if (row % 50 == static_cast<std::uint32_t>(round) % 50) {
                few.push_back(row);
            }
        }
        index.update(round % 2 == 0 ? rows : few, boxes);
        const std::uint32_t again = rng.below(kBoxes);
        index.remove(again);
        index.insert(again, boxes[again]);
        std::size_t found = 0;
        index.query(boxes[0], [&](std::uint32_t) { ++found; });
        ASSERT_GT(found, 0U);
    }
    EXPECT_EQ(allocation_count(), before);
}

TEST_P(EachKind, HandsItsBoxesOverToAnotherKind) {
    fill(300);
    stir(200);
    for (const BroadphaseKind kind : kKinds) {
        index.change_to(kind, 300);
        EXPECT_EQ(index.kind(), kind);
        expect_pairs_equal_all_pairs(0);
    }
}

INSTANTIATE_TEST_SUITE_P(Broadphase, EachKind, testing::ValuesIn(kKinds), [](const auto& kind) {
    return std::string(name_of(kind.param));
});

}  // namespace
}  // namespace zoned::spatial
