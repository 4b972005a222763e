// Parts that a world does not have run no instruction of a tick and hold nothing: one table of
// parts, each with a world that lacks it and the same world with it.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

using zone::Pass;

template <class... Lists>
std::size_t room_of(const Lists&... lists) {
    return (static_cast<std::size_t>(lists.capacity()) + ... + 0U);
}

/// A flat world with a player's type and crates, some of them awake.
std::string base_world(int zones) {
    return "world { name: \"parts\" seed: 5 min_x_m: -60 min_z_m: -30 max_x_m: 60 max_z_m: 30 }\n"
           "zones { zone_grid { columns: " +
           std::to_string(zones) + R"( rows: 1 } }
session { dev_mode_loopback: true }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: 80
  aura_m { normal: 40 } nimbus_m { normal: 40 } character { } }
type { name: "crate" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } mass_kg: 15 aura_m { normal: 40 } }
scatter { type: "crate" count: 10 seed: 1 asleep: true }
spawn { x_m: -30 z_m: 0 }
lod { position_bound_m: 0.05 }
)";
}

const char* const kWalkers = R"(
type { name: "walker" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: 70
  aura_m { normal: 40 } character { speed_mps: 1.5 } brain: "walk" }
brain { name: "walk" state { name: "walk" action: WANDER radius_m: 15 } }
scatter { type: "walker" count: 6 seed: 2 }
)";

const char* const kCart = R"(
type { name: "cart" friction: 1 aura_m { normal: 40 } assembly {
  part { name: "chassis" box { x_m: 1.4 y_m: 0.4 z_m: 2.4 } y_m: 0.6 mass_kg: 120 }
  part { name: "wheel" sphere { radius_m: 0.35 } x_m: 0.95 y_m: 0.35 mass_kg: 12 }
  joint { name: "axle" a: "chassis" b: "wheel"
    hinge { axis { x: 1 } motor { speed_rps { constant: 9 } max_torque_nm: 150 } } } } }
entity { type: "cart" x_m: 0 z_m: 10 }
)";

struct Part {
    std::string name;
    std::string added;         ///< to the config: then the world has it
    std::vector<Pass> passes;  ///< that run for it alone
    std::function<std::size_t(const World&)>
        held;                    ///< what it holds: elements or bytes; 0: nothing
    bool shared = false;         ///< `added` is config of worlds with and without it
    int zones_with = 1;          ///< of the world that has it
    bool viewer_without = true;  ///< a client plays in the world that lacks it, too
    int ticks = 40;
};

const zone::ZoneState& state_of(const World& world) {
    return world.zones().front()->state();
}

/// `Reads`: of the first zone's state.
template <class Reads>
std::function<std::size_t(const World&)> in_zone(Reads reads) {
    return [reads](const World& world) {
        return static_cast<std::size_t>(reads(state_of(world)));
    };
}

