// Entities far from all players have a reduced simulation, and no player can tell afterwards.
#include "server/zone/simulation/representation.h"

#include "server/app/world/world.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::app {
namespace {

config::InitialEntity initial(TypeIndex type, const Vec3d& place) {
    config::InitialEntity entity;
    entity.type = type;
    entity.position = place;
    return entity;
}

using zone::Representation;

constexpr float kFar = 100.0F;

/// One zone of 400 m: a player at one end, crates at the other.
struct Field {
    explicit Field(bool reducible, const std::vector<Vec3d>& crates) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        config::Settings settings = scenario::small_world(1, 1, 400.0);
        settings.types[scenario::kCrate].particle_beyond_m = reducible ? kFar : 0.0F;
        settings.initial.push_back(initial(scenario::kPlayer, Vec3d(-150, 0.9, 0)));
        for (const Vec3d& at : crates) {
            settings.initial.push_back(initial(scenario::kCrate, at));
        }
        world = std::make_unique<World>(settings, 1);
    }

    zone::ZoneState& state() { return world->zones()[0]->state(); }

    /// Row of the nth crate.
    world::Row crate(std::size_t n) {
        const world::Entities& e = state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (e.type[row] == scenario::kCrate && n-- == 0) {
                return row;
            }
        }
        ADD_FAILURE() << "no such crate";
        return 0;
    }

    Representation as(std::size_t n) {
        return static_cast<Representation>(state().entities.representation[crate(n)]);
    }

    void run(int ticks) {
        std::vector<mailbox::OutboxItem> out;
        for (int i = 0; i < ticks; ++i) {
            out.clear();
            world->tick({}, out);
        }
    }

    void bring_player(const Vec3& to) {
        const world::Entities& e = state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (e.type[row] == scenario::kPlayer) {
                zone::ZoneContext(state()).teleport(e.id[row], to);
                return;
            }
        }
    }

    std::unique_ptr<World> world;
};

TEST(RepresentationByNeed, IsAPointFarFromPlayersAndABodyNearThem) {
    Field field(true, {Vec3d(150, 30, 0)});
    EXPECT_EQ(field.as(0), Representation::kFull);
    field.run(30);
    EXPECT_EQ(field.as(0), Representation::kParticle);
    field.bring_player(Vec3(100, 0.9F, 0));
    field.run(zone::kRepresentationTicks);
    EXPECT_EQ(field.as(0), Representation::kFull);
}

/// In the air both fly the same parabola: to the rounding of a few floats of a hundred metres.
TEST(RepresentationByNeed, CarriesPositionAndVelocityOver) {
    Field reduced(true, {Vec3d(150, 60, 0)});
    Field full(false, {Vec3d(150, 60, 0)});
    for (Field* field : {&reduced, &full}) {
        const EntityId id = field->state().entities.id[field->crate(0)];
        zone::ZoneContext(field->state()).add_velocity(id, Vec3(-3, 10, 2));
    }
    bool was_particle = false;
    for (int tick = 0; tick < 60; ++tick) {
        if (tick == 40) {
            reduced.bring_player(Vec3(140, 0.9F, 0));
        }
        reduced.run(1);
        full.run(1);
        was_particle |= reduced.as(0) == Representation::kParticle;
        const world::Entities& a = reduced.state().entities;
        const world::Entities& b = full.state().entities;
        const Vec3 apart = a.position[reduced.crate(0)] - b.position[full.crate(0)];
        const Vec3 faster = a.velocity[reduced.crate(0)] - b.velocity[full.crate(0)];
        EXPECT_LT(apart.norm(), 60.0F * 0x1p-24F * 256.0F) << tick;
        EXPECT_LT(faster.norm(), 60.0F * 0x1p-24F * 32.0F) << tick;
    }
    EXPECT_TRUE(was_particle);
    EXPECT_EQ(reduced.as(0), Representation::kFull);
}

