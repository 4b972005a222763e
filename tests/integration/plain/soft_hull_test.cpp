// Soft bodies far from all players are rigid hulls, and no player can tell afterwards.
#include "server/zone/simulation/soft_hull.h"

#include "server/app/world/world.h"
#include "server/physics/soft/builders/builders.h"
#include "server/physics/soft/builders/mesh_builder.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/simulation/representation.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::app {
namespace {

config::InitialEntity hull_at(TypeIndex type, const Vec3d& place) {
    config::InitialEntity entity;
    entity.type = type;
    entity.position = place;
    return entity;
}

namespace soft = physics::soft;

constexpr float kSoftFar = 50.0F;
constexpr TypeIndex kSoft = 3;
constexpr float kTick = 1.0F / 30.0F;

soft::SoftDef cube() {
    soft::JellyDef def;
    def.centre = Vec3::Zero();
    return *soft::build_jelly(def);
}

/// Zones of 200 m side by side with one soft body; players where a test brings them.
struct SoftField {
    SoftField(bool reducible, const soft::SoftDef& def, const Vec3d& at, int columns = 1) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        config::Settings settings = scenario::small_world(columns, 1, 200.0);
        world::EntityType type;
        type.name = "soft";
        type.shape = world::TypeShape::kSoft;
        type.half_extents = Vec3::Constant(0.6F);
        type.radius = 1.1F;
        type.standing = Aabb{-type.half_extents, type.half_extents};
        type.aura_m.fill(40.0F);
        type.single_beyond_m = reducible ? kSoftFar : 0.0F;
        settings.types.push_back(type);
        settings.softs.push_back(std::make_shared<const soft::SoftDef>(def));
        settings.initial.push_back(hull_at(kSoft, at));
        settings.initial.push_back(hull_at(scenario::kPlayer, Vec3d(-90, 0.9, 90)));
        world = std::make_unique<World>(settings, 1);
    }

    [[nodiscard]] zone::ZoneState& state(std::size_t zone = 0) const {
        return world->zones()[zone]->state();
    }

    /// Of the first entity of a type that the zone owns; kNoRow: it has none.
    [[nodiscard]] world::Row row_of(TypeIndex type, std::size_t zone = 0) const {
        const world::Entities& e = state(zone).entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (e.type[row] == type && !e.has(row, world::kGhost)) {
                return row;
            }
        }
        return world::kNoRow;
    }

    [[nodiscard]] bool rigid(std::size_t zone = 0) const {
        const world::Row row = row_of(kSoft, zone);
        const soft::SoftId body = zone::soft_of(state(zone), state(zone).entities.id[row]);
        const bool as_column = state(zone).entities.representation[row] != 0;
        EXPECT_EQ(state(zone).soft->bodies.rigid(body), as_column);
        EXPECT_EQ(static_cast<bool>(state(zone).entities.body[row]), as_column);
        return as_column;
    }

    [[nodiscard]] Vec3 position() const { return state().entities.position[row_of(kSoft)]; }

    [[nodiscard]] Vec3 velocity() const { return state().entities.velocity[row_of(kSoft)]; }

    void run(int ticks) const {
        std::vector<mailbox::OutboxItem> out;
        for (int i = 0; i < ticks; ++i) {
            out.clear();
            world->tick({}, out);
        }
    }

    void bring_player(const Vec3& to) const {
        zone::ZoneContext(state()).teleport(state().entities.id[row_of(scenario::kPlayer)], to);
    }

    void push(const Vec3& change) const {
        zone::ZoneContext(state()).add_velocity(state().entities.id[row_of(kSoft)], change);
    }

    std::unique_ptr<World> world;
};

TEST(SoftHull, IsWhatASoftBodyIsFarFromPlayersAndNotNearThem) {
    const SoftField field(true, cube(), Vec3d(0, 40, 0));
    field.run(1);
    EXPECT_FALSE(field.rigid());
    field.run(zone::kRepresentationTicks);
    EXPECT_TRUE(field.rigid());
    const zone::StepReport& report = field.state().report;
    EXPECT_EQ(report.plan.reason[static_cast<std::size_t>(zone::Pass::kSoft)],
              "rigid hulls may be soft again");
    EXPECT_TRUE(report.soft.skipped);
    EXPECT_EQ(report.soft.rigid, 1U);
    field.bring_player(Vec3(20, 0.9F, 0));
    field.run(2 * zone::kRepresentationTicks);
    EXPECT_FALSE(field.rigid());
    EXPECT_FALSE(field.state().report.soft.skipped);
}

