#include "server/ai/navigation/grid_map.h"
#include "tests/unit/navigation/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <map>

namespace zoned::ai::navigation {

namespace {

/// Empty where both say the same of which places reach which.
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

}  // namespace

}  // namespace zoned::ai::navigation
