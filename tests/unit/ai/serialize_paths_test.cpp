// build: computes
// Paths saved and loaded beside agents: all goes on bit for bit; invalid bytes are refused.
#include "server/ai/serialization/serialize_paths.h"

#include "server/ai/serialization/serialize_agents.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::uint32_t kWalkers = 120;

/// Strolls about and home again, across walls.
Brain goes_about() {
    Brain m;
    m.name = "goes_about";
    m.states.resize(2);
    m.states[0].name = "out";
    m.states[0].action = ActionKind::kWander;
    m.states[0].radius_m = 30.0F;
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 8.0F, 0.0F}};
    m.states[1].name = "home";
    m.states[1].action = ActionKind::kReturn;
    m.states[1].transitions = {{0, Sensor::kHomeDistance, Compare::kBelow, 1.5F, 0.5F}};
    return m;
}

/// Four walls along z, each with two gates: one stays open, one turns every 10 s from the given
/// tick on.
motion::StaticGeometry walls(Tick first_turn) {
    std::vector<motion::StaticBox> boxes;
    std::vector<motion::Door> gates;
    const auto box = [](float x, float from_z, float to_z) {
        motion::StaticBox b;
        b.centre = Vec3(x, 1.0F, 0.5F * (from_z + to_z));
        b.half_extents = Vec3(0.2F, 2.0F, 0.5F * (to_z - from_z));
        return b;
    };
    for (const float x : {-18.0F, -6.0F, 6.0F, 18.0F}) {
        const float gap = x > 0.0F ? 20.0F : -20.0F;
        boxes.push_back(box(x, -30.0F, std::min(gap, 0.0F) - 1.5F));
        boxes.push_back(box(x, std::min(gap, 0.0F) + 1.5F, std::max(gap, 0.0F) - 1.5F));
        boxes.push_back(box(x, std::max(gap, 0.0F) + 1.5F, 30.0F));
        motion::Door gate;
        gate.box = box(x, -1.5F, 1.5F);
        gate.times.period = 100'000;
        for (Tick t = first_turn; t + 300 < 100'000; t += 600) {
            gate.times.open.push_back({t, t + 300});
        }
        gates.push_back(gate);
    }
    return {boxes, 0.0F, motion::kStaticCell_m, {}, gates};
}

PathfindingSettings settings_of(PathMapKind kind, std::uint64_t work) {
    PathfindingSettings settings;
    settings.cell_m = kind == PathMapKind::kWaypointGraph ? 2.0F : 0.5F;
    settings.map = kind;
    settings.work_per_tick = work;
    return settings;
}

struct WalledTown {
    WalledTown(const PathfindingSettings& paths, Tick first_turn, Tick now = 0) {
        field.statics = walls(first_turn);
        field.settings.brains = {goes_about()};
        field.settings.viewer_range_m = 25.0F;
        field.solid = true;
        field.now = now;
        for (world::EntityType& type : field.types) {
            type.brain = 1;
            type.character.acceleration = 20.0F;
        }
        field.paths = PathService(paths, field.statics, {-30, -30, 30, 30}, field.types, now);
        compile(field.settings, kDt);
    }

    void people() {
        for (std::uint32_t id = 1; id <= kWalkers; ++id) {
            const auto k = static_cast<float>(id);
            const Vec3 at(-24.0F + 12.0F * static_cast<float>(id % 5), 0.9F, 0.4F * k - 24.0F);
            field.add_npc(id, kGuard, 0, at);
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
        field.add_player(900, Vec3(20.0F, 0.9F, 5.0F));
    }

    [[nodiscard]] std::uint64_t hash() {
        core::StateHash hash;
        field.agents.hash(hash);
        for (std::uint32_t id = 1; id <= kWalkers; ++id) {
            hash.add(field.position(id).x());
            hash.add(field.position(id).z());
        }
        return hash.value();
    }

    Field field;
};

/// The other town, loaded from the bytes of the first; `paths`: whether the paths were loaded, too.
struct Copy {
    Copy(WalledTown& town, const PathfindingSettings& settings, Tick first_turn, bool with_paths) {
        std::vector<std::uint8_t> agents;
        std::vector<std::uint8_t> paths;
        Field& from = town.field;
        save_agents(from.agents, from.steps, from.points_of_interest, agents);
        serialize_paths(from.paths, paths);
        // Doors as they are between two ticks.
        other = std::make_unique<WalledTown>(settings, first_turn, from.now);
        Field& to = other->field;
        if (from.now > 0) {
            to.paths =
                PathService(settings, to.statics, {-30, -30, 30, 30}, to.types, from.now - 1);
        }
        to.entities = from.entities;
        EXPECT_EQ(load_agents(agents, to.settings, to.agents, to.steps, to.points_of_interest), "");
        if (with_paths) {
            EXPECT_EQ(deserialize_paths(paths, to.agents, to.paths, to.steps), "");
            std::vector<std::uint8_t> again;
            serialize_paths(to.paths, again);
            EXPECT_EQ(again, paths) << "what was read is what was written";
        }
    }