std::vector<Part> parts() {
    using zone::ZoneState;
    return {
        {"bodies awake",
         "scatter { type: \"crate\" count: 3 seed: 9 min_distance_m: 3 }",
         {Pass::kPhysics, Pass::kContacts},
         in_zone([](const ZoneState& s) { return s.scene.awake_count(); }),
         false,
         1,
         false,
         3},
        {"agents", kWalkers, {Pass::kAgents}, in_zone([](const ZoneState& s) {
             return s.agents.slots();
         })},
        {"path finding",
         std::string(kWalkers) + "ai { pathfinding { } }",
         {},
         in_zone([](const ZoneState& s) { return s.paths.empty() ? 0 : 1; })},
        {"soft bodies",
         "type { name: \"jelly\" soft { jelly { size { x_m: 1 y_m: 0.8 z_m: 1 } stiffness_npm: "
         "600 bulk_modulus_pa: 4000 } thickness_m: 0.03 damping: 0.5 } mass_kg: 40 aura_m { "
         "normal: 40 } max_acceleration_mps2: 60 max_velocity_jump_mps: 25 } entity { type: "
         "\"jelly\" x_m: 5 z_m: 5 }",
         {Pass::kSoft},
         in_zone([](const ZoneState& s) { return s.soft == nullptr ? 0 : 1; })},
        {"simulated particles",
         "particles { name: \"hail\" cosmetic: false emitter { x_m: 0 y_m: 20 z_m: 0 spread_m: 8 "
         "rate_hz: 200 pitch_deg: -90 cone_deg: 10 speed_min_mps: 5 speed_max_mps: 10 "
         "lifetime_min_s: 3 lifetime_max_s: 5 seed: 3 } radius_m: 0.01 most: 500 }",
         {Pass::kParticles},
         in_zone([](const ZoneState& s) {
             return room_of(s.particles.systems, s.particles.near, s.particles.balls);
         })},
        {"cosmetic bursts",
         "particles { name: \"debris\" burst { cone_deg: 50 slowest: 0.3 lifetime_min_s: 0.5 "
         "lifetime_max_s: 1 aura_m: 30 } }",
         {},
         in_zone([](const ZoneState& s) { return room_of(s.particles.cosmetic_due); })},
        {"joints and motors", kCart, {Pass::kMotors}, in_zone([](const ZoneState& s) {
             return room_of(s.assemblies.joints,
                            s.assemblies.joints_of,
                            s.assemblies.riders,
                            s.assemblies.motors,
                            s.assemblies.changed);
         })},
        {"static boxes",
         "statics { box { x_m: 15 y_m: 1 z_m: 0 size { x_m: 4 y_m: 2 z_m: 4 } } }",
         {},
         in_zone([](const ZoneState& s) { return s.settings.statics->boxes().size(); })},
        {"surfaces from files",
         "statics { surface { file: \"" ZONED_SOURCE_DIR
         "/config/geometry/hills.png\" height_m: 12 spacing_m: 1 } }",
         {},
         in_zone([](const ZoneState& s) { return room_of(s.settings.surfaces); })},
        {"doors",
         "door { name: \"gate\" box { x_m: 20 y_m: 1.5 z_m: 0 size { x_m: 2 y_m: 3 z_m: 0.2 } } "
         "period_s: 1 open { from_s: 0.2 to_s: 0.6 } }",
         {Pass::kDoors},
         in_zone([](const ZoneState& s) { return room_of(s.doors.body); })},
        {"platforms",
         "platform { name: \"lift\" wait_s: 0 box { x_m: 20 y_m: 1 size { x_m: 3 y_m: 0.2 z_m: 3 } "
         "} stop { x_m: 20 y_m: 5 } }",
         {Pass::kPlatforms},
         in_zone([](const ZoneState& s) { return room_of(s.platforms); })},
        {"viewers",
         "",
         {Pass::kRules, Pass::kInterest, Pass::kReplication},
         in_zone([](const ZoneState& s) {
             return room_of(s.clients, s.viewers, s.visibility, s.own_inputs) +
                    s.replicator.heard_count();
         }),
         true,
         1,
         false},
        {"visibility filter",
         "type { name: \"thief\" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 9 aura_m { normal: 40 } "
         "visibility_filter: LINE_OF_SIGHT } entity { type: \"thief\" x_m: -25 z_m: 0 }",
         {Pass::kVisibilityFilter},
         in_zone([](const ZoneState& s) {
             return room_of(s.filtered.heard,
                            s.filtered.viewers,
                            s.filtered.due,
                            s.filtered.listed,
                            s.filtered.before,
                            s.filtered.aligned_viewers,
                            s.filtered.aligned_notified,
                            s.filtered.fresh);
         })},
        {"history",
         "type { name: \"target\" rewindable: true box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 9 aura_m "
         "{ normal: 40 } } entity { type: \"target\" x_m: -25 z_m: 0 }",
         {Pass::kHistory},
         in_zone([](const ZoneState& s) {
             return room_of(s.history_rows) + (s.history.empty() ? 0U : 1U);
         })},
        {"audit",
         "audit { enabled: true period_ticks: 5 }",
         {Pass::kAudit},
         in_zone([](const ZoneState& s) { return room_of(s.audited_radii); })},
        {"neighbours",
         "",
         {Pass::kHandoff, Pass::kGhosts},
         in_zone([](const ZoneState& s) {
             return s.near_border.size() + room_of(s.ghosts_out,
                                                   s.ghosts_out_rows,
                                                   s.ghosts_out_fresh,
                                                   s.ghost_ids,
                                                   s.ghost_owners,
                                                   s.led_ghosts,
                                                   s.ghost_contacts);
         }),
         false,
         2},
        {"levels of representation",
         "type { name: \"stone\" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 9 aura_m { normal: 10 } "
         "representation { particle_beyond_m: 30 } } entity { type: \"stone\" x_m: 40 z_m: 0 y_m: "
         "20 }",
         {Pass::kRepresentation},
         in_zone([](const ZoneState& s) {
             return room_of(s.players, s.bodies_near, s.representation_rows);
         })},
        {"shared environment",
         "environment { clock { name: \"time_of_day\" start: 8 rate_per_s: 0.02 period: 24 } }",
         {},
         in_zone([](const ZoneState& s) { return s.settings.environment == nullptr ? 0 : 1; })},
        {"declared fields",
         "type { name: \"chest\" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 9 aura_m { normal: 40 } "
         "field { name: \"gold\" number { max: 100 } } } entity { type: \"chest\" x_m: -25 z_m: 5 "
         "}",
         {},
         in_zone([](const ZoneState& s) { return s.entities.fields().any() ? 1 : 0; })},
        {"bandwidth meter",
         "replication { bandwidth_meter: true }",
         {},
         in_zone([](const ZoneState& s) { return s.replicator.traffic() == nullptr ? 0 : 1; })},
        {"store",
         "",
         {},
         [](const World& world) {
             return room_of(const_cast<World&>(world).store_requests()) +
                    static_cast<std::size_t>(state_of(world).next_store_request);
         },
         true,
         1,
         false,
         320},
    };
}