/// In the air neither place nor velocity nor turn jumps, down or up. From tick to tick the velocity
/// changes by g dt, the centre moves by as much as both velocities give, and the turn by the spin.
TEST(SoftHull, ChangesPlaceVelocityAndTurnNowhereByAJump) {
    const SoftField field(true, cube(), Vec3d(0, 60, 0));
    field.run(1);
    field.push(Vec3(2, 6, 1));
    const soft::SoftId body =
        zone::soft_of(field.state(), field.state().entities.id[field.row_of(kSoft)]);
    for (std::size_t i = 0; i < field.state().soft->bodies.node_count(body); ++i) {
        const Vec3 arm = field.state().soft->bodies.position(body, i) - field.position();
        const Vec3 spin = Vec3(0.3F, 1.0F, 0.2F).cross(arm);
        field.state().soft->bodies.apply_impulse(
            body, i, field.state().soft->bodies.mass(body, i) * spin);
    }
    field.run(1);
    int changes = 0;
    for (int tick = 0; tick < 75; ++tick) {
        if (tick == 40) {
            field.bring_player(Vec3(20, 50, 0));
        }
        const bool was = field.rigid();
        const Vec3 x = field.position();
        const Vec3 v = field.velocity();
        const Quat q = field.state().entities.orientation[field.row_of(kSoft)];
        field.run(1);
        changes += was != field.rigid() ? 1 : 0;
        const Quat q2 = field.state().entities.orientation[field.row_of(kSoft)];
        // Roundings of sums over some sixty nodes 60 m away from the origin, in m and m/s.
        const Vec3 fallen = v - Vec3(0, kGravity * kTick, 0);
        EXPECT_LT((field.velocity() - fallen).norm(), 2e-3F) << tick;
        EXPECT_LT((field.position() - x - 0.5F * kTick * (v + field.velocity())).norm(), 2e-4F)
            << tick;
        // A spin of 1.06 rad/s, and some wobble of the soft body.
        EXPECT_NEAR(q.angularDistance(q2), 1.06F * kTick, 0.2F * kTick) << tick;
    }
    EXPECT_EQ(changes, 2);
}

/// It lands as a box and is still one when a player comes: its centre is at half its height, within
/// the amount that it is squeezed by.
TEST(SoftHull, LiesWhereTheSoftBodyWouldLie) {
    const SoftField hull(true, cube(), Vec3d(0, 3, 0));
    const SoftField full(false, cube(), Vec3d(0, 3, 0));
    hull.run(150);
    full.run(150);
    EXPECT_TRUE(hull.rigid());
    EXPECT_LT((hull.position() - full.position()).norm(), 0.05F);
    hull.bring_player(Vec3(20, 0.9F, 0));
    hull.push(Vec3(0, 0.1F, 0));  // a world at rest checks for no players
    EXPECT_FALSE(hull.rigid());
    hull.run(120);
    EXPECT_FALSE(hull.rigid());
    EXPECT_LT((hull.position() - full.position()).norm(), 0.05F);
}

/// A ball drawn with 162 vertices and simulated with 60.
soft::SoftDef drawn_ball() {
    soft::BalloonDef balloon;
    balloon.splits = 2;
    const soft::SoftDef built = *soft::build_balloon(balloon);
    soft::MeshBodyDef def;
    def.nodes = 60;
    def.stiffness = 2000.0F;
    def.gas_pressure = 102000.0F;
    for (const soft::SoftNode& node : built.nodes) {
        def.vertices.push_back(node.position);
    }
    for (const soft::SoftFace& face : built.faces) {
        def.indices.insert(def.indices.end(), face.begin(), face.end());
    }
    return *soft::build_mesh_body(def);
}

