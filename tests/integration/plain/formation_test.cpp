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

/// The place of a slot in rows of three, the last row centred: ahead of the captain and to its
/// right, m.
Vec2 slot_of_three(std::size_t slot, std::size_t members) {
    const std::size_t in_row = std::min<std::size_t>(3, members - slot / 3 * 3);
    return 1.6F * Vec2(-static_cast<float>(slot / 3 + 1),
                       static_cast<float>(slot % 3) - 0.5F * static_cast<float>(in_row - 1));
}

/// The distance of the others from the slots of rows of three behind their captain, who walks along
/// x. It is the mean over the others, each to the nearest slot, m. Every slot is occupied where the
/// returned number of slots is theirs.
std::pair<float, std::size_t> disorder(Crowd& crowd, world::Row captain = 0) {
    float sum = 0.0F;
    std::set<std::size_t> held;
    const std::size_t members = crowd.state().entities.size() - 1;
    for (world::Row row = 0; row <= members; ++row) {
        if (row == captain) {
            continue;
        }
        float least = 1e9F;
        std::size_t nearest = 0;
        for (std::size_t slot = 0; slot < members; ++slot) {
            const Vec2 place = crowd.at(captain) + slot_of_three(slot, members);
            const float distance = (crowd.at(row) - place).norm();
            nearest = distance < least ? slot : nearest;
            least = std::min(least, distance);
        }
        held.insert(nearest);
        sum += least;
    }
    return {sum / static_cast<float>(members), held.size()};
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

/// Soldiers of whom one leads where there is no captain.
const std::string kHeirs =
    with(with(kDrill, "ward: \"captain\"", "ward: \"captain\" succession: true"),
         "spacing_m: 1.6 } }",
         R"(spacing_m: 1.6 } transition { to: "lead" sensor: LEADS } }
  state { name: "lead" action: GO point_of_interest: "there" speed_factor: 0.4
    transition { to: "form" sensor: LEADS compare: BELOW threshold: 0.5 }
  })");

/// The agents of a zone that walk by themselves, in place of forming up, and the wards of the rest.
struct Lead {
    std::vector<EntityId> leaders;
    std::set<std::uint64_t> wards;
    std::set<std::uint64_t> soldiers;

    void look(zone::ZoneState& state) {
        const world::Entities& e = state.entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (e.has(row, world::kGhost) ||
                (*state.settings.types)[e.type[row]].name != "soldier") {
                continue;
            }
            const ai::Agent& agent = *state.agents.find(e.id[row]);
            soldiers.insert(e.id[row].value);
            if (agent.current_action == 0) {
                wards.insert(agent.ward.value);
            } else {
                leaders.push_back(e.id[row]);
            }
        }
    }
};

Lead lead_of(Crowd& crowd) {
    Lead lead;
    for (const auto& zone : crowd.world().zones()) {
        lead.look(zone->state());
    }
    return lead;
}

void expect_one_leads(Crowd& crowd, std::size_t soldiers) {
    const Lead lead = lead_of(crowd);
    ASSERT_EQ(lead.soldiers.size(), soldiers);
    ASSERT_EQ(lead.leaders.size(), 1U);
    EXPECT_EQ(lead.leaders[0].value, *lead.soldiers.begin()) << "the one with the least id";
    if (soldiers > 1) {
        EXPECT_EQ(lead.wards, std::set<std::uint64_t>{lead.leaders[0].value});
    }
}

TEST(FormationFollowing, WithoutTheirCaptainOneOfThemLeads) {
    Crowd crowd(kHeirs, company());
    run(crowd, 10.0F);
    EXPECT_TRUE(lead_of(crowd).leaders.empty()) << "the captain lives";
    world::Entities& e = crowd.state().entities;
    zone::despawn_entity(crowd.state(), 0);
    run(crowd, 15.0F);
    ASSERT_NO_FATAL_FAILURE(expect_one_leads(crowd, 9));
    const world::Row leader = e.find(lead_of(crowd).leaders[0]);
    EXPECT_GT(crowd.at(leader).x(), 0.0F) << "it marches on";
    const auto [off, held] = disorder(crowd, leader);
    EXPECT_EQ(held, 8U) << "each has a slot of its own";
    EXPECT_LT(off, 0.12F * 3.0F / 1.5F + 0.1F) << "as behind a captain";
    // Whoever leads is lost, until one is left.
    for (std::size_t left = 8; left > 0; --left) {
        zone::despawn_entity(crowd.state(), e.find(lead_of(crowd).leaders[0]));
        run(crowd, 1.0F);
        ASSERT_NO_FATAL_FAILURE(expect_one_leads(crowd, left));
    }
    const Vec2 before = crowd.at(0);
    run(crowd, 1.0F);
    EXPECT_GT(crowd.at(0).x(), before.x() + 0.5F) << "the last one goes on";
}

