// Triggers: the rules hear of all that comes into a box and leaves it, in whichever way it does.
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using test::Crowd;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kTriggerWorld = R"(
world { name: "triggers" seed: 5 tick_rate_hz: 20 min_x_m: -200 min_z_m: -50 max_x_m: 200 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "ball" sphere { radius_m: 0.2 } mass_kg: 2 aura_m { normal: 50 } }
type { name: "crate" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 9 aura_m { normal: 50 } }
entity { type: "ball" name: "a" x_m: -20 z_m: 0 asleep: true }
entity { type: "ball" name: "b" x_m: -30 z_m: 0 asleep: true }
entity { type: "crate" name: "c" x_m: -20 z_m: 3 asleep: true }
trigger { name: "goal" x_m: -30 y_m: 1 z_m: 0 size { x_m: 4 y_m: 2 z_m: 2 } yaw_deg: 45 }
trigger { name: "gate" x_m: 0 y_m: 1 z_m: 0 size { x_m: 20 y_m: 8 z_m: 20 } type: "ball" }
spawn { x_m: 0 z_m: 40 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

class Triggers : public ::testing::Test {
  protected:
    Triggers() {
        plain_log() = std::make_shared<scenario::PlainLog>();
        world = std::make_unique<Crowd>(kTriggerWorld);
        world->tick();
    }

    ~Triggers() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            world->tick();
        }
    }

    [[nodiscard]] zone::ZoneContext context(std::size_t zone = 0) {
        return zone::ZoneContext(world->world().zones()[zone]->state());
    }

    EntityId named(const char* name) { return context().entity_named(name); }

    /// With names in place of ids; forgets them.
    std::vector<std::string> heard() {
        std::vector<std::string> lines = std::exchange(plain_log()->triggers, {});
        for (std::string& line : lines) {
            for (const char* name : {"a", "b", "c"}) {
                const std::string id = " " + std::to_string(named(name).value);
                if (line.ends_with(id)) {
                    line = line.substr(0, line.size() - id.size() + 1) + name;
                }
            }
        }
        return lines;
    }

    std::vector<EntityId> inside(const char* trigger, std::size_t zone = 0) {
        std::vector<EntityId> there;
        context(zone).inside(trigger, there);
        return there;
    }

    std::unique_ptr<Crowd> world;
};

TEST_F(Triggers, TellOfThoseThatSleepThereFromTheBeginning) {
    EXPECT_THAT(heard(), ElementsAre("1 +goal b"));
    EXPECT_THAT(inside("goal"), ElementsAre(named("b")));
    EXPECT_THAT(inside("nothing"), IsEmpty());
    ticks(20);
    EXPECT_THAT(heard(), IsEmpty());
}

TEST_F(Triggers, TellOfWhatIsPutThereTakenAwayHiddenAndGone) {
    heard();
    context().teleport(named("a"),
                       context().entities().position[context().entities().find(named("b"))]);
    context().teleport(named("b"), Vec3::Zero());
    ticks(1);
    EXPECT_THAT(heard(), ElementsAre("1 -goal b", "1 +goal a"));
    context().hide(named("a"));
    ticks(1);
    EXPECT_THAT(heard(), ElementsAre("1 -goal a"));
    EXPECT_THAT(inside("goal"), IsEmpty());
    context().show(named("a"), Vec3(70.0F, 0.2F, 0.0F), Vec3::Zero());
    ticks(1);
    EXPECT_THAT(heard(), ElementsAre("1 +goal a"));
    context().despawn(named("a"));
    ticks(1);
    EXPECT_THAT(heard(), ElementsAre("1 -goal a"));
}

TEST_F(Triggers, TellOfWhatRollsThroughAndAcrossABorderByTypesThatTheyNotice) {
    heard();
    context().add_velocity(named("a"), Vec3(12.0F, 0.0F, 0.0F));
    context().add_velocity(named("c"), Vec3(16.0F, 4.0F, 0.0F));
    std::vector<std::string> all;
    for (int i = 0; i < 120; ++i) {
        ticks(1);
        for (std::string& line : heard()) {
            all.push_back(std::move(line));
        }
    }
    // From the one zone to the other within the box.
    ASSERT_GE(all.size(), 3u);
    EXPECT_EQ(all[0], "1 +gate a");
    EXPECT_EQ(std::set<std::string>(all.begin() + 1, all.begin() + 3),
              (std::set<std::string>{"1 -gate a", "2 +gate a"}));
}

TEST(TriggerBoxes, AgreeWithEveryPositionOfAThousandTicks) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    std::string text = kTriggerWorld;
    core::Rng rng(3);
    for (int i = 0; i < 20; ++i) {
        text += "trigger { name: \"t" + std::to_string(i) +
                "\" x_m: " + std::to_string(rng.range(-60.0F, 60.0F)) +
                " z_m: " + std::to_string(rng.range(-40.0F, 40.0F)) +
                " yaw_deg: " + std::to_string(rng.range(0.0F, 90.0F)) +
                " size { x_m: 9 y_m: 3 z_m: 15 } }\n";
    }
    text +=
        "scatter { type: \"ball\" count: 40 seed: 2 region { min_x_m: -60 max_x_m: 60 min_z_m: -40 "
        "max_z_m: 40 } }\n";
    Crowd world(text);
    std::size_t compared = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        for (std::size_t z = 0; z < 2; ++z) {
            zone::ZoneContext context(world.world().zones()[z]->state());
            const world::Entities& e = context.entities();
            for (world::Row row = 0; row < e.size(); ++row) {
                if (!e.has(row, world::kGhost) && rng.below(200) == 0) {
                    context.add_velocity(
                        e.id[row],
                        Vec3(
                            rng.range(-8.0F, 8.0F), rng.range(0.0F, 6.0F), rng.range(-8.0F, 8.0F)));
                }
            }
        }
        // Before handoffs, as the rules hear of it: zones look at what they own after physics.
        world.tick();
        for (std::size_t z = 0; z < 2; ++z) {
            const zone::ZoneState& state = world.world().zones()[z]->state();
            const world::Entities& e = state.entities;
            for (std::size_t t = 0; t < state.settings.triggers.size(); ++t) {
                const std::set<EntityId> told(state.triggers.inside[t].begin(),
                                              state.triggers.inside[t].end());
                for (world::Row row = 0; row < e.size(); ++row) {
                    const bool owned = !e.has(row, world::kGhost);
                    const bool came =
                        state.accepted || e.touched(world::Reader::kTriggers).has(row);
                    const bool there = state.settings.triggers[t].notices[e.type[row]] &&
                                       state.settings.triggers[t].holds(e.position[row]);
                    if (owned && !came) {
                        ASSERT_EQ(told.contains(e.id[row]), there) << "tick " << tick;
                        ++compared;
                    }
                }
            }
        }
    }
    EXPECT_GT(compared, 100'000u);
    plain_log() = std::make_shared<scenario::PlainLog>();
}

}  // namespace
}  // namespace zoned::app
