#include "server/ai/navigation/node_clusters.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <queue>

namespace zoned::ai::navigation {

namespace {

/// Nodes on a square, with links to some near ones, some of them one way.
struct RandomGraph {
    std::vector<Vec3> places;
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> to;
    std::vector<std::uint8_t> open;
    std::vector<std::uint8_t> linked;
    std::vector<std::uint32_t> back;

    RandomGraph(core::Rng& rng, std::uint32_t nodes) {
        for (std::uint32_t n = 0; n < nodes; ++n) {
            places.emplace_back(rng.range(0.0F, 100.0F), 0.0F, rng.range(0.0F, 100.0F));
            open.push_back(rng.below(10) != 0 ? 1 : 0);
        }
        std::vector<std::vector<std::uint32_t>> out(nodes);
        for (std::uint32_t a = 0; a < nodes; ++a) {
            for (std::uint32_t b = 0; b < a; ++b) {
                if ((places[a] - places[b]).norm() < 7.0F) {
                    const std::uint32_t ways = rng.below(4);
                    if (ways != 1) {
                        out[a].push_back(b);
                    }
                    if (ways != 2) {
                        out[b].push_back(a);
                    }
                }
            }
        }
        first.push_back(0);
        for (const auto& links : out) {
            to.insert(to.end(), links.begin(), links.end());
            first.push_back(static_cast<std::uint32_t>(to.size()));
        }
        for (std::uint32_t a = 0; a < nodes; ++a) {
            for (std::uint32_t i = first[a]; i < first[a + 1]; ++i) {
                linked.push_back(rng.below(12) != 0 ? 1 : 0);
                back.push_back(NodeClusters::kNone);
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

TEST(NodeClusters, LeadWhereverLinksDoAndNowhereElse) {
    core::Rng rng(41);
    NodeClusters clusters;
    std::size_t joined = 0;
    std::size_t apart = 0;
    for (int round = 0; round < 12; ++round) {
        const RandomGraph g(rng, 350);
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
            std::array<std::uint32_t, NodeClusters::kMost + 1> leg{};
            std::size_t steps = 0;
            while (reached[goal] && at != goal) {
                const std::size_t count = clusters.leg(g.view(), at, goal, leg);
                ASSERT_GT(count, 0U);
                for (std::size_t k = 0; k < count; ++k) {
                    bool link = false;
                    for (std::uint32_t e = g.first[at]; e < g.first[at + 1]; ++e) {
                        link = link || (g.to[e] == leg[k] && g.linked[e] != 0);
                    }
                    ASSERT_TRUE(link && g.open[leg[k]] != 0);
                    at = leg[k];
                }
                ASSERT_LT(++steps, 350U);
            }
        }
    }
    EXPECT_GT(joined, 100U);
    EXPECT_GT(apart, 50U);
}

}  // namespace

}  // namespace zoned::ai::navigation
