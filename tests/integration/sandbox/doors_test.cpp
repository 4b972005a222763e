// The world `doors`: whether a door is shut follows from the tick alone, so nobody is put right.
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"
#include "shared/motion/capsule_sweep.h"

#include <set>
#include <utility>

namespace zoned::harness {
namespace {

class DoorsWorld : public GameTest {
  protected:
    DoorsWorld() {
        server.config = ZONED_SOURCE_DIR "/config/doors.txtpb";
        bots.bots = 16;
        bots.seconds = 20.0;
    }

    /// Who walks from one side of the walls to another, and how deep anybody stands in what is
    /// solid; called after each tick.
    void look(app::World& of) {
        for (const auto& zone : of.zones()) {
            const zone::ZoneState& state = zone->state();
            const Vec3d origin = state.settings.region().origin();
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                const world::EntityType& type = (*state.settings.types)[e.type[row]];
                if (type.kind != world::EntityKind::kCharacter || e.has(row, world::kGhost)) {
                    continue;
                }
                const Vec3d p = origin + e.position[row].cast<double>();
                const int quarter = (p.x() > 0.0 ? 1 : 0) + (p.z() > 0.0 ? 2 : 0);
                const auto [it, first] = quarter_.try_emplace(e.id[row], quarter);
                crossings_ += it->second != quarter ? 1 : 0;
                it->second = quarter;
                const motion::CapsuleSweep bare(*state.settings.statics,
                                                {type.radius, type.half_segment},
                                                {e.position[row], e.position[row]});
                deepest_ =
                    std::max(deepest_, (bare.parted(e.position[row]) - e.position[row]).norm());
                pushed_ += motion::moved_by_door(
                               e.position[row], type.character, *state.settings.statics, state.now)
                               ? 1
                               : 0;
            }
        }
    }

    std::map<EntityId, int> quarter_;
    int crossings_ = 0;
    int pushed_ = 0;  ///< ticks in which somebody was in reach of a door that turned or pushed
    float deepest_ = 0.0F;  ///< in a wall, m
};

TEST_F(DoorsWorld, IsConsistentUnderLossAndPredictionsOfTheOwnAvatarAreRight) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    const measure::Report report = run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 500u);
    EXPECT_GT(world->world().client_handoffs(), 0u);
    // They went through the doors, and met them shut.
    EXPECT_GT(crossings_, 20);
    EXPECT_GT(pushed_, 20);
    EXPECT_LT(deepest_, 0.005F);
    RecordProperty("crossings", crossings_);
    RecordProperty("in_reach_of_turning_doors", pushed_);
    RecordProperty("corrections", static_cast<int>(report.own_correction_m.count()));
    // Those whose inputs came in time: what is lost for longer than the lead is put right.
    EXPECT_LT(report.own_correction_m.percentile(0.99), 0.001);
}

TEST_F(DoorsWorld, NeedsNoCorrectionAtAllWhereNoInputIsLost) {
    server.network.delay_s = 0.04;
    const measure::Report report = run([this](VirtualServer& now, double) { look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.own_correction_m.count(), 1000u);
    EXPECT_EQ(report.own_correction_m.percentile(1.0), 0.0);
    EXPECT_GT(pushed_, 20);
}

TEST_F(DoorsWorld, IsPutRightAllTheTimeByAServerWhoseDoorsAreOthers) {
    // The checker is checked: the same run with a server that shuts a tick late.
    server.network.delay_s = 0.04;
    bool spoilt = false;
    const measure::Report report = run([&](VirtualServer& now, double) {
        look(now.world());
        if (!std::exchange(spoilt, true)) {
            for (const auto& zone : now.world().zones()) {
                zone::ZoneState& state = zone->state();
                std::vector<motion::Door> late(state.settings.statics->doors().begin(),
                                               state.settings.statics->doors().end());
                for (motion::Door& door : late) {
                    door.times.shift =
                        (door.times.shift + door.times.period / 2) % door.times.period;
                }
                const motion::StaticGeometry& is = *state.settings.statics;
                state.settings.statics = std::make_shared<const motion::StaticGeometry>(
                    std::vector<motion::StaticBox>(is.boxes().begin(), is.boxes().end()),
                    is.ground_height(),
                    motion::kStaticCell_m,
                    std::vector<motion::StaticSurface>(),
                    late);
            }
        }
    });
    EXPECT_GT(report.own_correction_m.percentile(1.0), 0.05);
}

}  // namespace
}  // namespace zoned::harness
