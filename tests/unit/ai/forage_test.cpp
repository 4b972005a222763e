// Off-screen ants: they find, mark and bring the same as ants in view.
#include "server/ai/serialization/serialize_agents.h"
#include "server/ai/steering/path_following.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::uint32_t kAnts = 40;

/// Across the direct path, with its middle at z, m.
motion::StaticBox wall(float z, float half) {
    motion::StaticBox box;
    box.centre = Vec3(0.0F, 0.5F, z);
    box.half_extents = Vec3(0.2F, 0.5F, half);
    return box;
}

/// A nest, crumbs 10 m from it, and a wall halfway with two gaps. The nearer gap has a door that is
/// shut from 120 s on.
class AntHill {
  public:
    /// An agent farther than `viewer_range_m` from a player goes from event to event.
    explicit AntHill(float viewer_range_m, bool door = false) {
        PoiSettings points_of_interest;
        points_of_interest.points_of_interest = {{"nest", Vec2d(-5.0, 0.0), 1.0F, {}},
                                                 {"crumbs", Vec2d(5.0, 0.0), 1.0F, {}}};
        field.points_of_interest = PointsOfInterest(points_of_interest, Vec2d::Zero(), kDt);
        Brain brain = single(ActionKind::kForage);
        ForageDef def;
        def.nest = 0;
        def.food = {1};
        def.radius_m = 14.0F;
        def.trails = {0.01F, 0.01F, 400};
        brain.states[0].forage = def;
        field.settings.brains = {brain};
        field.settings.viewer_range_m = viewer_range_m;
        compile(field.settings, kDt);
        motion::CharacterLimits& limits = field.types[kSheep].character;
        limits.speed = 1.0F;
        limits.acceleration = 10.0F;
        limits.radius = 0.1F;
        limits.half_segment = 0.05F;
        std::vector<motion::Door> doors;
        if (door) {
            doors.emplace_back();
            doors[0].box = wall(2.0F, 0.5F);
            doors[0].times.period = 1'000'000;
            doors[0].times.open = {{0, 120 * 30}};
        }
        field.statics = {
            {wall(5.0F, 2.5F), wall(-2.75F, 4.25F), wall(-12.0F, 4.0F), wall(12.5F, 5.0F)},
            0.0F,
            motion::kStaticCell_m,
            {},
            doors};
        field.solid = true;
        core::Rng rng(4);
        for (std::uint32_t id = 1; id <= kAnts; ++id) {
            const float z = rng.range(-3.0F, 3.0F);
            const float x = rng.range(-8.0F, -2.5F);
            field.add_npc(id, kSheep, 0, Vec3(x, 0.15F, z));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        }
    }

    /// Of scents and of brought food.
    [[nodiscard]] std::uint64_t scents() const {
        core::StateHash hash;
        field.steps.nests().hash(hash);
        return hash.value();
    }

    [[nodiscard]] std::uint64_t delivered() const { return field.steps.nests().delivered(); }

    [[nodiscard]] std::size_t active() const { return field.agents.active().size(); }

    /// The place that an ant's own state gives.
    [[nodiscard]] Vec2 place(std::uint32_t id) {
        const Agent& agent = *field.agents.find(EntityId(id));
        const Vec3& body = field.position(id);
        return whereabouts(agent, Vec2(body.x(), body.z()), field.now, kDt);
    }

    Field field;
};

constexpr float kAntsSeen = std::numeric_limits<float>::infinity();

/// Both go through the same, second by second.
void live_alike(AntHill& seen, AntHill& other, int seconds) {
    for (int second = 1; second <= seconds; ++second) {
        seen.field.run(1.0F);
        other.field.run(1.0F);
        ASSERT_EQ(seen.delivered(), other.delivered()) << "after " << second << " s";
        ASSERT_EQ(seen.scents(), other.scents()) << "after " << second << " s";
        for (std::uint32_t id = 1; id <= kAnts; ++id) {
            ASSERT_EQ(seen.place(id), other.place(id)) << id << " after " << second << " s";
        }
    }
}

// Walkers in this field meet no one, so that no body is held up by a metre. An ant's place, its
// marks and its path then follow from its timetable alone, to the last bit.

TEST(ForageOffscreen, IsTheSameToTheLastBit) {
    AntHill seen(kAntsSeen);
    AntHill unseen(50.0F);
    live_alike(seen, unseen, 600);
    EXPECT_EQ(seen.active(), kAnts);
    EXPECT_EQ(unseen.active(), 0U);
    EXPECT_GT(unseen.delivered(), 100U);
}

