// Scene `npc_100k`: a hundred thousand minds of a town's types, a tenth of which players can see.
#include "tests/bench/suite_decisions_npc.h"

#include "server/app/world.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/npc_world.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <array>
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

/// What one of `people` costs in a tick of a whole zone in which no player is, ns of thread CPU
/// time: everybody simulated, or nobody.
double zone_ns(int people, bool skip_unseen, bool quick) {
    // In the order of the config's scatters, as `kTypes`; of those that always have to be simulated
    // one each.
    const std::array shares = {0.3, 0.3, 0.06, 0.2, 0.04, 0.1, 0.0, 0.0, 0.0};
    std::vector<std::string> sets = {
        "zones.zone_grid.columns=1",
        "zones.zone_grid.rows=1",
        "ai.dawn_s=60",
        std::string("ai.skip_unseen=") + (skip_unseen ? "true" : "false")};
    for (std::size_t k = 0; k < shares.size(); ++k) {
        sets.push_back("scatter[" + std::to_string(k) + "].count=" +
                       std::to_string(std::max(1, static_cast<int>(shares[k] * people))));
    }
    ops::Settings settings;
    std::vector<ops::ConfigError> errors;
    ops::load_settings(
        std::string(ZONED_SOURCE_DIR) + "/config/town.txtpb", sets, settings, errors);
    app::World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    // Who is seen by nobody falls asleep after two seconds.
    for (int t = 0; t < (quick ? 50 : 400); ++t) {
        world.tick({}, out);
    }
    const int ticks = quick ? 10 : 400;
    const std::int64_t begin = thread_cpu_ns();
    for (int t = 0; t < ticks; ++t) {
        world.tick({}, out);
    }
    return static_cast<double>(thread_cpu_ns() - begin) / ticks / people;
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
    const int people = session.quick ? 500 : 10'000;
    const double full_ns = zone_ns(people, false, session.quick);
    const double coarse_ns = zone_ns(people, true, session.quick);
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
