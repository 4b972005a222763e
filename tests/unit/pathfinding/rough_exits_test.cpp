// Exits of zones that are first chosen by what is known, and then by what was found.
#include "server/ai/pathfinding/path_service.h"
#include "server/ai/pathfinding/requests/zone_portals.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace zoned::ai {

namespace {

using pathfinding::GroundRect;
using pathfinding::Spot;
using pathfinding::ZoneGround;
using pathfinding::ZonePortals;

constexpr float kHalf_m = 40.0F;
constexpr double kApart_m = 80.0;
constexpr std::size_t kAgents = 12;

/// Three zones in a row. In the one in the middle stands a long wall, with a way round either end:
/// the straight line says nothing about which is shorter, and where to leave the first zone for it.
motion::StaticGeometry middle_of(std::size_t zone) {
    std::vector<motion::StaticBox> boxes;
    if (zone == 1) {
        motion::StaticBox wall;
        wall.centre = Vec3(10.0F, 1.0F, 6.0F);
        wall.half_extents = Vec3(0.5F, 2.0F, 30.0F);
        boxes.push_back(wall);
        wall.centre = Vec3(-12.0F, 1.0F, -36.0F);
        wall.half_extents = Vec3(22.0F, 2.0F, 0.5F);
        boxes.push_back(wall);
    }
    return {boxes, 0.0F};
}

world::TypeTable walkers() {
    world::TypeTable types(1);
    types[0].kind = world::EntityKind::kCharacter;
    types[0].brain = 1;
    return types;
}

struct Row {
    Row() {
        PathfindingSettings settings;
        settings.cell_m = 0.5F;
        for (std::size_t z = 0; z < zones.size(); ++z) {
            zones[z] = service(z);
        }
        std::vector<ZoneGround> grounds;
        for (std::size_t z = 0; z < zones.size(); ++z) {
            grounds.push_back({zones[z].ground_map(0),
                               kApart_m * static_cast<double>(z),
                               0.0,
                               GroundRect{-kHalf_m, -kHalf_m, kHalf_m, kHalf_m}});
        }
        portals = std::make_shared<const ZonePortals>(grounds);
        for (std::uint32_t z = 0; z < zones.size(); ++z) {
            zones[z].know_zones(0, portals, z);
        }
    }

    static PathService service(std::size_t zone) {
        PathfindingSettings settings;
        settings.cell_m = 0.5F;
        const float side = kHalf_m + 1.0F;
        return {settings, middle_of(zone), {-side, -side, side, side}, walkers(), 0};
    }

    std::array<PathService, 3> zones;
    std::shared_ptr<const ZonePortals> portals;
};

/// A zone whose agents ask for places beyond the next one.
struct Asking {
    explicit Asking(const Row& row) : paths(Row::service(0)) {
        paths.know_zones(0, row.portals, 0);
    }

    void ask_all() {
        core::Rng rng(7);
        for (Slot slot = 0; slot < kAgents; ++slot) {
            const Spot from{rng.range(-38.0F, 30.0F), rng.range(-38.0F, 38.0F)};
            const Spot to{rng.range(125.0F, 195.0F), rng.range(-38.0F, 38.0F)};
            paths.ask(slot, EntityId(100 - slot), 0, from, to);
        }
    }

    void tick(Tick now) {
        paths.follow_doors(now);
        paths.serve();
    }

    [[nodiscard]] std::vector<float> answers() const {
        std::vector<float> all;
        for (Slot slot = 0; slot < kAgents; ++slot) {
            const pathfinding::PathResult a = paths.answer(slot);
            all.push_back(a.waiting ? -1.0F : a.length_m);
            for (const Spot& s : a.corners) {
                all.push_back(s.x);
                all.push_back(s.z);
            }
        }
        return all;
    }

    [[nodiscard]] std::size_t rough() const {
        const SavedPathService saved = paths.save();
        return static_cast<std::size_t>(std::count_if(
            saved.asked.begin(), saved.asked.end(), [](const auto& asked) { return asked.rough; }));
    }

    PathService paths;
};

TEST(RoughExits, BecomeThoseThatAllCostsGive) {
    const Row row;
    Asking first(row);
    first.ask_all();
    EXPECT_GT(first.rough(), 0U) << "nothing is known before the first request";
    first.tick(1);
    const std::vector<float> before = first.answers();
    EXPECT_EQ(std::count(before.begin(), before.end(), -1.0F), 0) << "nobody waits for that";
    Tick now = 1;
    while (first.rough() > 0 && now < 2000) {
        first.tick(++now);
    }
    ASSERT_EQ(first.rough(), 0U);
    EXPECT_GT(now, 2) << "within a share of work in each tick";
    EXPECT_NE(first.answers(), before) << "some exits were not the best";
    // Whoever asks now gets the same at once.
    const std::vector<float> settled = first.answers();
    first.ask_all();
    EXPECT_EQ(first.rough(), 0U);
    first.tick(++now);
    EXPECT_EQ(first.answers(), settled);
}

TEST(RoughExits, AreRefinedInTheSameTickInACopyMadeInAny) {
    const Row row;
    Asking straight(row);
    straight.ask_all();
    auto copied = std::make_unique<Asking>(row);
    copied->ask_all();
    Tick now = 0;
    std::size_t rough = 0;
    for (; now < 2000 && (straight.rough() > 0 || now < 5); ++now) {
        straight.tick(now);
        copied->tick(now);
        ASSERT_EQ(copied->answers(), straight.answers()) << "tick " << now;
        ASSERT_EQ(copied->rough(), straight.rough()) << "tick " << now;
        rough += straight.rough();
        auto fresh = std::make_unique<Asking>(row);
        const SavedPathService saved = copied->paths.save();
        EXPECT_TRUE(saved.sizes[0].whole);
        // Agents may have other slots there.
        const auto slot_of = [](EntityId entity) -> std::optional<Slot> {
            return static_cast<Slot>(100 - entity.value);
        };
        ASSERT_EQ(fresh->paths.load(saved, slot_of), "");
        copied = std::move(fresh);
    }
    EXPECT_GT(rough, kAgents) << "copies were made while exits were rough";
    EXPECT_EQ(straight.rough(), 0U);
}

}  // namespace

}  // namespace zoned::ai
