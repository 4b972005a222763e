// Agents that form up around a captain, and herds that go along a path, in a zone.
#include "server/config/expand/load_settings.h"
#include "server/zone/assemblies/assembly_spawning.h"
#include "tests/integration/plain/crowd_world.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

namespace zoned::app {
namespace {

using test::Crowd;
using test::with;
using Placed = std::vector<std::pair<std::string, Vec2>>;

const char* const kDrill = R"(
world { name: "drill" seed: 3 tick_rate_hz: 30 min_x_m: -80 min_z_m: -80 max_x_m: 80 max_z_m: 80 }
zones { zone_grid { columns: 1 rows: 1 } }
ai { suspend_offscreen: false avoidance { } }
point_of_interest { name: "there" x_m: 60 z_m: 0 radius_m: 0.5 }
point_of_interest { name: "a" x_m: -40 z_m: -40 }
point_of_interest { name: "b" x_m: 40 z_m: -40 }
point_of_interest { name: "c" x_m: 0 z_m: 40 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { speed_mps: 3 } }
type { name: "captain" base: "player" brain: "lead" }
type { name: "soldier" base: "player" brain: "drill" }
type { name: "sheep" base: "player" brain: "graze" }
brain { name: "lead" state { name: "march" action: GO point_of_interest: "there" speed_factor: 0.4 } }
brain {
  name: "drill" perception_m: 60
  perception { players: false ward: "captain" }
  state { name: "form" action: FORM_UP formation { columns: 3 spacing_m: 1.6 } }
}
brain { name: "graze" state { name: "drift" action: FLOCK speed_factor: 0.5 radius_m: 12 along: "a" along: "b" along: "c" } }
spawn { x_m: 0 z_m: 70 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

/// A captain and nine soldiers, who stand about behind it.
Placed company() {
    Placed placed = {{"captain", {-20.0F, 0.0F}}};
    for (int i = 0; i < 9; ++i) {
        placed.push_back(
            {"soldier",
             {-26.0F - 1.3F * static_cast<float>(i % 4), 2.1F * static_cast<float>(i / 4) - 3.0F}});
    }
    return placed;
}

/// The distance of the soldiers from the slots of rows of three behind their captain, who walks
/// along x. It is the mean over the soldiers, each to the nearest slot, m. Every slot is occupied
/// where the returned number of slots is nine.
std::pair<float, std::size_t> disorder(Crowd& crowd) {
    float sum = 0.0F;
    std::set<int> held;
    for (world::Row row = 1; row <= 9; ++row) {
        float least = 1e9F;
        int nearest = 0;
        for (int slot = 0; slot < 9; ++slot) {
            const Vec2 place = crowd.at(0) + Vec2(-1.6F * static_cast<float>(slot / 3 + 1),
                                                  1.6F * (static_cast<float>(slot % 3) - 1.0F));
            const float distance = (crowd.at(row) - place).norm();
            nearest = distance < least ? slot : nearest;
            least = std::min(least, distance);
        }
        held.insert(nearest);
        sum += least;
    }
    return {sum / 9.0F, held.size()};
}

void run(Crowd& crowd, float seconds) {
    for (int t = 0; t < static_cast<int>(seconds * 30.0F); ++t) {
        crowd.tick();
    }
}

TEST(FormationFollowing, SoldiersMarchInRowsBehindTheirCaptain) {
    Crowd crowd(kDrill, company());
    run(crowd, 20.0F);
    EXPECT_GT(crowd.at(0).x(), 0.0F) << "it marches";
    const auto [off, held] = disorder(crowd);
    EXPECT_EQ(held, 9U) << "each has a slot of its own";
    // A command's pace may be off by 0.12 of 3 m/s; at a pull of 1.5 per second per metre, that
    // gives the distance.
    EXPECT_LT(off, 0.12F * 3.0F / 1.5F + 0.1F);
}

TEST(FormationFollowing, ThroughAGapAllComeAndFormUpAgain) {
    // A wall across with a gap of 2 m, narrower than three abreast.
    const std::string wall = R"(
statics {
  box { x_m: 0 y_m: 1 z_m: 21 size { x_m: 0.5 y_m: 2 z_m: 40 } }
  box { x_m: 0 y_m: 1 z_m: -21 size { x_m: 0.5 y_m: 2 z_m: 40 } }
})";
    Crowd crowd(kDrill + wall, company());
    float in_walls = -1.0F;
    for (int t = 0; t < 55 * 30; ++t) {
        crowd.tick();
        in_walls = std::max(in_walls, crowd.in_walls());
    }
    EXPECT_LE(in_walls, 1e-3F);
    for (world::Row row = 0; row <= 9; ++row) {
        EXPECT_GT(crowd.at(row).x(), 1.0F) << row << " is through";
    }
    EXPECT_EQ(disorder(crowd).second, 9U);
}

TEST(FormationFollowing, WhoIsLostComesBackAndWhoIsGoneIsMissedByNobody) {
    Crowd crowd(kDrill, company());
    run(crowd, 12.0F);
    zone::ZoneState& state = crowd.state();
    // Five metres aside per second of march: a straggler.
    state.entities.position[5] += Vec3(-6.0F, 0.0F, 12.0F);
    state.scene.set_state(state.entities.body[5], [&] {
        physics::BodyState moved = state.scene.state(state.entities.body[5]);
        moved.position = state.entities.position[5];
        return moved;
    }());
    run(crowd, 1.0F);
    EXPECT_NE(state.agents.find(state.entities.id[5])->corner & 0x80, 0) << "it straggles";
    run(crowd, 15.0F);
    EXPECT_EQ(state.agents.find(state.entities.id[5])->corner & 0x80, 0) << "it was taken back";
    EXPECT_EQ(disorder(crowd).second, 9U);
    // The slots of eight soldiers are the first eight, whichever soldiers had them.
    zone::despawn_entity(state, 5);
    run(crowd, 1.0F);
    std::set<int> slots;
    for (world::Row row = 1; row < state.entities.size(); ++row) {
        slots.insert(state.agents.find(state.entities.id[row])->corner & 0x7F);
    }
    EXPECT_EQ(slots, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
}

/// Rows, seen from both zones, of the owned agents: place in the world and slot.
struct Member {
    EntityId id;
    Vec2d at;
    Vec2d captain;
    int slot;
};

/// A company that marches over a border between two zones.
class Border {
  public:
    Border()
        : crowd_(with(kDrill,
                      "columns: 1 rows: 1 }",
                      "columns: 2 rows: 1 } ghost_margin_m: 60 handoff_hysteresis_m: 1"),
                 company()) {}

    void tick() {
        crowd_.tick();
        members_.clear();
        Vec2d captain = Vec2d::Zero();
        for (const auto& zone : crowd_.world().zones()) {
            const zone::ZoneState& state = zone->state();
            const Vec2d origin(state.settings.region().origin().x(),
                               state.settings.region().origin().z());
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                if (e.has(row, world::kGhost)) {
                    continue;
                }
                const Vec2d at =
                    origin + Vec2(e.position[row].x(), e.position[row].z()).cast<double>();
                if ((*state.settings.types)[e.type[row]].name == "captain") {
                    captain = at;
                } else {
                    members_.push_back({e.id[row],
                                        at,
                                        Vec2d::Zero(),
                                        state.agents.find(e.id[row])->corner & 0x7F});
                    east_ += state.settings.region().min_x >= 0.0 ? 1 : 0;
                }
            }
        }
        for (Member& member : members_) {
            member.captain = captain;
        }
    }

    [[nodiscard]] const std::vector<Member>& members() const { return members_; }

    /// How often a member was in the eastern zone.
    [[nodiscard]] int east() const { return east_; }

  private:
    Crowd crowd_;
    std::vector<Member> members_;
    int east_ = 0;
};

/// Half of it is in each zone for some seconds. No two soldiers share a slot, none takes another
/// slot, and each is as near its slot as within one zone.
TEST(FormationFollowing, GoesOnOverABorderBetweenZones) {
    Border border;
    for (int t = 0; t < 12 * 30; ++t) {
        border.tick();
    }
    std::map<std::uint64_t, int> slots;
    for (const Member& member : border.members()) {
        slots[member.id.value] = member.slot;
    }
    ASSERT_EQ(slots.size(), 9U);
    ASSERT_EQ(border.east(), 0);
    int split = 0;
    double worst = 0.0;
    for (int t = 0; t < 25 * 30; ++t) {
        const int before = border.east();
        border.tick();
        const int east = border.east() - before;
        split += east > 0 && east < 9 ? 1 : 0;
        ASSERT_EQ(border.members().size(), 9U);
        double sum = 0.0;
        for (const Member& member : border.members()) {
            EXPECT_EQ(member.slot, slots[member.id.value]) << "tick " << t;
            const Vec2d place(-1.6 * static_cast<double>(member.slot / 3 + 1),
                              1.6 * (static_cast<double>(member.slot % 3) - 1.0));
            sum += (member.at - member.captain - place).norm();
        }
        worst = std::max(worst, sum / 9.0);
    }
    EXPECT_GT(split, 60) << "some seconds";
    // As within one zone.
    EXPECT_LT(worst, 0.12 * 3.0 / 1.5 + 0.1);
}

TEST(FormationFollowing, WithoutACaptainTheyStand) {
    Placed placed = company();
    placed.erase(placed.begin());
    Crowd crowd(kDrill, placed);
    run(crowd, 5.0F);
    const Vec2 before = crowd.at(0);
    run(crowd, 2.0F);
    EXPECT_EQ(crowd.at(0), before);
}

TEST(FormationFollowing, IsCheckedWithLineAndColumn) {
    const auto mistakes = [](const std::string& from, const std::string& to) {
        config::Settings settings;
        std::vector<config::ConfigError> errors;
        EXPECT_FALSE(config::parse_settings(with(kDrill, from, to), {}, settings, errors));
        return config::format_errors("drill", errors);
    };
    EXPECT_THAT(mistakes("ward: \"captain\"", ""), testing::HasSubstr("forms up, but"));
    EXPECT_THAT(mistakes("action: FORM_UP", "action: IDLE"), testing::HasSubstr("drill:17:37"));
    EXPECT_THAT(mistakes("columns: 3", "taken_back_m: 9"), testing::HasSubstr("taken_back_m"));
    EXPECT_THAT(mistakes("along: \"c\"", ""), testing::HasSubstr("back the way it came"));
    EXPECT_THAT(mistakes("along: \"c\"", "along: \"d\""), testing::HasSubstr("named 'd'"));
}

TEST(Flock, GoesRoundItsPointsOfInterestTogether) {
    Placed placed;
    for (int i = 0; i < 12; ++i) {
        placed.push_back({"sheep",
                          {-30.0F + 1.5F * static_cast<float>(i % 4),
                           -38.0F + 1.5F * static_cast<float>(i / 4)}});
    }
    Crowd crowd(kDrill, placed);
    const Vec2 stops[] = {{-40.0F, -40.0F}, {40.0F, -40.0F}, {0.0F, 40.0F}};
    // Round once: 80 + 2 * 89.4 m at 1.5 m/s is 173 s.
    std::vector<int> passed;
    float spread = 0.0F;
    for (int t = 0; t < 200 * 30; ++t) {
        crowd.tick();
        Vec2 middle = Vec2::Zero();
        for (world::Row row = 0; row < 12; ++row) {
            middle += crowd.at(row) / 12.0F;
        }
        for (world::Row row = 0; row < 12; ++row) {
            spread = std::max(spread, (crowd.at(row) - middle).norm());
        }
        for (int stop = 0; stop < 3; ++stop) {
            if ((middle - stops[stop]).norm() < 12.0F &&
                (passed.empty() || passed.back() != stop)) {
                passed.push_back(stop);
            }
        }
    }
    // It begins near the first, so that one may count.
    if (!passed.empty() && passed.front() == 0) {
        passed.erase(passed.begin());
    }
    ASSERT_GE(passed.size(), 3U);
    EXPECT_EQ((std::vector<int>{passed[0], passed[1], passed[2]}), (std::vector<int>{1, 2, 0}));
    EXPECT_LT(spread, 20.0F) << "they stay a herd";
}

}  // namespace
}  // namespace zoned::app
