// The default world without a player: whoever is off screen stays out of walls and in the world.
#include "server/ai/agent/whereabouts.h"
#include "server/ai/steering/terrain_walk.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/zone_state.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

/// How deep a timetable may lead a walker's middle into a wall: led aside by 0.1 m, a piece of 0.2
/// m and a tick's way of 0.13 m, less its radius of 0.4 m.
constexpr float kDeepest_m = 0.05F;

/// Whether a place is inside a box that is no floor for a character at that height.
bool is_inside(const motion::StaticBox& box, const Vec3& at) {
    const Vec3 local = box.orientation.conjugate() * (at - box.centre);
    const Vec3 inner = box.half_extents - Vec3(kDeepest_m, 0.0F, kDeepest_m);
    return (inner.array() > 0.0F).all() && (local.cwiseAbs().array() < inner.array()).all();
}

/// Names of agents that stand in a wall or beyond the world now, and how many do not.
struct Found {
    std::vector<std::string> wrong;
    std::size_t right = 0;
};

/// Where an agent is by its timetable. Its height follows from the walk from where it was placed,
/// up ramps, over terraces and along their corners. Where there is no such walk, it is as high as
/// it was.
Vec3 place_of(const zone::ZoneState& state, const ai::Agent& agent, world::Row row, Tick now) {
    const Vec3& body = state.entities.position[row];
    const Vec2 from(body.x(), body.z());
    const Vec2 at = ai::whereabouts(agent, from, now, 1.0F / 30.0F);
    const float length = (at - from).norm();
    const motion::CharacterLimits& limits =
        (*state.settings.types)[state.entities.type[row]].character;
    const ai::LookAhead walk =
        ai::look_ahead(body,
                       length > 0.0F ? Vec2((at - from) / length) : Vec2::UnitX(),
                       length,
                       limits,
                       *state.settings.statics,
                       now,
                       ai::kDriftM);
    return {at.x(), walk.length < length ? body.y() : walk.end.y(), at.y()};
}

void look(zone::ZoneState& state, const config::Settings& settings, Tick now, Found& found) {
    const Vec3 origin = state.settings.region().origin().cast<float>();
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        const ai::Agent* const agent = state.agents.find(state.entities.id[row]);
        if (agent == nullptr || state.entities.has(row, world::kGhost)) {
            continue;
        }
        const Vec3 place = place_of(state, *agent, row, now);
        bool good = (origin + place).cwiseAbs().maxCoeff() < 998.0F;
        const motion::StaticGeometry& statics = *state.settings.statics;
        statics.for_each_near({place, place}, [&](std::uint32_t box) {
            good = good && !is_inside(statics.box(box), place);
        });
        found.right += good ? 1U : 0U;
        if (!good) {
            found.wrong.push_back(settings.types[state.entities.type[row]].name);
        }
    }
}

TEST(ValleyUnseen, NobodyWalksThroughWallsOrOutOfTheWorld) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/valley.txtpb", {}, settings, errors));
    World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    Found found;
    constexpr int kMinutes = 10;
    for (Tick tick = 0; tick < kMinutes * 60 * 30; ++tick) {
        world.tick({}, out);
        out.clear();
        if (tick % 300 == 299) {
            for (const auto& zone : world.zones()) {
                look(zone->state(), settings, world.now(), found);
            }
        }
    }
    EXPECT_GT(found.right, 400U * kMinutes * 6) << "hundreds of agents, looked at every 10 s";
    std::string names;
    for (const std::string& name : found.wrong) {
        names += name + " ";
    }
    EXPECT_EQ(names, "");
}

}  // namespace
}  // namespace zoned::app
