// Scene `npc_100k`: a hundred thousand minds of a town's types, a tenth of which players can see.
#include "tests/bench/suite_decisions_npc.h"

#include "tests/bench/npc_world.h"
#include "tests/bench/statistics.h"

#include <algorithm>
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
    double awake = 0.0;
    double events = 0.0;
    double decisions = 0.0;
};

NpcRun run_world(const ops::Settings& settings, NpcWorld::Plan plan, Tick settle, Tick ticks) {
    NpcWorld world(settings, plan);
    while (world.now() < settle) {
        world.tick();
    }
    NpcRun run;
    for (Tick t = 0; t < ticks; ++t) {
        const NpcWorld::Cost cost = world.tick();
        run.tick_us.push_back(static_cast<double>(cost.minds_ns) * 1e-3);
        run.wall_ms += static_cast<double>(cost.minds_wall_ns) * 1e-6;
        run.walk_ms += static_cast<double>(cost.walk_ns) * 1e-6;
        run.awake += world.report().awake;
        run.events += world.report().events;
        run.decisions += world.report().decisions;
    }
    for (double* sum : {&run.wall_ms, &run.walk_ms, &run.awake, &run.events, &run.decisions}) {
        *sum /= static_cast<double>(ticks);
    }
    std::sort(run.tick_us.begin(), run.tick_us.end());
    return run;
}

}  // namespace

void run_npcs(Session& session, const std::string& scene) {
    ops::Settings settings;
    std::vector<ops::ConfigError> errors;
    if (!ops::load_settings(
            std::string(ZONED_SOURCE_DIR) + "/config/town.txtpb", {}, settings, errors)) {
        session.note("npc_100k: config/town.txtpb could not be read");
        return;
    }
    NpcWorld::Plan plan;
    plan.people = session.quick ? 2'000 : 100'000;
    plan.shares = kTypes;
    // A player sees a disc of some 70 m: so many that a tenth of all are seen.
    plan.players = session.quick ? 4 : 144;
    plan.side_m = session.quick ? 750.0F : 4'500.0F;
    plan.threads = 2;
    // Minds that are seen by nobody fall asleep after two seconds, and the day begins at 40 s.
    const Tick settle = session.quick ? 60 : 1'200;
    const Tick ticks = session.quick ? 20 : 400;
    const NpcRun all = run_world(settings, plan, settle, ticks);
    // What one of them costs, by itself: everybody simulated, and nobody seen; one thread.
    NpcWorld::Plan full = plan;
    full.threads = 1;
    full.people /= 10;
    full.players = 0;
    full.side_m *= 0.32F;
    NpcWorld::Plan coarse = full;
    full.simulate_all = true;
    const NpcRun simulated = run_world(settings, full, settle, ticks);
    const NpcRun skipped = run_world(settings, coarse, settle, ticks);
    const auto people = static_cast<double>(full.people);
    const double full_ns = (mean(simulated.tick_us) * 1e3 + simulated.walk_ms * 1e6) / people;
    const double coarse_ns = (mean(skipped.tick_us) * 1e3 + skipped.walk_ms * 1e6) / people;
    Row row;
    row.suite = "decisions";
    row.scene = scene;
    row.parameter = "people=" + std::to_string(plan.people);
    row.time_us_p50 = quantile(all.tick_us, 0.5);
    row.time_us_p99 = quantile(all.tick_us, 0.99);
    row.metric("wall_ms_mean", all.wall_ms);
    row.metric("awake_mean", all.awake);
    row.metric("decisions_per_tick", all.decisions);
    row.metric("events_per_tick", all.events);
    row.metric("full_ns_per_npc", full_ns);
    row.metric("coarse_ns_per_npc", coarse_ns);
    row.metric("coarse_share", coarse_ns / full_ns);
    session.add({row});
}

}  // namespace zoned::bench
