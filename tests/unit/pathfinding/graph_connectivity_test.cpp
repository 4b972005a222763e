#include "server/ai/pathfinding/hierarchy/graph_connectivity.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace zoned::ai::pathfinding {

namespace {

/// Clusters in a row of blocks, with links to others near by, some of them in one direction.
struct Linked {
    std::vector<std::vector<std::uint32_t>> out;
    std::vector<std::vector<std::uint32_t>> in;
    std::vector<bool> there;

    explicit Linked(std::uint32_t clusters) : out(clusters), in(clusters), there(clusters, true) {}

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(out.size()); }

    void link(std::uint32_t a, std::uint32_t b) {
        if (std::find(out[a].begin(), out[a].end(), b) == out[a].end()) {
            out[a].push_back(b);
            in[b].push_back(a);
        }
    }

    void cut(std::uint32_t a, std::uint32_t b) {
        std::erase(out[a], b);
        std::erase(in[b], a);
    }

    /// By looking at all: the least cluster that is joined with each.
    [[nodiscard]] std::vector<std::uint32_t> parts() const {
        std::vector<std::uint32_t> part(size(), ~0U);
        for (std::uint32_t seed = 0; seed < size(); ++seed) {
            std::vector<std::uint32_t> open;
            if (there[seed] && part[seed] == ~0U) {
                open.push_back(seed);
                part[seed] = seed;
            }
            while (!open.empty()) {
                const std::uint32_t at = open.back();
                open.pop_back();
                for (const auto* beside : {&out[at], &in[at]}) {
                    for (const std::uint32_t next : *beside) {
                        if (part[next] == ~0U) {
                            part[next] = seed;
                            open.push_back(next);
                        }
                    }
                }
            }
        }
        return part;
    }

    /// Whether the same clusters share a number.
    [[nodiscard]] bool same(const GraphConnectivity& parts) const {
        const std::vector<std::uint32_t> part = this->parts();
        std::map<std::uint32_t, std::uint32_t> number_of;
        std::map<std::uint32_t, std::uint32_t> part_of;
        for (std::uint32_t c = 0; c < size(); ++c) {
            if (there[c] &&
                (number_of.try_emplace(part[c], parts.of(c)).first->second != parts.of(c) ||
                 part_of.try_emplace(parts.of(c), part[c]).first->second != part[c])) {
                return false;
            }
        }
        return true;
    }

    void renew(GraphConnectivity& parts) const {
        parts.renew([this](std::uint32_t c) { return std::span(out[c]); },
                    [this](std::uint32_t c) { return std::span(in[c]); });
    }
};

constexpr std::uint32_t kOfBlock = 9;

GraphConnectivity parts_of(const Linked& linked) {
    GraphConnectivity parts;
    parts.start(linked.size() / kOfBlock + 1);
    for (std::uint32_t c = 0; c < linked.size(); ++c) {
        parts.add(c, c / kOfBlock);
    }
    linked.renew(parts);
    return parts;
}

std::uint32_t near(core::Rng& rng, std::uint32_t c, std::uint32_t size) {
    return (c + size - 12 + rng.below(24)) % size;
}

TEST(GraphConnectivity, AreAfterEachChangeThoseOfALookAtAll) {
    core::Rng rng(3);
    constexpr std::uint32_t kClusters = 240;
    std::size_t joined = 0;
    std::size_t parted = 0;
    for (int world = 0; world < 4; ++world) {
        Linked linked(kClusters);
        for (std::uint32_t i = 0; i < 150; ++i) {
            const std::uint32_t a = rng.below(kClusters);
            linked.link(a, near(rng, a, kClusters));
        }
        GraphConnectivity parts = parts_of(linked);
        ASSERT_TRUE(linked.same(parts));
        for (int change = 0; change < 300; ++change) {
            const auto count = [&linked] {
                std::vector<std::uint32_t> all = linked.parts();
                std::sort(all.begin(), all.end());
                return std::unique(all.begin(), all.end()) - all.begin();
            };
            const auto before = count();
            for (std::uint32_t i = rng.below(3); i < 3; ++i) {
                const std::uint32_t a = rng.below(kClusters);
                const std::uint32_t b = near(rng, a, kClusters);
                if (!linked.there[a]) {
                    linked.there[a] = true;
                    parts.add(a, rng.below(kClusters / kOfBlock));
                } else if (rng.below(8) == 0) {
                    for (const auto& beside : {linked.out[a], linked.in[a]}) {
                        for (const std::uint32_t other : beside) {
                            linked.cut(a, other);
                            linked.cut(other, a);
                            if (other != a) {
                                parts.touch(other);
                            }
                        }
                    }
                    linked.there[a] = false;
                    parts.remove(a);
                } else if (linked.there[b]) {
                    const bool is = std::count(linked.out[a].begin(), linked.out[a].end(), b) != 0;
                    is ? linked.cut(a, b) : linked.link(a, b);
                    parts.touch(a);
                    parts.touch(b);
                }
            }
            linked.renew(parts);
            ASSERT_TRUE(linked.same(parts)) << world << " " << change;
            joined += count() < before ? 1U : 0U;
            parted += count() > before ? 1U : 0U;
        }
    }
    EXPECT_GT(joined, 100U);
    EXPECT_GT(parted, 100U);
}

TEST(GraphConnectivity, MissWhatNobodyTellsThemOf) {
    Linked linked(100);
    for (std::uint32_t c = 0; c + 1 < 100; ++c) {
        linked.link(c, c + 1);
    }
    GraphConnectivity parts = parts_of(linked);
    ASSERT_TRUE(linked.same(parts));
    linked.cut(50, 51);
    linked.renew(parts);
    EXPECT_FALSE(linked.same(parts));
    parts.touch(50);
    parts.touch(51);
    linked.renew(parts);
    EXPECT_TRUE(linked.same(parts));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
