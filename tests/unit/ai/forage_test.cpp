// Ants that nobody sees: they find, mark and bring what they would have brought before our eyes.
#include "server/ai/walk.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::uint32_t kAnts = 40;

/// Across the way, with its middle at z, m.
motion::StaticBox wall(float z, float half) {
    motion::StaticBox box;
    box.centre = Vec3(0.0F, 0.5F, z);
    box.half_extents = Vec3(0.2F, 0.5F, half);
    return box;
}

/// A nest and crumbs 10 m from it, and a wall half way with two gaps; the nearer one has a door
/// that is shut from 120 s on.
class AntHill {
  public:
    /// Who is farther than `seen_m` from a player goes from event to event.
    explicit AntHill(float seen_m, bool door = false) {
        PlaceSettings places;
        places.places = {{"nest", Vec2d(-5.0, 0.0), 1.0F, {}},
                         {"crumbs", Vec2d(5.0, 0.0), 1.0F, {}}};
        field.places = Places(places, Vec2d::Zero(), kDt);
        Machine machine = single(ActionKind::kForage);
        ForageDef def;
        def.nest = 0;
        def.food = {1};
        def.radius_m = 14.0F;
        def.trails = {0.01F, 0.01F, 400};
        machine.states[0].forage = def;
        field.settings.machines = {machine};
        field.settings.seen_m = seen_m;
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
            field.add_npc(
                id, kSheep, 0, Vec3(rng.range(-8.0F, -2.5F), 0.15F, rng.range(-3.0F, 3.0F)));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        }
    }

    /// Of scents and food brought.
    [[nodiscard]] std::uint64_t scents() const {
        core::StateHash hash;
        field.steps.nests().hash(hash);
        return hash.value();
    }

    [[nodiscard]] std::uint64_t delivered() const { return field.steps.nests().delivered(); }

    [[nodiscard]] std::size_t awake() const { return field.minds.awake().size(); }

    /// Where an ant takes itself to be.
    [[nodiscard]] Vec2 place(std::uint32_t id) {
        const Mind& mind = *field.minds.find(EntityId(id));
        const Vec3& body = field.position(id);
        return whereabouts(mind, Vec2(body.x(), body.z()), field.now, kDt);
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

// Walkers in this field meet nobody, so that nothing holds a body up by a metre: then where an ant
// is, what it marks and which way it takes follow from its timetable alone, to the last bit.

TEST(ForageUnseen, IsTheSameToTheLastBit) {
    AntHill seen(kAntsSeen);
    AntHill unseen(50.0F);
    live_alike(seen, unseen, 600);
    EXPECT_EQ(seen.awake(), kAnts);
    EXPECT_EQ(unseen.awake(), 0U);
    EXPECT_GT(unseen.delivered(), 100U);
}

TEST(ForageUnseen, IsTheSameWhereSomeAreSeen) {
    AntHill seen(kAntsSeen);
    AntHill part(1.0F);
    part.field.add_player(900, Vec3(22.0F, 0.9F, 0.0F));
    std::size_t least = kAnts;
    std::size_t most = 0;
    for (int k = 0; k < 60; ++k) {
        ASSERT_NO_FATAL_FAILURE(live_alike(seen, part, 5));
        least = std::min(least, part.awake());
        most = std::max(most, part.awake());
    }
    EXPECT_LT(least, kAnts) << "some are not seen";
    EXPECT_GT(most, 0U) << "and some are";
}

TEST(ForageUnseen, TurnsBeforeADoorThatShuts) {
    AntHill seen(kAntsSeen, true);
    AntHill unseen(50.0F, true);
    ASSERT_NO_FATAL_FAILURE(live_alike(seen, unseen, 300));
    AntHill open(50.0F);
    open.field.run(300.0F);
    EXPECT_NE(open.scents(), unseen.scents()) << "the door was noticed";
}

}  // namespace
}  // namespace zoned::ai
