// Passes over changed rows alone miss nothing that a pass over all rows finds.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/border/ghosts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

/// The parts of a row that the hash covers.
struct Columns {
    std::uint8_t flags = 0;
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    Vec3 spin = Vec3::Zero();
    Eigen::Vector4f turn = Eigen::Vector4f::Zero();
    std::uint16_t yaw = 0;
    std::uint16_t appearance = 0;

    friend bool operator==(const Columns&, const Columns&) = default;
};

/// The town in four zones, a few hundred people at the beginning of a short night, and a player who
/// comes and goes.
class Town {
  public:
    Town() {
        std::vector<std::string> sets = {"ai.dawn_s=30"};
        const int counts[] = {60, 60, 20, 60, 20, 10, 4, 10, 40};
        for (int k = 0; k < 9; ++k) {
            sets.push_back("scatter[" + std::to_string(k) + "].count=" + std::to_string(counts[k]));
        }
        std::vector<config::ConfigError> errors;
        loaded =
            config::load_settings(ZONED_SOURCE_DIR "/config/town.txtpb", sets, settings, errors);
        world = std::make_unique<World>(settings, 1);
    }

    void tick() {
        std::vector<mailbox::InboxItem> in;
        if (world->now() == 200) {
            mailbox::Join join;
            join.client = ClientId(1);
            join.name = "a";
            in.emplace_back(join);
        }
        if (world->now() == 700) {
            in.emplace_back(mailbox::Leave{ClientId(1)});
        }
        std::vector<mailbox::OutboxItem> out;
        world->tick(in, out);
    }

    config::Settings settings;
    bool loaded = false;
    std::unique_ptr<World> world;
};

Columns columns_of(const world::Entities& e, world::Row row) {
    return {e.flags[row],
            e.position[row],
            e.velocity[row],
            e.angular_velocity[row],
            e.orientation[row].coeffs(),
            e.yaw[row],
            e.appearance[row]};
}

using Known = std::map<EntityId, Columns>;

/// Entities whose columns are not as they were and that the tick's hash left out.
std::vector<EntityId> left_out(const zone::ZoneState& state, Known& known) {
    const world::Entities& e = state.entities;
    std::vector<EntityId> found;
    Known now;
    for (world::Row row = 0; row < e.size(); ++row) {
        const Columns columns = columns_of(e, row);
        const auto before = known.find(e.id[row]);
        const bool changed = before == known.end() || !(before->second == columns);
        if (changed &&
            !std::binary_search(state.changed_rows.begin(), state.changed_rows.end(), row)) {
            found.push_back(e.id[row]);
        }
        now.emplace(e.id[row], columns);
    }
    known.swap(now);
    return found;
}

/// The rows that neighbours have to hear of, by a pass over all rows.
std::map<EntityId, Vec3> near_border(const zone::ZoneState& state) {
    std::map<EntityId, Vec3> near;
    const world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        const Vec3d at = state.settings.region().origin() + e.position[row].cast<double>();
        const bool reaches = std::any_of(
            state.settings.regions.begin(), state.settings.regions.end(), [&](const auto& r) {
                return r.id != state.settings.id &&
                       r.outside(at.x(), at.z()) <= state.settings.ghost_margin_m;
            });
        if (reaches && !e.has(row, world::kGhost) && !e.has(row, world::kHidden)) {
            near.emplace(e.id[row], e.position[row]);
        }
    }
    return near;
}

TEST(KeptRows, NothingThatChangesIsLeftOutOfTheHashOrTheExport) {
    Town town;
    ASSERT_TRUE(town.loaded);
    std::vector<Known> known(4);
    std::size_t hashed = 0;
    std::size_t rows = 0;
    std::size_t told = 0;
    for (int tick = 0; tick < 1'500; ++tick) {
        town.tick();
        for (std::size_t z = 0; z < 4; ++z) {
            const zone::ZoneState& state = town.world->zones()[z]->state();
            ASSERT_EQ(left_out(state, known[z]), std::vector<EntityId>{})
                << "zone " << z << ", tick " << town.world->now();
            std::map<EntityId, Vec3> exported;
            for (const zone::EntityState& ghost : state.ghosts_out) {
                exported.emplace(ghost.id, ghost.position);
            }
            ASSERT_EQ(exported, near_border(state))
                << "zone " << z << ", tick " << town.world->now();
            hashed += state.changed_rows.size();
            rows += state.entities.size();
            told += exported.size();
        }
    }
    EXPECT_LT(hashed, rows / 2) << "most doze most of the time";
    EXPECT_GT(told, 1'500U);
}

TEST(KeptRows, TheCheckFindsAChangeThatNobodyTold) {
    Town town;
    ASSERT_TRUE(town.loaded);
    std::vector<Known> known(4);
    for (int tick = 0; tick < 150; ++tick) {
        town.tick();
        for (std::size_t z = 0; z < 4; ++z) {
            left_out(town.world->zones()[z]->state(), known[z]);
        }
    }
    zone::ZoneState& state = town.world->zones()[0]->state();
    world::Entities& e = state.entities;
    world::Row dozes = 0;
    while (!e.has(dozes, world::kDozing)) {
        ++dozes;
    }
    const EntityId victim = e.id[dozes];
    e.yaw[dozes] ^= 1U;
    e.position[dozes].y() += 0.25F;
    town.tick();
    const std::vector<EntityId> found = left_out(state, known[0]);
    EXPECT_TRUE(std::find(found.begin(), found.end(), victim) != found.end());
}

}  // namespace
}  // namespace zoned::app
