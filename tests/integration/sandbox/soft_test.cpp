// Soft bodies in worlds: as clients see them, on several thread counts, over borders, and at rest.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "tests/harness/game_test.h"

#include <algorithm>
#include <string_view>

namespace zoned::harness {
namespace {

class Soft : public GameTest {
  protected:
    Soft() { server.config = ZONED_SOURCE_DIR "/config/cloth.txtpb"; }
};

TEST_F(Soft, BodiesAreSeenAsPromisedWhileTheyArePushedAbout) {
    bots.bots = 20;
    bots.seconds = 12.0;
    std::uint64_t steps = 0;
    std::uint64_t beyond_limits = 0;
    const measure::RunReport report = run([&](VirtualServer& now, double) {
        for (const auto& zone : now.world().zones()) {
            steps += zone->report().soft.awake;
            beyond_limits += zone->report().replication.limit_exceeded;
        }
    });
    EXPECT_GT(steps, 0u);
    EXPECT_EQ(beyond_limits, 0u) << "the config declares too low limits";
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 200u);
    EXPECT_EQ(report.converged_bots, 20u);
}

TEST_F(Soft, BodiesMoveAlikeOnOneThreadAndOnTwo) {
    bots.seconds = 4.0;
    const auto hash_on = [this](unsigned threads) {
        server.threads = threads;
        run();
        return world->world().state_hash();
    };
    const std::uint64_t one = hash_on(1);
    EXPECT_EQ(one, hash_on(2));
}

config::Settings settings_of(const std::string& file, const std::vector<std::string>& sets = {}) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::load_settings(ZONED_SOURCE_DIR "/config/" + file, sets, settings, errors))
        << config::format_errors(file, errors);
    return settings;
}

/// The zones that own it: one.
std::vector<zone::ZoneState*> owners_of(app::World& world, EntityId entity) {
    std::vector<zone::ZoneState*> owners;
    for (const auto& zone : world.zones()) {
        if (zone->owns(entity)) {
            owners.push_back(&zone->state());
        }
    }
    return owners;
}

void run_ticks(app::World& world, int ticks) {
    std::vector<mailbox::OutboxItem> out;
    for (int i = 0; i < ticks; ++i) {
        world.tick({}, out);
        out.clear();
    }
}

/// The first entity of that type that a zone owns.
EntityId first_of(const zone::ZoneState& state, std::string_view type) {
    const world::Entities& e = state.entities;
    for (world::Row row = 0; row < e.size(); ++row) {
        if (!e.has(row, world::kGhost) && (*state.settings.types)[e.type[row]].name == type) {
            return e.id[row];
        }
    }
    return {};
}

Vec3d place_of(const zone::ZoneState& state, EntityId entity) {
    return state.settings.region().origin() +
           state.entities.position[state.entities.find(entity)].cast<double>();
}

TEST(SoftInZones, ABodyGoesOverTheBorderWithAllItsNodes) {
    const config::Settings settings = settings_of("cloth.txtpb");
    app::World world(settings, 1);
    run_ticks(world, 30);
    zone::ZoneState& west = world.zones()[0]->state();
    const EntityId jelly = first_of(west, "jelly");
    ASSERT_TRUE(jelly);
    ASSERT_TRUE(zone::soft_of(west, jelly));
    const std::size_t nodes = west.soft->bodies.node_count(zone::soft_of(west, jelly));
    // Flown to where the border lies.
    world::Entities& e = west.entities;
    zone::push_soft(west, e.find(jelly), Vec3(6.0F, 5.0F, 0.0F));
    Vec3d before = place_of(west, jelly);
    bool over = false;
    const float farthest = 1.2F * west.settings.types->at(e.type[e.find(jelly)]).extent();
    for (int t = 0; t < 90; ++t) {
        run_ticks(world, 1);
        const std::vector<zone::ZoneState*> owners = owners_of(world, jelly);
        ASSERT_EQ(owners.size(), 1u);
        zone::ZoneState& now = *owners.front();
        over = over || now.settings.id.value == 2;
        const Vec3d at = place_of(now, jelly);
        // The distance that 12 m/s cover in a tick: it does not jump.
        ASSERT_LT((at - before).norm(), 12.0 / 30.0);
        before = at;
        const physics::soft::SoftId body = zone::soft_of(now, jelly);
        ASSERT_TRUE(body);
        ASSERT_EQ(now.soft->bodies.node_count(body), nodes);
        const Vec3 centre = now.entities.position[now.entities.find(jelly)];
        for (std::size_t i = 0; i < nodes; ++i) {
            ASSERT_LT((now.soft->bodies.position(body, i) - centre).norm(), farthest);
        }
        const zone::ZoneState& other = world.zones()[2 - now.settings.id.value]->state();
        ASSERT_FALSE(zone::soft_of(other, jelly)) << "a ghost is no soft body";
    }
    EXPECT_TRUE(over);
}

