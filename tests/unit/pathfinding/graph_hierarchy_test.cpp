#include "server/ai/pathfinding/hierarchy/graph_hierarchy.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <queue>

namespace zoned::ai::pathfinding {

namespace {

/// Nodes on a square, with links to some near ones, some of them in one direction.
struct RandomHierarchyGraph {
    std::vector<Vec3> places;
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> to;
    std::vector<std::uint8_t> open;
    std::vector<std::uint8_t> linked;
    std::vector<std::uint32_t> back;

    RandomHierarchyGraph(core::Rng& rng, std::uint32_t nodes) {
        for (std::uint32_t n = 0; n < nodes; ++n) {
            places.emplace_back(rng.range(0.0F, 100.0F), 0.0F, rng.range(0.0F, 100.0F));
            open.push_back(rng.below(10) != 0 ? 1 : 0);
        }
        std::vector<std::vector<std::uint32_t>> out(nodes);
        for (std::uint32_t a = 0; a < nodes; ++a) {
            for (std::uint32_t b = 0; b < a; ++b) {
                if ((places[a] - places[b]).norm() < 7.0F) {
                    const std::uint32_t paths = rng.below(4);
                    if (paths != 1) {
                        out[a].push_back(b);
                    }
                    if (paths != 2) {
                        out[b].push_back(a);
                    }
                }
            }
        }
        link(out);
        for (std::uint8_t& l : linked) {
            l = rng.below(12) != 0 ? 1 : 0;
        }
    }

    /// Nodes in rows and columns, with neighbours linked in both directions.
    explicit RandomHierarchyGraph(std::uint32_t side) {
        std::vector<std::vector<std::uint32_t>> out(std::size_t{side} * side);
        for (std::uint32_t n = 0; n < side * side; ++n) {
            places.emplace_back(static_cast<float>(n % side), 0.0F, static_cast<float>(n / side));
            open.push_back(1);
            for (const std::uint32_t other : {n + 1, n + side}) {
                if (other < side * side && (other == n + side || other % side != 0)) {
                    out[n].push_back(other);
                    out[other].push_back(n);
                }
            }
        }
        link(out);
    }

    void link(const std::vector<std::vector<std::uint32_t>>& out) {
        first.push_back(0);
        for (const auto& links : out) {
            to.insert(to.end(), links.begin(), links.end());
            first.push_back(static_cast<std::uint32_t>(to.size()));
        }
        linked.assign(to.size(), 1);
        for (std::uint32_t a = 0; a < out.size(); ++a) {
            for (std::uint32_t i = first[a]; i < first[a + 1]; ++i) {
                back.push_back(GraphHierarchy::kNone);
                for (std::uint32_t k = first[to[i]]; k < first[to[i] + 1]; ++k) {
                    if (to[k] == a) {
                        back.back() = k;
                    }
                }
            }
        }
    }

    [[nodiscard]] NodeGraph view() const { return {places, first, to, open, linked, back}; }

