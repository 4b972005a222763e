// build: computes
#include "server/ai/pathfinding/grid/components.h"

#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <map>

namespace zoned::ai::pathfinding {

namespace {

/// Empty where both agree on which places reach which.
std::string differs(const GridMap& map, const Components& a, const Components& b) {
    std::map<std::uint32_t, std::uint32_t> to;
    std::map<std::uint32_t, std::uint32_t> back;
    for (Place p = 0; p < map.places(); ++p) {
        const std::uint32_t i = a.of(p);
        const std::uint32_t k = b.of(p);
        if ((i == 0) != (k == 0) || to.try_emplace(i, k).first->second != k ||
            back.try_emplace(k, i).first->second != i) {
            return "place " + std::to_string(p);
        }
    }
    return "";
}

TEST(Components, AreAfterChangesWhatTheyWouldBeAnew) {
    core::Rng rng(21);
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        GridMap map = seed % 2 == 0 ? rooms_map(70, 60, 8, seed) : random_map(70, 60, 0.4F, seed);
        Components components;
        components.label(map);
        for (int round = 0; round < 60; ++round) {
            std::vector<CellChange> changes;
            const auto count = rng.below(round % 7 == 0 ? 40 : 4);
            const std::uint32_t left = rng.below(70);
            const std::uint32_t top = rng.below(60);
            const bool passable = rng.below(2) != 0;
            for (std::uint32_t i = 0; i <= count; ++i) {
                // Lines, blots and single cells, some of which are so already, some twice.
                const Cell c{static_cast<std::uint16_t>((left + (round % 3 == 0 ? i : 0)) % 70),
                             static_cast<std::uint16_t>((top + i % 9) % 60)};
                changes.push_back({c, passable});
                map.set_passable(c, passable);
            }
            components.update(map, changes);
            Components anew;
            anew.label(map);
            ASSERT_EQ(differs(map, components, anew), "") << seed << " round " << round;
        }
    }
}

TEST(Components, AreThoseOfMapsOfManySquares) {
    core::Rng rng(22);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        GridMap map =
            seed % 2 == 0 ? rooms_map(200, 150, 8, seed) : random_map(200, 150, 0.38F, seed);
        Components components;
        components.label(map);
        for (int round = 0; round < 80; ++round) {
            std::vector<CellChange> changes;
            const bool passable = rng.below(2) != 0;
            // On the borders of squares, too, which are 64 places apart.
            const std::uint32_t left = rng.below(3) == 0 ? 62 + 64 * rng.below(2) : rng.below(197);
            const std::uint32_t top = rng.below(3) == 0 ? 61 + 64 * rng.below(2) : rng.below(147);
            for (std::uint32_t i = 0; i < 9; ++i) {
                const Cell c{static_cast<std::uint16_t>(left + i % 3),
                             static_cast<std::uint16_t>(top + i / 3)};
                changes.push_back({c, passable});
                map.set_passable(c, passable);
            }
            components.update(map, changes);
            const std::vector<double> reached = all_lengths(map, {100, 75});
            Components anew;
            anew.label(map);
            ASSERT_EQ(differs(map, components, anew), "") << seed << " round " << round;
            for (std::size_t i = 0; i < reached.size() && map.passable(Cell{100, 75}); i += 7) {
                const Cell c{static_cast<std::uint16_t>(i % 200),
                             static_cast<std::uint16_t>(i / 200)};
                ASSERT_EQ(components.of(map.place(c)) == components.of(map.place({100, 75})),
                          reached[i] != kNoPath);
            }
        }
    }
}

TEST(Components, SayWhatAChangeHasJoined) {
    core::Rng rng(23);
    std::size_t joined = 0;
    std::size_t apart = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        GridMap map = rooms_map(140, 90, 7, seed);
        Components components;
        components.label(map);
        for (int round = 0; round < 60; ++round) {
            const Components before = components;
            const GridMap old = map;
            std::vector<CellChange> changes;
            const std::uint32_t left = rng.below(137);
            const std::uint32_t top = rng.below(87);
            for (std::uint32_t i = 0; i < 9; ++i) {
                const Cell c{static_cast<std::uint16_t>(left + i % 3),
                             static_cast<std::uint16_t>(top + i / 3)};
                changes.push_back({c, rng.below(3) != 0 && round % 2 == 0});
            }
            for (const CellChange& c : changes) {
                map.set_passable(c.cell, c.passable);
            }
            components.update(map, changes);
            // By brute force: a component now that held cells of two before.
            std::map<std::uint32_t, std::uint32_t> held;
            std::map<std::uint32_t, bool> several;
            for (Place p = 0; p < map.places(); ++p) {
                if (map.passable(p) && old.passable(p)) {
                    const auto [at, first] = held.try_emplace(components.of(p), before.of(p));
                    several[components.of(p)] |= !first && at->second != before.of(p);
                }
            }
            for (Place p = 0; p < map.places(); p += 5) {
                if (map.passable(p)) {
                    ASSERT_EQ(components.joined_anew(p), several[components.of(p)]);
                    ++(several[components.of(p)] ? joined : apart);
                }
            }
        }
    }
    EXPECT_GT(joined, 1000U);
    EXPECT_GT(apart, 1000U);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