TEST(SoftInZones, RulesPushTeleportHideShowAndRemoveThem) {
    const config::Settings settings = settings_of("cloth.txtpb");
    app::World world(settings, 1);
    run_ticks(world, 30);
    zone::ZoneState& state = world.zones()[0]->state();
    const EntityId jelly = first_of(state, "jelly");
    const auto row = [&] {
        return state.entities.find(jelly);
    };
    const std::size_t bodies = state.soft->links.size();
    zone::ZoneContext context(state);
    const Vec3 before = state.entities.velocity[row()];
    context.add_velocity(jelly, Vec3(0.0F, 3.0F, 0.0F));
    EXPECT_NEAR(state.entities.velocity[row()].y() - before.y(), 3.0F, 1e-4F);
    EXPECT_FALSE(state.entities.has(row(), world::kAtRest));
    context.teleport(jelly, Vec3(1.0F, 6.0F, 2.0F));
    run_ticks(world, 1);
    // It fell for one tick.
    EXPECT_NEAR(state.entities.position[row()].y(), 6.0F, 0.02F);
    EXPECT_EQ(state.entities.discontinuity_tick[row()], world.now() - 1);
    context.hide(jelly);
    EXPECT_FALSE(zone::soft_of(state, jelly));
    EXPECT_EQ(state.soft->links.size(), bodies - 1);
    run_ticks(world, 5);
    context.show(jelly, Vec3(1.0F, 4.0F, 2.0F), Vec3(0.0F, 0.0F, 1.0F));
    const physics::soft::SoftId body = zone::soft_of(state, jelly);
    ASSERT_TRUE(body);
    EXPECT_LT((state.soft->bodies.rigid_hull(body).position - Vec3(1.0F, 4.0F, 2.0F)).norm(),
              1e-4F);
    EXPECT_NEAR(state.soft->bodies.rigid_hull(body).velocity.z(), 1.0F, 1e-4F);
    context.despawn(jelly);
    EXPECT_FALSE(zone::soft_of(state, jelly));
    EXPECT_EQ(row(), world::kNoRow);
    run_ticks(world, 2);
}

/// All soft bodies of a type, with their entities, as they were added.
std::vector<const zone::SoftLink*> links_of(const zone::ZoneState& state, std::string_view type) {
    std::vector<const zone::SoftLink*> out;
    for (const zone::SoftLink& link : state.soft->links) {
        const world::Row row = state.entities.find(link.entity);
        if ((*state.settings.types)[state.entities.type[row]].name == type) {
            out.push_back(&link);
        }
    }
    return out;
}

/// No agent walks here. The upper body of each pair rests on the lower one: within its outline, and
/// higher than it would lie on the ground.
TEST(SoftInZones, APairMeetsAndStaysAPair) {
    config::Settings settings = settings_of("cloth.txtpb");
    std::erase_if(settings.initial, [&](const config::InitialEntity& entity) {
        return settings.types[entity.type].brain != 0;
    });
    app::World world(settings, 1);
    run_ticks(world, 450);
    int stacked = 0;
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        const physics::soft::SoftBodies& bodies = state.soft->bodies;
        for (const std::string_view type : {"jelly", "balloon"}) {
            for (const zone::SoftLink* upper : links_of(state, type)) {
                for (const zone::SoftLink* lower : links_of(state, "jelly")) {
                    const Vec3 over = bodies.rigid_hull(upper->body).position -
                                      bodies.rigid_hull(lower->body).position;
                    // Half a jelly is 0.4 m high, half a balloon 0.5 m.
                    stacked += over.y() > 0.7F && over.y() < 1.0F &&
                                       Vec3(over.x(), 0, over.z()).norm() < 0.5F
                                   ? 1
                                   : 0;
                }
            }
        }
    }
    EXPECT_EQ(stacked, 2);
}