    [[nodiscard]] std::vector<bool> reached(std::uint32_t from) const {
        std::vector<bool> seen(places.size(), false);
        std::queue<std::uint32_t> queue({from});
        seen[from] = true;
        while (!queue.empty()) {
            const std::uint32_t n = queue.front();
            queue.pop();
            for (std::uint32_t i = first[n]; i < first[n + 1]; ++i) {
                if (linked[i] != 0 && open[to[i]] != 0 && !seen[to[i]]) {
                    seen[to[i]] = true;
                    queue.push(to[i]);
                }
            }
        }
        return seen;
    }
};

TEST(GraphHierarchy, LeadWhereverLinksDoAndNowhereElse) {
    core::Rng rng(41);
    GraphHierarchy clusters;
    std::size_t joined = 0;
    std::size_t apart = 0;
    for (int round = 0; round < 12; ++round) {
        const RandomHierarchyGraph g(rng, 350);
        clusters.build(g.view());
        for (int i = 0; i < 60; ++i) {
            const std::uint32_t from = rng.below(350);
            const std::uint32_t goal = rng.below(350);
            if (g.open[from] == 0 || g.open[goal] == 0) {
                continue;
            }
            const std::vector<bool> reached = g.reached(from);
            clusters.prepare(goal);
            ASSERT_EQ(clusters.joined(from, goal), reached[goal]);
            clusters.flood(from);
            for (std::uint32_t n = 0; n < 350; ++n) {
                ASSERT_EQ(clusters.flooded(n), g.open[n] != 0 && reached[n]);
            }
            ++(reached[goal] ? joined : apart);
            std::uint32_t at = from;
            std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
            std::size_t steps = 0;
            while (reached[goal] && at != goal) {
                const std::size_t count = clusters.segment(g.view(), at, goal, segment);
                ASSERT_GT(count, 0U);
                for (std::size_t k = 0; k < count; ++k) {
                    bool link = false;
                    for (std::uint32_t e = g.first[at]; e < g.first[at + 1]; ++e) {
                        link = link || (g.to[e] == segment[k] && g.linked[e] != 0);
                    }
                    ASSERT_TRUE(link && g.open[segment[k]] != 0);
                    at = segment[k];
                }
                ASSERT_LT(++steps, 350U);
            }
        }
    }
    EXPECT_GT(joined, 100U);
    EXPECT_GT(apart, 50U);
}

/// The waypoints that a change touches: nodes that open or close, and both ends of such links.
std::vector<std::uint32_t> turn_some(RandomHierarchyGraph& g, core::Rng& rng) {
    std::vector<std::uint32_t> touched;
    const auto nodes = static_cast<std::uint32_t>(g.places.size());
    for (std::uint32_t i = rng.below(4); i > 0; --i) {
        const std::uint32_t n = rng.below(nodes);
        g.open[n] ^= 1U;
        touched.push_back(n);
    }
    for (std::uint32_t i = rng.below(3); i > 0; --i) {
        const std::uint32_t n = rng.below(nodes);
        if (g.first[n] != g.first[n + 1]) {
            const std::uint32_t link = g.first[n] + rng.below(g.first[n + 1] - g.first[n]);
            g.linked[link] ^= 1U;
            touched.insert(touched.end(), {n, g.to[link]});
        }
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
}

/// Empty, or the reason: changed clusters disagree with the graph, or with clusters that are built
/// anew.
std::string differs(const RandomHierarchyGraph& g, GraphHierarchy& clusters, core::Rng& rng) {
    GraphHierarchy anew;
    anew.build(g.view());
    const auto nodes = static_cast<std::uint32_t>(g.places.size());
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t from = rng.below(nodes);
        const std::uint32_t goal = rng.below(nodes);
        if (g.open[from] == 0 || g.open[goal] == 0) {
            continue;
        }
        const std::vector<bool> reached = g.reached(from);
        clusters.prepare(goal);
        anew.prepare(goal);
        if (clusters.joined(from, goal) != reached[goal] ||
            anew.joined(from, goal) != reached[goal]) {
            return "joined";
        }
        clusters.flood(from);
        for (std::uint32_t n = 0; n < nodes; ++n) {
            if (clusters.flooded(n) != (g.open[n] != 0 && reached[n])) {
                return "flooded " + std::to_string(n);
            }
        }
        std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
        std::uint32_t at = from;
        for (std::uint32_t steps = 0; reached[goal] && at != goal; ++steps) {
            const std::size_t count = clusters.segment(g.view(), at, goal, segment);
            if (count == 0 || steps > nodes) {
                return "a segment leads nowhere";
            }
            std::array<std::uint32_t, GraphHierarchy::kMost + 1> same{};
            if (anew.segment(g.view(), at, goal, same) != count ||
                !std::equal(segment.begin(), segment.begin() + count, same.begin())) {
                return "a segment is another than by groups built anew";
            }
            for (std::size_t k = 0; k < count; ++k) {
                bool link = false;
                for (std::uint32_t e = g.first[at]; e < g.first[at + 1]; ++e) {
                    link = link || (g.to[e] == segment[k] && g.linked[e] != 0);
                }
                if (!link || g.open[segment[k]] == 0) {
                    return "a segment along what is no link";
                }
                at = segment[k];
            }
        }
    }
    return {};
}

TEST(GraphHierarchy, AreAfterEachChangeAsGoodAsBuiltAnew) {
    core::Rng rng(43);
    for (int world = 0; world < 3; ++world) {
        RandomHierarchyGraph g(rng, 350);
        GraphHierarchy clusters;
        clusters.build(g.view());
        for (int change = 0; change < 150; ++change) {
            const std::vector<std::uint32_t> touched = turn_some(g, rng);
            clusters.change(g.view(), touched);
            ASSERT_EQ(differs(g, clusters, rng), "") << world << " " << change;
        }
    }
    // An unreported change is found out.
    RandomHierarchyGraph g(rng, 350);
    GraphHierarchy clusters;
    clusters.build(g.view());
    for (std::uint32_t n = 0; n < 350; n += 3) {
        g.open[n] = 0;
    }
    std::string found;
    for (int i = 0; i < 50 && found.empty(); ++i) {
        found = differs(g, clusters, rng);
    }
    EXPECT_NE(found, "");
}

TEST(GraphHierarchy, SayWhereMoreMayBeReachedThanBefore) {
    core::Rng rng(44);
    std::size_t more = 0;
    std::size_t quiet = 0;
    std::size_t asked = 0;
    for (int world = 0; world < 3; ++world) {
        RandomHierarchyGraph g(rng, 300);
        if (world != 0) {  // all links lead both ways
            for (std::uint32_t link = 0; link < g.linked.size(); ++link) {
                g.linked[link] = g.back[link] != GraphHierarchy::kNone ? 1 : 0;
            }
        }
        GraphHierarchy clusters;
        clusters.build(g.view());
        for (int change = 0; change < 150; ++change) {
            const RandomHierarchyGraph before = g;
            std::vector<std::uint32_t> touched;
            for (int i = 0; i < 2; ++i) {
                touched.push_back(rng.below(150) + static_cast<std::uint32_t>(150 * i));
                g.open[touched.back()] ^= 1U;
            }
            clusters.change(g.view(), touched);
            for (std::uint32_t n = 0; n < 300; n += 11) {
                if (g.open[n] == 0 || before.open[n] == 0) {
                    continue;
                }
                const std::vector<bool> was = before.reached(n);
                const std::vector<bool> is = g.reached(n);
                bool gained = false;
                for (std::uint32_t k = 0; k < 300; ++k) {
                    gained = gained || (is[k] && !was[k] && before.open[k] != 0);
                }
                ++asked;
                more += gained ? 1U : 0U;
                quiet += clusters.joined_anew(n) ? 0U : 1U;
                ASSERT_TRUE(!gained || clusters.joined_anew(n)) << world << " " << change;
            }
        }
    }
    EXPECT_GT(more, 20U);
    EXPECT_GT(quiet, asked / 4) << "most changes join nothing where all links lead both ways";
}

/// Rooms of a graph that is many blocks of clusters, with doors between them.
TEST(GraphHierarchy, SayExactlyWhatDoorsOfALargeGraphHaveJoined) {
    constexpr std::uint32_t kSide = 90;
    constexpr std::uint32_t kRoom = 15;
    core::Rng rng(45);
    RandomHierarchyGraph g(kSide);
    std::vector<std::uint32_t> doors;
    for (std::uint32_t n = 0; n < kSide * kSide; ++n) {
        const std::uint32_t x = n % kSide % kRoom;
        const std::uint32_t y = n / kSide % kRoom;
        if (x == 0 || y == 0) {
            g.open[n] = 0;
            if (x == 7 || y == 7) {
                doors.push_back(n);
                g.open[n] = rng.below(2) == 0 ? 1 : 0;
            }
        }
    }
    GraphHierarchy clusters;
    clusters.build(g.view());
    std::size_t joined = 0;
    std::size_t quiet = 0;
    for (int change = 0; change < 120; ++change) {
        const RandomHierarchyGraph before = g;
        std::vector<std::uint32_t> touched;
        for (std::uint32_t i = 0; i <= rng.below(3); ++i) {
            touched.push_back(doors[rng.below(static_cast<std::uint32_t>(doors.size()))]);
        }
        std::sort(touched.begin(), touched.end());
        touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
        for (const std::uint32_t n : touched) {
            g.open[n] ^= 1U;
        }
        clusters.change(g.view(), touched);
        for (int i = 0; i < 6; ++i) {
            const std::uint32_t n = rng.below(kSide * kSide);
            if (g.open[n] == 0 || before.open[n] == 0) {
                continue;
            }
            const std::vector<bool> was = before.reached(n);
            const std::vector<bool> is = g.reached(n);
            bool gained = false;
            for (std::uint32_t k = 0; k < kSide * kSide; ++k) {
                gained = gained || (is[k] && !was[k] && before.open[k] != 0);
            }
            ASSERT_EQ(clusters.joined_anew(n), gained) << change << " " << n;
            ++(gained ? joined : quiet);
        }
    }
    EXPECT_GT(joined, 20U);
    EXPECT_GT(quiet, 100U);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
