#include "server/ai/ants/max_min.h"

#include "server/ai/ants/tsp_text.h"
#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

Distances random_distances(core::Rng& rng, std::size_t n) {
    std::vector<Length> lengths(n * n, 0);
    for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = a + 1; b < n; ++b) {
            lengths[a * n + b] = lengths[b * n + a] = static_cast<Length>(1 + rng.below(1000));
        }
    }
    return Distances::make(n, lengths).value();
}

/// The best tour by dynamic programming over sets (Held and Karp 1962): nothing in common with
/// ants.
std::int64_t best_by_sets(const Distances& d) {
    const std::size_t n = d.size() - 1;  // the last place is the start
    const auto start = static_cast<Place>(n);
    std::vector<std::int64_t> best((std::size_t{1} << n) * n, INT64_MAX / 2);
    for (std::size_t set = 1; set < std::size_t{1} << n; ++set) {
        for (std::size_t last = 0; last < n; ++last) {
            if ((set >> last & 1U) == 0) {
                continue;
            }
            const std::size_t others = set ^ (std::size_t{1} << last);
            std::int64_t& path = best[set * n + last];
            path = others == 0 ? d.between(start, static_cast<Place>(last)) : path;
            for (std::size_t p = 0; p < n; ++p) {
                if ((others >> p & 1U) != 0) {
                    path = std::min(path,
                                    best[others * n + p] +
                                        d.between(static_cast<Place>(p), static_cast<Place>(last)));
                }
            }
        }
    }
    std::int64_t least = INT64_MAX;
    for (std::size_t last = 0; last < n; ++last) {
        least = std::min(least,
                         best[((std::size_t{1} << n) - 1) * n + last] +
                             d.between(static_cast<Place>(last), start));
    }
    return least;
}

bool visits_all_once(std::span<const Place> tour, std::size_t n) {
    std::vector<Place> sorted(tour.begin(), tour.end());
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        if (sorted[i] != i) {
            return false;
        }
    }
    return sorted.size() == n;
}

TEST(Tour, StaysATourAndIsAsMuchShorterAsItSays) {
    core::Rng rng(1);
    for (int round = 0; round < 300; ++round) {
        const std::size_t n = 3 + rng.below(40);
        const Distances d = random_distances(rng, n);
        const std::size_t near = std::min<std::size_t>(n - 1, 1 + rng.below(12));
        const std::vector<Neighbour> nearest = d.nearest(near);
        std::vector<Place> order(n);
        for (Place p = 0; p < n; ++p) {
            order[p] = p;
        }
        for (std::size_t i = n; i-- > 1;) {
            std::swap(order[i], order[rng.below(static_cast<std::uint32_t>(i) + 1)]);
        }
        for (const LocalSearch search : {LocalSearch::kTwoOpt, LocalSearch::kOrOpt}) {
            Tour tour(n);
            tour.set(order);
            const std::int64_t gained = tour.improve(d, nearest, near, search);
            ASSERT_TRUE(visits_all_once(tour.order(), n));
            ASSERT_EQ(d.length_of(order) - d.length_of(tour.order()), gained);
            // Don't-look bits may miss something, which another call finds; then nothing is left.
            int calls = 0;
            while (tour.improve(d, nearest, near, search) > 0) {
                ASSERT_LT(++calls, 10);
            }
        }
    }
}