/// A box that lies as a point at its centre's height stands on its face again.
TEST(RepresentationByNeed, StandsWhereItFellAsABody) {
    Field field(true, {Vec3d(150, 5, 0)});
    field.run(90);
    ASSERT_EQ(field.as(0), Representation::kParticle);
    field.bring_player(Vec3(120, 3.0F, 0));  // it falls: a world at rest checks for no players
    field.run(60);
    EXPECT_EQ(field.as(0), Representation::kFull);
    const world::Entities& e = field.state().entities;
    EXPECT_NEAR(e.position[field.crate(0)].y(), 0.5F, 0.01F);
    EXPECT_NEAR(e.position[field.crate(0)].x(), 150.0F, 0.05F);
}

/// So many that lie still are looked up around the players. The choice is that of a look at each.
TEST(RepresentationByNeed, OfAThousandThatRestIsAsNearAsThePlayer) {
    std::vector<Vec3d> places;
    for (int i = 0; i < 1000; ++i) {
        places.emplace_back(-45.0 + 6.0 * (i % 40), 0.6, -75.0 + 6.0 * (i / 40));
    }
    Field field(true, places);
    field.run(200);
    const world::Entities& e = field.state().entities;
    const auto crate_rows = [&](const auto& visit) {
        for (world::Row row = 0; row < e.size(); ++row) {
            if (e.type[row] == scenario::kCrate) {
                visit(row);
            }
        }
    };
    std::size_t resting = 0;
    crate_rows([&](world::Row row) {
        resting += e.representation[row] != 0 && e.has(row, world::kAtRest) ? 1U : 0U;
    });
    ASSERT_GT(resting, 900U);
    const Vec3 player(150, 3.0F, 20);  // falls: a world at rest checks for no players
    field.bring_player(player);
    field.run(zone::kRepresentationTicks);
    std::size_t full = 0;
    std::size_t reduced = 0;
    crate_rows([&](world::Row row) {
        const float distance = (e.position[row] - player).norm();
        if (std::abs(distance - 0.9F * kFar) < 3.0F) {
            return;  // the player has moved meanwhile
        }
        const bool near = distance < 0.9F * kFar;
        EXPECT_EQ(e.representation[row] == 0, near) << distance;
        full += near ? 1U : 0U;
        reduced += near ? 0U : 1U;
    });
    EXPECT_GT(full, 100U);
    EXPECT_GT(reduced, 100U);
}

/// A point slides to a stop by friction (v / (0.5 g), about a second for 4 m/s) and then costs
/// nothing any more.
TEST(RepresentationByNeed, ComesToRestAsAPoint) {
    Field field(true, {Vec3d(150, 4, 0)});
    field.run(1);
    zone::ZoneContext(field.state())
        .add_velocity(field.state().entities.id[field.crate(0)], Vec3(4, 1.2F, 0));
    field.run(150);
    ASSERT_EQ(field.as(0), Representation::kParticle);
    EXPECT_TRUE(field.state().entities.has(field.crate(0), world::kAtRest));
    EXPECT_FALSE(field.state().report.plan.has(zone::Pass::kPhysics));
}

/// No player's arrival pulls a stone out of a wall, nor lets one fall through another.
TEST(RepresentationByNeed, StaysABodyWhileOthersTouchItOrMay) {
    Field field(true, {Vec3d(150, 0.6, 0), Vec3d(150, 1.7, 0), Vec3d(150, 4.0, 0)});
    for (int i = 0; i < 60; ++i) {
        field.run(1);
        for (std::size_t crate = 0; crate < 3; ++crate) {
            EXPECT_EQ(field.as(crate), Representation::kFull) << i;
        }
    }
    const world::Entities& e = field.state().entities;
    EXPECT_NEAR(e.position[field.crate(2)].y(), 2.5F, 0.05F);
}

TEST(RepresentationByNeed, CostsNothingWhereNoTypeAsksForIt) {
    Field field(false, {Vec3d(150, 5, 0)});
    field.run(8);
    const zone::StepReport& report = field.state().report;
    EXPECT_FALSE(report.plan.has(zone::Pass::kRepresentation));
    EXPECT_EQ(report.plan.reason[static_cast<std::size_t>(zone::Pass::kRepresentation)],
              "no type may be simulated as less than it is");
}

}  // namespace
}  // namespace zoned::app