/// A body from a mesh falls as its hull, and its drawn vertices go with it.
TEST(SoftHull, IsWhatABodyFromAMeshIsFarFromPlayers) {
    const SoftField field(true, drawn_ball(), Vec3d(0, 60, 0));
    field.run(1);
    const soft::SoftBodies& bodies = field.state().soft->bodies;
    const soft::SoftId body =
        zone::soft_of(field.state(), field.state().entities.id[field.row_of(kSoft)]);
    const auto shape = [&] {
        std::vector<Vec3> out(bodies.vertex_count(body));
        bodies.vertices(body, out);
        for (Vec3& v : out) {
            v -= field.position();
        }
        return out;
    };
    const std::vector<Vec3> before = shape();
    ASSERT_EQ(before.size(), 162U);
    ASSERT_EQ(bodies.node_count(body), 60U);
    field.run(zone::kRepresentationTicks);
    EXPECT_TRUE(field.rigid());
    field.bring_player(Vec3(20, 50, 0));
    for (int tick = 0; tick < 2 * zone::kRepresentationTicks && field.rigid(); ++tick) {
        field.run(1);
    }
    EXPECT_FALSE(field.rigid());
    const std::vector<Vec3> after = shape();
    for (std::size_t i = 0; i < before.size(); ++i) {
        // The overpressure of 675 Pa stretches it by less than p R / (2 k), 8.5 %, and as it begins
        // without, it swings to twice that.
        EXPECT_LT((after[i] - before[i]).norm(), 0.17F * 0.5F) << i;
    }
}

TEST(SoftHull, IsSoftAgainWhenRulesMoveHideOrRemoveIt) {
    const SoftField field(true, cube(), Vec3d(0, 40, 0));
    const EntityId id = field.state().entities.id[field.row_of(kSoft)];
    const auto wait = [&] {
        field.run(2 * zone::kRepresentationTicks);
        ASSERT_TRUE(field.rigid());
    };
    wait();
    zone::ZoneContext context(field.state());
    const Vec3 before = field.velocity();
    context.add_velocity(id, Vec3(1, 0, 0));
    EXPECT_FALSE(field.rigid());
    EXPECT_LT((field.velocity() - before - Vec3(1, 0, 0)).norm(), 1e-4F);
    wait();
    context.teleport(id, Vec3(3, 50, 1));
    EXPECT_FALSE(field.rigid());
    field.run(1);
    EXPECT_LT((field.position() - Vec3(3, 50, 1)).norm(), 0.01F);
    wait();
    const BodyId hull = field.state().entities.body[field.row_of(kSoft)];
    ASSERT_TRUE(field.state().scene.contains(hull));
    context.hide(id);
    EXPECT_FALSE(zone::soft_of(field.state(), id));
    EXPECT_FALSE(field.state().entities.body[field.row_of(kSoft)]);
    EXPECT_FALSE(field.state().scene.contains(hull));
    field.run(1);
    context.show(id, Vec3(0, 30, 0), Vec3::Zero());
    wait();
    context.despawn(id);
    field.run(2);
    EXPECT_EQ(field.row_of(kSoft), world::kNoRow);
}

/// It crosses the border as its nodes, and steps down on the other side by itself.
TEST(SoftHull, GoesOverABorder) {
    const SoftField field(true, cube(), Vec3d(-3, 60, 0), 2);
    field.run(2 * zone::kRepresentationTicks);
    ASSERT_TRUE(field.rigid());
    field.push(Vec3(8, 10, 0));
    field.run(3 * zone::kRepresentationTicks);
    ASSERT_NE(field.row_of(kSoft, 1), world::kNoRow);
    EXPECT_EQ(field.row_of(kSoft, 0), world::kNoRow);
    EXPECT_TRUE(field.rigid(1));
    // Flown for a second and a bit: nowhere near any obstacle.
    const zone::ZoneState& east = field.state(1);
    const Vec3 v = east.entities.velocity[field.row_of(kSoft, 1)];
    EXPECT_NEAR(v.x(), 8.0F, 0.01F);
}

}  // namespace
}  // namespace zoned::app