    std::unique_ptr<WalledTown> other;
};

struct Case {
    const char* name;
    PathMapKind kind;
    std::uint64_t work;  ///< of a tick
};

class SerializePaths : public testing::TestWithParam<Case> {};

/// First tick from which on the two differ, up to `ticks`.
Tick differ_after(WalledTown& one, WalledTown& other, Tick ticks) {
    for (Tick t = 0; t < ticks; ++t) {
        one.field.step();
        other.field.step();
        if (one.hash() != other.hash()) {
            return t;
        }
    }
    return ticks;
}

TEST_P(SerializePaths, GoOnBitForBitInWhateverTickTheyAreRead) {
    const PathfindingSettings settings = settings_of(GetParam().kind, GetParam().work);
    // Doors turn after everything was loaded.
    const Tick turn = 700;
    WalledTown town(settings, turn);
    town.people();
    std::uint32_t waited = 0;
    for (int trial = 0; trial < 12; ++trial) {
        town.field.run(1.5F + 0.033F * static_cast<float>(trial % 7));
        waited += town.field.paths.counts().waiting;
        const Copy copy(town, settings, turn, true);
        EXPECT_EQ(differ_after(town, *copy.other, 7), 7) << "trial " << trial;
    }
    ASSERT_LT(town.field.now, turn);
    const Copy last(town, settings, turn, true);
    EXPECT_EQ(differ_after(town, *last.other, 1200), 1200);
    EXPECT_GT(town.field.paths.counts().broken, 20U) << "doors have cut paths";
    if (GetParam().work < 100'000) {
        EXPECT_GT(waited, 0U) << "some wait while they are written";
    }
}

TEST_P(SerializePaths, GoOnBitForBitAfterDoorsHaveTurned) {
    const PathfindingSettings settings = settings_of(GetParam().kind, GetParam().work);
    WalledTown town(settings, 100);
    town.people();
    town.field.run(9.0F);  // tick 270, between two turns
    const Copy copy(town, settings, 100, true);
    EXPECT_EQ(differ_after(town, *copy.other, 900), 900);
}

INSTANTIATE_TEST_SUITE_P(Maps,
                         SerializePaths,
                         testing::Values(Case{"Grid", PathMapKind::kGrid, 1'000'000},
                                         Case{"GridInNeed", PathMapKind::kGrid, 3'000},
                                         Case{"Mesh", PathMapKind::kNavmesh, 1'000'000},
                                         Case{"MeshInNeed", PathMapKind::kNavmesh, 1'000},
                                         Case{"Graph", PathMapKind::kWaypointGraph, 1'000'000},
                                         Case{"GraphInNeed", PathMapKind::kWaypointGraph, 3'000}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST(SerializePathsOf, AreMissedWhereTheyAreNotRead) {
    const PathfindingSettings settings = settings_of(PathMapKind::kGrid, 3'000);
    WalledTown town(settings, 100);
    town.people();
    town.field.run(9.0F);
    const Copy copy(town, settings, 100, false);
    EXPECT_LT(differ_after(town, *copy.other, 900), 900) << "the comparison finds it";
}

class BadPaths : public testing::TestWithParam<PathMapKind> {
  protected:
    BadPaths() : settings(settings_of(GetParam(), 3'000)), town(settings, 100) {
        town.people();
        town.field.run(9.0F);
        serialize_paths(town.field.paths, bytes);
    }

    /// Loads into paths of the same ground.
    std::string read(PathService& paths) {
        AiUpdate step;
        return deserialize_paths(bytes, town.field.agents, paths, step);
    }

    [[nodiscard]] PathService fresh() const {
        return {
            settings, town.field.statics, {-30, -30, 30, 30}, town.field.types, town.field.now - 1};
    }

    PathfindingSettings settings;
    WalledTown town;
    std::vector<std::uint8_t> bytes;
};

TEST_P(BadPaths, AreRefusedWhereverTheyEnd) {
    const std::vector<std::uint8_t> whole = bytes;
    PathService paths = fresh();  // a truncated input leaves nothing behind
    for (std::size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 97) {
        bytes.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_NE(read(paths), "") << size << " of " << whole.size();
    }
    bytes = whole;
    bytes.push_back(0);
    EXPECT_EQ(read(paths), "1 bytes are left over");
    bytes[0] = 9;
    EXPECT_EQ(read(paths), "version 9 of paths, not 5");
}

TEST_P(BadPaths, NeverBreakAnythingWhateverBytesSay) {
    core::Rng rng(5);
    const std::vector<std::uint8_t> whole = bytes;
    int taken = 0;
    for (int trial = 0; trial < 40; ++trial) {
        PathService paths = fresh();
        bytes = whole;
        for (int k = 0; k < 3; ++k) {
            bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] =
                static_cast<std::uint8_t>(rng.below(256));
        }
        if (!read(paths).empty()) {
            continue;
        }
        ++taken;
        // Goes on from the loaded state.
        Copy copy(town, settings, 100, false);
        copy.other->field.paths = std::move(paths);
        for (int tick = 0; tick < 60; ++tick) {
            copy.other->field.step();
        }
    }
    EXPECT_GT(taken, 0) << "many numbers may be any number";
}

INSTANTIATE_TEST_SUITE_P(Maps,
                         BadPaths,
                         testing::Values(PathMapKind::kGrid,
                                         PathMapKind::kNavmesh,
                                         PathMapKind::kWaypointGraph));

}  // namespace
}  // namespace zoned::ai