TEST(MaxMin, FindsTheBestToursOfSmallInstances) {
    core::Rng rng(2);
    for (int round = 0; round < 20; ++round) {
        const Distances d = random_distances(rng, 4 + rng.below(8));
        const std::int64_t best = best_by_sets(d);
        for (const LocalSearch search :
             {LocalSearch::kNone, LocalSearch::kTwoOpt, LocalSearch::kOrOpt}) {
            MaxMinSettings settings;
            settings.local = search;
            settings.seed = static_cast<std::uint64_t>(round);
            MaxMin ants(d, settings);
            EXPECT_TRUE(ants.run(200'000, best)) << ants.best_length() << ", not " << best;
            EXPECT_EQ(ants.best_length(), best);
            EXPECT_EQ(d.length_of(ants.best()), best);
            EXPECT_TRUE(visits_all_once(ants.best(), d.size()));
        }
    }
}

TspInstance read_instance(const std::string& name) {
    std::ifstream in(ZONED_SOURCE_DIR "/tests/conformance/tsplib/" + name + ".tsp");
    std::stringstream text;
    text << in.rdbuf();
    return parse_tsp(text.str()).value();
}

/// Work that is counted: so many tours as took a third of a second where it was measured.
TEST(MaxMin, FindsPublishedOptimaWithTwoOpt) {
    const std::pair<const char*, std::int64_t> cases[] = {
        {"berlin52", 7542}, {"eil51", 426}, {"kroA100", 21282}};
    for (const auto& [name, optimum] : cases) {
        const TspInstance instance = read_instance(name);
        EXPECT_EQ(instance.name, name);
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
            MaxMinSettings settings;
            settings.local = LocalSearch::kTwoOpt;
            settings.seed = seed;
            MaxMin ants(instance.distances, settings);
            EXPECT_TRUE(ants.run(40'000, optimum)) << name << ", seed " << seed;
            EXPECT_EQ(instance.distances.length_of(ants.best()), optimum);
        }
    }
}

TEST(MaxMin, ComesWithinATenthOfAPercentOfAClusteredInstance) {
    const TspInstance d198 = read_instance("d198");
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        MaxMinSettings settings;
        settings.seed = seed;
        MaxMin ants(d198.distances, settings);
        EXPECT_TRUE(ants.run(10'000, 15780 * 1001 / 1000)) << ants.best_length();
    }
}

TEST(MaxMin, GivesTheSameTourForTheSameSeedHoweverItsWorkIsCut) {
    core::Rng rng(3);
    const Distances d = random_distances(rng, 30);
    MaxMinSettings settings;
    settings.local = LocalSearch::kNone;
    MaxMin at_once(d, settings);
    MaxMin in_parts(d, settings);
    at_once.run(6'000);
    for (std::uint64_t tours = 100; tours <= 6'000; tours += 100) {
        in_parts.run(tours);
    }
    EXPECT_EQ(at_once.best_length(), in_parts.best_length());
    EXPECT_THAT(at_once.best(), testing::ElementsAreArray(in_parts.best()));
    settings.seed = 2;
    MaxMin other(d, settings);
    other.run(30);
    MaxMin first(d, MaxMinSettings{.local = LocalSearch::kNone});
    first.run(30);
    EXPECT_THAT(first.best(), testing::Not(testing::ElementsAreArray(other.best())));
}

TEST(MaxMin, AllocatesNothingWhileItSearches) {
    core::Rng rng(4);
    const Distances d = random_distances(rng, 40);
    MaxMin ants(d, {});
    const std::uint64_t before = allocation_count();
    ants.run(1000);
    EXPECT_EQ(allocation_count() - before, 0U);
}

TEST(Distances, OfAGraphAreItsShortestWays) {
    // A ring of four with one chord: 0-1-2-3-0, 0-2.
    const Distances::Edge edges[] = {{0, 1, 4}, {1, 2, 3}, {2, 3, 5}, {3, 0, 9}, {0, 2, 6}};
    const auto d = Distances::of_graph(4, edges);
    ASSERT_TRUE(d) << d.error();
    EXPECT_EQ(d->between(0, 2), 6);
    EXPECT_EQ(d->between(1, 3), 8);
    EXPECT_EQ(d->between(0, 3), 9);
    EXPECT_EQ(d->between(3, 0), 9);
}

TEST(Distances, AreRefusedWithThePlaceAndTheReason) {
    using testing::HasSubstr;
    const Distances::Edge apart[] = {{0, 1, 4}};
    EXPECT_THAT(Distances::of_graph(3, apart).error(), HasSubstr("from place 0 to 2"));
    const Distances::Edge off[] = {{0, 7, 4}};
    EXPECT_THAT(Distances::of_graph(3, off).error(), HasSubstr("edge 0 from place 0 to 7"));
    const Distances::Edge negative[] = {{0, 1, 4}, {1, 2, -1}};
    EXPECT_THAT(Distances::of_graph(3, negative).error(), HasSubstr("edge 1"));
    EXPECT_THAT(Distances::make(2, {0, 1, 1, 0}).error(), HasSubstr("from 3 to"));
    EXPECT_THAT(Distances::make(3, {0, 1, 2, 1, 0, 3, 9, 3, 0}).error(),
                HasSubstr("from place 0 to 2 is 2, back 9"));
    EXPECT_THAT(Distances::make(3, {0, 1, 2}).error(), HasSubstr("3 distances"));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
