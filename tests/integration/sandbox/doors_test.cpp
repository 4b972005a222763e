// The world `doors`: a door's state follows from the tick alone, so no avatar is corrected.
#include "client-sim/view/world_info.h"
#include "server/app/world/world.h"
#include "server/config/world/world_description.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"
#include "tests/harness/received.h"
#include "shared/motion/capsule_sweep.h"

#include <algorithm>
#include <map>
#include <memory>
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

    /// The characters' motion, tick by tick; called after each.
    void look(app::World& of) {
        for (const auto& zone : of.zones()) {
            const zone::ZoneState& state = zone->state();
            if (state.frozen) {
                continue;  // the run is over
            }
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                const world::EntityType& type = (*state.settings.types)[e.type[row]];
                if (type.kind != world::EntityKind::kCharacter || e.has(row, world::kGhost) ||
                    e.has(row, world::kHidden)) {
                    continue;
                }
                if (e.client[row]) {
                    follow(state, row);
                }
                const motion::CapsuleSweep bare(*state.settings.statics,
                                                {type.radius, type.half_segment},
                                                {e.position[row], e.position[row]});
                deepest_ =
                    std::max(deepest_, (bare.parted(e.position[row]) - e.position[row]).norm());
                near_turning_ +=
                    motion::moved_by_door(
                        e.position[row], type.character, *state.settings.statics, state.now)
                        ? 1
                        : 0;
            }
        }
    }

    /// Takes an avatar's place a tick ago and steps it as a client does that knows doors from the
    /// login. The result is the same, to the last bit.
    void follow(const zone::ZoneState& state, world::Row row) {
        const world::Entities& e = state.entities;
        Seen& seen = seen_[e.id[row]];
        const Vec3d at = state.settings.region().origin() + e.position[row].cast<double>();
        const int quarter = (at.x() > 0.0 ? 1 : 0) + (at.z() > 0.0 ? 2 : 0);
        crossings_ += seen.tick >= 0 && seen.quarter != quarter ? 1 : 0;
        const motion::CharacterState now{
            e.position[row], e.velocity[row], e.yaw[row], e.has(row, world::kGrounded)};
        if (seen.tick == state.now - 1 && seen.zone == state.settings.id &&
            e.discontinuity_tick[row] != state.now) {
            const world::EntityType& type = (*state.settings.types)[e.type[row]];
            const motion::CharacterState told =
                motion::apply_input(seen.state,
                                    e.command[row],
                                    type.character,
                                    told_->zone(state.settings.id)->geometry,
                                    state.settings.dt,
                                    state.now);
            ++compared_;
            differing_ += told.position != now.position || told.velocity != now.velocity ||
                                  told.grounded != now.grounded
                              ? 1
                              : 0;
        }
        seen = {state.now, state.settings.id, quarter, now};
    }

    void learning(VirtualServer& from) {
        if (told_ == nullptr) {
            auto read = view::read_world(test::received<wire::WorldDescriptionMessage>(
                config::describe_world(from.settings())));
            ASSERT_TRUE(read.ok()) << read.error();
            told_ = std::make_unique<view::WorldInfo>(std::move(*read));
        }
    }

    struct Seen {
        Tick tick = -1;
        ZoneId zone;
        int quarter = 0;
        motion::CharacterState state;
    };

    std::unique_ptr<view::WorldInfo> told_;
    std::map<EntityId, Seen> seen_;
    int crossings_ = 0;  ///< of the walls' lines, through doors
    int near_turning_ =
        0;  ///< ticks in which a character was in reach of a door that turned or pushed
    int compared_ = 0;
    int differing_ = 0;
    float deepest_ = 0.0F;  ///< in a wall, m
};

TEST_F(DoorsWorld, IsConsistentUnderLossAndMovesAsClientsPredict) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    const measure::RunReport report = run([this](VirtualServer& now, double) {
        learning(now);
        look(now.world());
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 500u);
    EXPECT_GT(world->world().client_handoffs(), 0u);
    // They went through the doors, and met them while they turned.
    EXPECT_GT(crossings_, 4);
    EXPECT_GT(near_turning_, 50);
    EXPECT_LT(deepest_, 0.005F);
    EXPECT_GT(compared_, 5000);
    EXPECT_EQ(differing_, 0);
    // Corrections come only from inputs that came too late, with doors or without.
    EXPECT_EQ(report.own_correction_m.percentile(0.98), 0.0);
}

TEST_F(DoorsWorld, NeedsNoCorrectionsWhereInputsComeInTime) {
    server.network.delay_s = 0.04;
    const measure::RunReport report = run([this](VirtualServer& now, double) {
        learning(now);
        look(now.world());
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.own_correction_m.count(), 1000u);
    EXPECT_EQ(report.own_correction_m.percentile(0.99), 0.0);
    EXPECT_EQ(differing_, 0);
    EXPECT_GT(near_turning_, 50);
}

TEST_F(DoorsWorld, IsPutRightAllTheTimeByAServerWhoseDoorsAreOthers) {
    // The checkers are checked: the same run with a server whose doors turn at other times.
    server.network.delay_s = 0.04;
    bool spoilt = false;
    const measure::RunReport report = run([&](VirtualServer& now, double) {
        learning(now);
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
    EXPECT_GT(report.own_correction_m.percentile(0.99), 0.0);
    EXPECT_GT(differing_, 10);
}

}  // namespace
}  // namespace zoned::harness