TEST(ForageOffscreen, IsTheSameWhereSomeAreSeen) {
    AntHill seen(kAntsSeen);
    AntHill part(1.0F);
    part.field.add_player(900, Vec3(22.0F, 0.9F, 0.0F));
    std::size_t least = kAnts;
    std::size_t most = 0;
    for (int k = 0; k < 60; ++k) {
        ASSERT_NO_FATAL_FAILURE(live_alike(seen, part, 5));
        least = std::min(least, part.active());
        most = std::max(most, part.active());
    }
    EXPECT_LT(least, kAnts) << "some are not seen";
    EXPECT_GT(most, 0U) << "and some are";
}

TEST(ForageSerialize, WhoIsReadAgainGoesOnBitForBit) {
    for (const float viewer_range_m : {kAntsSeen, 50.0F}) {
        AntHill one(viewer_range_m, true);
        one.field.run(100.0F);
        ASSERT_GT(one.delivered(), 0U);
        std::vector<std::uint8_t> bytes;
        save_agents(one.field.agents, one.field.steps, one.field.points_of_interest, bytes);
        AntHill other(viewer_range_m, true);
        other.field.now = one.field.now;
        other.field.entities = one.field.entities;
        other.field.agents = AgentStore();
        ASSERT_EQ(load_agents(bytes,
                              other.field.settings,
                              other.field.agents,
                              other.field.steps,
                              other.field.points_of_interest),
                  "");
        std::vector<std::uint8_t> again;
        save_agents(other.field.agents, other.field.steps, other.field.points_of_interest, again);
        EXPECT_EQ(bytes, again);
        // The door shuts at 120 s.
        ASSERT_NO_FATAL_FAILURE(live_alike(one, other, 60));
    }
}

TEST(ForageSerialize, AreRefusedWhereTheyMeanNothing) {
    AntHill hill(50.0F);
    hill.field.run(60.0F);
    std::vector<std::uint8_t> whole;
    save_agents(hill.field.agents, hill.field.steps, hill.field.points_of_interest, whole);
    const auto read = [&hill](std::vector<std::uint8_t> bytes) {
        AgentStore agents;
        AiUpdate steps;
        PointsOfInterest points_of_interest = hill.field.points_of_interest;
        return load_agents(bytes, hill.field.settings, agents, steps, points_of_interest);
    };
    ASSERT_EQ(read(whole), "");
    // A nest at the end: brain, action, type, number of cells, then 16 bytes for each.
    const std::size_t cells = hill.field.steps.nests().save().nests[0].cells.size();
    ASSERT_GT(cells, 10U);
    const std::size_t nest = whole.size() - 16 * cells - 4 - 6;
    std::vector<std::uint8_t> bytes = whole;
    bytes[nest] = 9;  // its brain
    EXPECT_EQ(read(bytes), "nest 0 is none, or has scents that are none");
    bytes = whole;
    bytes[nest + 2] = 1;  // its action
    EXPECT_EQ(read(bytes), "nest 0 is none, or has scents that are none");
    bytes = whole;
    bytes[whole.size() - 5] = 0x41;  // food of 8 or more
    EXPECT_EQ(read(bytes), "nest 0 is none, or has scents that are none");
    bytes = whole;
    bytes[whole.size() - 1] = 0xC1;  // fewer passages than none
    EXPECT_EQ(read(bytes), "nest 0 is none, or has scents that are none");
    bytes = whole;
    bytes[nest + 6 + 3] = 0x7F;  // cells without end
    EXPECT_EQ(read(bytes), "nests are cut short");
    for (std::size_t size = nest - 13; size < whole.size(); ++size) {
        bytes.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_NE(read(bytes), "") << size;
    }
    // Cells that are on no map are forgotten once the map is there.
    bytes = whole;
    bytes[whole.size() - 16 + 3] = 0x7F;
    ASSERT_EQ(load_agents(bytes,
                          hill.field.settings,
                          hill.field.agents = AgentStore(),
                          hill.field.steps,
                          hill.field.points_of_interest),
              "");
    hill.field.run(1.0F);
    // A direction with a bit that means nothing.
    hill.field.agents.find(EntityId(1))->corner = 0x80;
    whole.clear();
    save_agents(hill.field.agents, hill.field.steps, hill.field.points_of_interest, whole);
    EXPECT_EQ(read(whole), "agent 0 of entity 1 is at a corner that there is not");
}

TEST(ForageOffscreen, TurnsBeforeADoorThatShuts) {
    AntHill seen(kAntsSeen, true);
    AntHill unseen(50.0F, true);
    ASSERT_NO_FATAL_FAILURE(live_alike(seen, unseen, 300));
    AntHill open(50.0F);
    open.field.run(300.0F);
    EXPECT_NE(open.scents(), unseen.scents()) << "the door was noticed";
}

}  // namespace
}  // namespace zoned::ai