TEST(SoftInZones, PassRunsUntilAllSleepAndSaysWhy) {
    // No player walks here, so all bodies come to rest.
    config::Settings settings = settings_of("cloth.txtpb");
    const auto has_agent = [&](const config::InitialEntity& entity) {
        return settings.types[entity.type].brain != 0;
    };
    settings.initial.erase(
        std::remove_if(settings.initial.begin(), settings.initial.end(), has_agent),
        settings.initial.end());
    app::World world(settings, 1);
    run_ticks(world, 1);
    const zone::ZoneState& west = world.zones()[0]->state();
    const auto soft = static_cast<std::size_t>(zone::Pass::kSoft);
    EXPECT_TRUE(west.report.plan.runs[soft]);
    EXPECT_EQ(west.report.plan.reason[soft], "soft bodies are awake");
    EXPECT_GT(west.report.census.awake_soft, 0u);
    int ticks = 0;
    while (west.report.plan.runs[soft] && ticks < 3000) {
        run_ticks(world, 30);
        ticks += 30;
    }
    EXPECT_FALSE(west.report.plan.runs[soft]) << west.report.census.awake_soft << " still awake";
    EXPECT_EQ(west.report.plan.reason[soft], "all soft bodies sleep and nothing comes near");
    for (const zone::SoftLink& link : west.soft->links) {
        const world::Row row = west.entities.find(link.entity);
        EXPECT_TRUE(west.entities.has(row, world::kAtRest));
        EXPECT_TRUE(west.entities.velocity[row].isZero(0.0F));
    }
}

/// The banner is drawn with all vertices of its file: they hang down from its pins, and nowhere
/// apart from the nodes that were simulated.
TEST(SoftInZones, TheBannerIsDrawnFinerThanItIsSimulated) {
    const config::Settings settings = settings_of("cloth.txtpb");
    app::World world(settings, 2);
    for (const auto& zone : world.zones()) {
        const EntityId banner = first_of(zone->state(), "banner");
        if (!banner) {
            continue;
        }
        run_ticks(world, 150);
        const physics::soft::SoftBodies& bodies = zone->state().soft->bodies;
        const physics::soft::SoftId body = zone::soft_of(zone->state(), banner);
        EXPECT_EQ(bodies.node_count(body), 150U);
        std::vector<Vec3> drawn(bodies.vertex_count(body));
        ASSERT_EQ(drawn.size(), 609U);
        bodies.vertices(body, drawn);
        EXPECT_EQ(bodies.drawn_faces(body).size(), 2U * 20U * 28U);
        Aabb box{drawn.front(), drawn.front()};
        for (const Vec3& v : drawn) {
            box.lower = box.lower.cwiseMin(v);
            box.upper = box.upper.cwiseMax(v);
        }
        const Aabb around = bodies.bounds(body).grown(0.05F);
        EXPECT_TRUE((box.lower.array() >= around.lower.array()).all());
        EXPECT_TRUE((box.upper.array() <= around.upper.array()).all());
        // 2.4 m long, hung by its upper edge: at rest no edge is longer or shorter by 2 %, for 30 N
        // on a sheet of 3000 N/m.
        EXPECT_NEAR(box.upper.y() - box.lower.y(), 2.4F, 0.02F * 2.4F);
        return;
    }
    ADD_FAILURE() << "no zone has a banner";
}

TEST(SoftInZones, WhereNoTypeIsSoftThereIsNothing) {
    const config::Settings settings = settings_of("minimal.txtpb");
    app::World world(settings, 1);
    run_ticks(world, 3);
    for (const auto& zone : world.zones()) {
        EXPECT_EQ(zone->state().soft, nullptr);
        EXPECT_TRUE(zone->state().settings.softs.empty());
        const zone::StepPlan& plan = zone->report().plan;
        EXPECT_FALSE(plan.has(zone::Pass::kSoft));
        EXPECT_EQ(plan.reason[static_cast<std::size_t>(zone::Pass::kSoft)], "no soft body");
    }
}

}  // namespace
}  // namespace zoned::harness
