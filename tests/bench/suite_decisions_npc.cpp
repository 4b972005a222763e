// Scene `npc_100k`: a hundred thousand agents of a town's types; players can see a tenth of them.
#include "tests/bench/suite_decisions_npc.h"

#include "server/config/expand/load_settings.h"
#include "tests/bench/npc_world.h"
#include "tests/bench/npc_zone.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace zoned::bench {

namespace {

const std::vector<NpcShare> kTypes = {{"fisher", 0.3},
                                      {"farmer", 0.3},
                                      {"porter", 0.06},
                                      {"pilgrim", 0.2},
                                      {"guard", 0.04},
                                      {"mayfly", 0.1}};

/// Means over the ticks of a run, ns.
struct NpcRun {
    std::vector<double> tick_us;
    double wall_ms = 0.0;
    double walk_ms = 0.0;
    double active = 0.0;
    double events = 0.0;
    double decisions = 0.0;
};

NpcRun run_world(const config::Settings& settings, NpcWorld::Plan plan, Tick settle, Tick ticks) {
    NpcWorld world(settings, plan);
    while (world.now() < settle) {
        world.tick();
    }
    NpcRun run;
    for (Tick t = 0; t < ticks; ++t) {
        const NpcWorld::Cost cost = world.tick();
        run.tick_us.push_back(static_cast<double>(cost.agents_ns) * 1e-3);
        run.wall_ms += static_cast<double>(cost.agents_wall_ns) * 1e-6;
        run.walk_ms += static_cast<double>(cost.walk_ns) * 1e-6;
        run.active += world.report().active;
        run.events += world.report().events;
        run.decisions += world.report().decisions;
    }
    for (double* sum : {&run.wall_ms, &run.walk_ms, &run.active, &run.events, &run.decisions}) {
        *sum /= static_cast<double>(ticks);
    }
    std::sort(run.tick_us.begin(), run.tick_us.end());
    return run;
}

constexpr int kQuickPeople = 500;
/// An agent that no viewer covers is suspended after two seconds.
constexpr int kSettle = 400;

NpcZoneCost zone_cost(const Session& session, NpcZone::Plan plan, int ticks) {
    plan.people = session.quick ? kQuickPeople : plan.people;
    NpcZone zone(plan);
    zone.settle(session.quick ? 50 : kSettle);
    return zone.run(session.quick ? 10 : ticks);
}

/// A day of ten minutes, and how long a busy stretch of it is.
constexpr int kDayTicks = 12'000;
constexpr int kStretchTicks = 400;

NpcZoneDay zone_day(const Session& session, NpcZone::Plan plan) {
    plan.people = session.quick ? kQuickPeople : plan.people;
    NpcZone zone(plan);
    zone.settle(session.quick ? 50 : kSettle);
    return session.quick ? zone.day(200, 20) : zone.day(kDayTicks, kStretchTicks);
}

/// One line with the parts of a tick's time.
std::string by_pass(const std::string& what, const NpcZoneCost& cost) {
    std::array<char, 64> text{};
    const auto ns = [&](double value) {
        std::snprintf(text.data(), text.size(), "%.3f", value);
        return std::string(text.data());
    };
    std::string line = what + ": " + ns(cost.ns) + " ns per NPC and tick, active " +
                       ns(cost.active) + ", events " + ns(cost.events_per_tick) + " a tick:";
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        if (cost.pass_ns[p] > 0.0) {
            line += " " + std::string(zone::pass_name(static_cast<zone::Pass>(p))) + " " +
                    ns(cost.pass_ns[p]);
        }
    }
    return line + " rest " + ns(cost.rest_ns);
}

/// The costs of an off-screen person of a zone and of a simulated one.
void run_zones(Session& session, Row& row) {
    constexpr int kPeople = 100'000;
    const NpcZoneCost full = zone_cost(session, {10'000, false, false}, 400);
    const NpcZoneCost ten = zone_cost(session, {10'000, true, false}, 400);
    const NpcZoneCost alone = zone_cost(session, {kPeople, true, false}, 400);
    const NpcZoneCost viewed = zone_cost(session, {kPeople, true, true}, 400);
    const NpcZoneDay day = zone_day(session, {kPeople, true, false});
    // The few that the viewer resumes cost the same as ever.
    const double active = viewed.active - alone.active;
    const double people = session.quick ? kQuickPeople : kPeople;
    const double viewed_ns = (viewed.ns * people - active * full.ns) / (people - active);
    session.note(by_pass("npc_100k: 10,000 simulated", full));
    session.note(by_pass("npc_100k: 10,000 unseen", ten));
    session.note(by_pass("npc_100k: 100,000 unseen", alone));
    session.note(by_pass("npc_100k: 100,000 and a viewer near few", viewed));
    session.note(by_pass("npc_100k: 100,000 unseen, a whole day", day.mean));
    session.note(by_pass("npc_100k: 100,000 unseen, its busiest 20 s", day.busiest));
    row.metric("full_ns_per_npc", full.ns);
    row.metric("coarse_ns_per_npc_10k", ten.ns);
    row.metric("coarse_ns_per_npc", alone.ns);
    row.metric("coarse_ns_per_npc_viewer", viewed_ns);
    row.metric("coarse_events_per_tick", alone.events_per_tick);
    row.metric("coarse_share", alone.ns / full.ns);
    row.metric("coarse_share_viewer", viewed_ns / full.ns);
    row.metric("coarse_share_day", day.mean.ns / full.ns);
    row.metric("coarse_share_busiest", day.busiest.ns / full.ns);
    row.metric("coarse_events_per_tick_day", day.mean.events_per_tick);
    row.metric("coarse_events_per_tick_busiest", day.busiest.events_per_tick);
}

}  // namespace

void run_npcs(Session& session, const std::string& scene) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(ZONED_SOURCE_DIR "/config/town.txtpb", {}, settings, errors)) {
        session.note("npc_100k: config/town.txtpb could not be read");
        return;
    }
    NpcWorld::Plan plan;
    plan.people = session.quick ? 2'000 : 100'000;
    plan.shares = kTypes;
    // A player sees a disc of some 70 m: with this many players, a tenth of all agents are seen.
    plan.players = session.quick ? 4 : 144;
    plan.side_m = session.quick ? 750.0F : 4'500.0F;
    plan.threads = 2;
    // Agents that no viewer covers are suspended after two seconds, and the day begins at 40 s.
    const Tick settle = session.quick ? 60 : 1'200;
    const Tick ticks = session.quick ? 20 : 400;
    const NpcRun all = run_world(settings, plan, settle, ticks);
    Row row;
    row.suite = "decisions";
    row.scene = scene;
    row.parameter = "people=" + std::to_string(plan.people);
    row.time_us_p50 = quantile(all.tick_us, 0.5);
    row.time_us_p99 = quantile(all.tick_us, 0.99);
    row.metric("wall_ms_mean", all.wall_ms);
    row.metric("awake_mean", all.active);
    row.metric("decisions_per_tick", all.decisions);
    row.metric("events_per_tick", all.events);
    run_zones(session, row);
    session.add({row});
}

}  // namespace zoned::bench