TEST(FormationFollowing, ACaptainWhoComesBackLeadsAgain) {
    Placed placed = company();
    placed.erase(placed.begin());
    Crowd crowd(kHeirs, placed);
    run(crowd, 5.0F);
    ASSERT_NO_FATAL_FAILURE(expect_one_leads(crowd, 9));
    zone::SpawnDef captain;
    captain.position = Vec3(0.0F, 0.9F, 0.0F);
    const auto& types = *crowd.state().settings.types;
    captain.type = static_cast<TypeIndex>(
        std::find_if(
            types.begin(), types.end(), [](const auto& t) { return t.name == "captain"; }) -
        types.begin());
    const EntityId id = zone::spawn_entity(crowd.state(), captain);
    run(crowd, 2.0F);
    const Lead lead = lead_of(crowd);
    EXPECT_TRUE(lead.leaders.empty());
    EXPECT_EQ(lead.wards, std::set<std::uint64_t>{id.value});
}

/// The captain is lost while the company is on both sides of a border: there is one leader.
TEST(FormationFollowing, OverABorderOneLeads) {
    Crowd crowd(with(kHeirs,
                     "columns: 1 rows: 1 }",
                     "columns: 2 rows: 1 } ghost_margin_m: 60 handoff_hysteresis_m: 1"),
                company());
    const auto east = [&] {
        Lead lead;
        lead.look(crowd.world().zones().back()->state());
        return lead.soldiers.size();
    };
    for (int t = 0; t < 60 * 30 && east() < 4; ++t) {
        crowd.tick();
    }
    ASSERT_GE(east(), 4U);
    ASSERT_LT(east(), 9U);
    for (const auto& zone : crowd.world().zones()) {
        zone::ZoneState& state = zone->state();
        for (world::Row row = 0; row < state.entities.size(); ++row) {
            if (!state.entities.has(row, world::kGhost) &&
                (*state.settings.types)[state.entities.type[row]].name == "captain") {
                zone::despawn_entity(state, row);
                break;
            }
        }
    }
    int split = 0;
    for (int t = 0; t < 15 * 30; ++t) {
        crowd.tick();
        split += east() < 9 ? 1 : 0;
        if (t > 30) {
            ASSERT_NO_FATAL_FAILURE(expect_one_leads(crowd, 9));
        }
    }
    EXPECT_GT(split, 60) << "some seconds";
    EXPECT_EQ(east(), 9U) << "all have come over";
}

/// Two soldiers who meet far from all players: when the one begins to follow the other.
std::vector<std::pair<Tick, std::uint64_t>> meeting(bool unseen) {
    const std::string near = with(kHeirs, "perception_m: 60", "perception_m: 20");
    Crowd crowd(unseen ? with(near, "suspend_offscreen: false", "suspend_offscreen: true") : near,
                {{"soldier", {-40.0F, -40.0F}}, {"soldier", {-40.0F, 40.0F}}});
    std::vector<std::pair<Tick, std::uint64_t>> changes;
    std::map<std::uint64_t, int> before;
    bool slept = false;
    for (Tick t = 0; t < 90 * 30; ++t) {
        crowd.tick();
        const world::Entities& e = crowd.state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const ai::Agent& agent = *crowd.state().agents.find(e.id[row]);
            slept = slept || agent.tier == ai::Tier::kSuspended;
            int& was = before[e.id[row].value];
            if (agent.current_action != was) {
                changes.emplace_back(t, e.id[row].value);
                was = agent.current_action;
            }
        }
    }
    EXPECT_EQ(slept, unseen);
    return changes;
}

TEST(FormationFollowing, UnseenTheyMeetAndOneFollowsAtTheSameTick) {
    const auto seen = meeting(false);
    // Both lead, then the second follows the first.
    ASSERT_EQ(seen.size(), 3U);
    EXPECT_EQ(seen[2].second, std::max(seen[0].second, seen[1].second));
    EXPECT_EQ(meeting(true), seen);
}

TEST(FormationFollowing, IsCheckedWithLineAndColumn) {
    const auto mistakes = [](const std::string& from, const std::string& to) {
        config::Settings settings;
        std::vector<config::ConfigError> errors;
        EXPECT_FALSE(config::parse_settings(with(kDrill, from, to), {}, settings, errors));
        return config::format_errors("drill", errors);
    };
    EXPECT_THAT(mistakes("ward: \"captain\"", ""), testing::HasSubstr("forms up, but"));
    EXPECT_THAT(
        mistakes("action: FORM_UP", "transition { to: \"form\" sensor: LEADS } action: FORM_UP"),
        testing::HasSubstr("asks LEADS"));
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