/// What a run has shown of a part.
struct Seen {
    std::vector<bool> ran;    ///< of each of its passes, in any tick
    std::uint64_t units = 0;  ///< that these counted
    std::size_t most_held = 0;
};

config::Settings settings_of(const Part& part, bool with) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    const std::string text =
        base_world(with ? part.zones_with : 1) + (with || part.shared ? part.added : std::string());
    EXPECT_TRUE(config::parse_settings(text, {}, settings, errors))
        << part.name << ": " << config::format_errors("test", errors);
    return settings;
}

Seen watch(const Part& part, bool with) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    World world(settings_of(part, with), 1);
    std::vector<mailbox::OutboxItem> out;
    Seen seen;
    seen.ran.resize(part.passes.size());
    for (int t = 0; t < part.ticks; ++t) {
        std::vector<mailbox::InboxItem> items;
        if (t == 1 && (part.viewer_without || with)) {
            mailbox::Join join;
            join.client = ClientId(1);
            join.name = "player";
            join.account = "account";
            join.rights = mailbox::kRightPlay | mailbox::kRightAudit;
            items.emplace_back(join);
        }
        out.clear();
        world.tick(items, out);
        for (const auto& zone : world.zones()) {
            for (std::size_t k = 0; k < part.passes.size(); ++k) {
                const zone::PassReport& pass =
                    zone->report().passes[static_cast<std::size_t>(part.passes[k])];
                seen.ran[k] = seen.ran[k] || pass.ran;
                seen.units += pass.count;
            }
        }
        seen.most_held = std::max(seen.most_held, part.held(world));
    }
    return seen;
}

TEST(AbsentParts, RunNoPassAndHoldNothing) {
    for (const Part& part : parts()) {
        const Seen seen = watch(part, false);
        for (std::size_t k = 0; k < part.passes.size(); ++k) {
            EXPECT_FALSE(seen.ran[k]) << part.name << ": " << pass_name(part.passes[k]);
        }
        EXPECT_EQ(seen.units, 0U) << part.name;
        EXPECT_EQ(seen.most_held, 0U) << part.name;
    }
}

/// The measures see each part that is there: without this a world could hide one from them.
TEST(AbsentParts, AreSeenWhereTheyArePresent) {
    for (const Part& part : parts()) {
        const Seen seen = watch(part, true);
        for (std::size_t k = 0; k < part.passes.size(); ++k) {
            EXPECT_TRUE(seen.ran[k]) << part.name << ": " << pass_name(part.passes[k]);
        }
        EXPECT_GT(seen.most_held, 0U) << part.name;
    }
}

/// Calls of operator new while `make` makes a part and lets it go.
template <class Make>
std::uint64_t allocations_of(Make&& make) {
    const std::uint64_t before = allocation_count();
    make();
    return allocation_count() - before;
}

/// A zone has these as members, present or not.
TEST(AbsentParts, AllocateNothingBeforeTheyAreUsed) {
    EXPECT_EQ(allocations_of([] { const zone::AssemblyState part; }), 0U);
    EXPECT_EQ(allocations_of([] { const zone::DoorBodies part; }), 0U);
    EXPECT_EQ(allocations_of([] { const zone::PoseHistory part; }), 0U);
    EXPECT_EQ(allocations_of([] { const zone::FilteredVisibility part; }), 0U);
    EXPECT_EQ(allocations_of([] { const zone::StepOutput part; }), 0U);
    EXPECT_EQ(allocations_of([] { const zone::ParticlesOfZone part; }), 0U);
    EXPECT_EQ(allocations_of([] { const ai::AgentStore part; }), 0U);
    EXPECT_EQ(allocations_of([] { const ai::AiUpdate part; }), 0U);
    EXPECT_EQ(allocations_of([] { const ai::PathService part; }), 0U);
    EXPECT_EQ(allocations_of([] { const ai::PointsOfInterest part; }), 0U);
    EXPECT_EQ(allocations_of([] { const interest::Matcher part; }), 0U);
    EXPECT_EQ(allocations_of([] { const spatial::PointGrid part; }), 0U);
    EXPECT_EQ(allocations_of([] { const world::Entities part; }), 0U);
    // The count counts. What outlives the block is not optimised away.
    std::vector<int> kept;
    EXPECT_GT(allocations_of([&] { kept.resize(100); }), 0U);
    EXPECT_EQ(kept.size(), 100U);
}

}  // namespace
}  // namespace zoned::app
