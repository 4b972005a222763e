#include "server/app/calibration/measure_codec.h"
#include "server/app/calibration/particle_device.h"
#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"
#include "server/app/planner/analysis.h"
#include "server/app/runtime/agent_report.h"
#include "server/app/runtime/tick_loop.h"
#include "server/app/world/world.h"
#include "server/config/expand/method_plan.h"
#include "server/config/npc/parameters.h"
#include "server/config/world/pathfinding_config.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

namespace zoned::app {

namespace {

const char* name_of(ai::PathMapKind map) {
    return map == ai::PathMapKind::kGrid
               ? "cells"
               : (map == ai::PathMapKind::kNavmesh ? "a mesh" : "waypoints");
}

void print_particles(const config::Settings& settings, const ParticleDevice& device) {
    std::printf("%s\n", device.text.c_str());
    if (!device.no_cache.empty()) {
        std::printf("%s\n", device.no_cache.c_str());
    }
    if (!settings.cosmetics.empty()) {
        std::printf(
            "cosmetic particle systems: %zu, neither simulated nor sent (but for one event a "
            "burst): "
            "clients replay them\n",
            settings.cosmetics.size());
    }
}

void print_store(const config::StoreSettings& store) {
    if (store.kind == config::StoreKind::kNone) {
        std::printf(
            "\nstore: none: a restart forgets bans, used tickets and what the rules keep\n");
        return;
    }
    if (store.kind == config::StoreKind::kPostgresql) {
        std::printf(
            "\nstore: %s; a commit outlives what the database outlives; writes wait in up to %u "
            "MB\n",
            store.url.c_str(),
            store.max_waiting_mb);
        return;
    }
    std::printf("\nstore: %s (SQLite); a commit outlives %s; writes wait in up to %u MB\n",
                store.file.c_str(),
                store.durability == config::StoreDurability::kPower
                    ? "the process and a power cut"
                    : "the process, not a power cut",
                store.max_waiting_mb);
}

void print_recovery(const config::RecoverySettings& recovery) {
    if (!recovery.on) {
        std::printf("recovery: none: a crash ends the world, and the next start begins anew\n");
        return;
    }
    std::printf(
        "recovery: a start after a crash goes on from the tick of the crash; a snapshot "
        "every %g s, inputs outlive %s%s\n",
        recovery.snapshot_every_s,
        recovery.durability == config::StoreDurability::kPower ? "the process and a power cut"
                                                               : "the process, not a power cut",
        recovery.over_restarts ? "; a stop in good order is gone on from too" : "");
}

void print_codec(const replication::ReplicationSettings& settings,
                 const replication::Replicator& replicator,
                 const replication::ReplicationReport& last) {
    switch (settings.codec) {
        case replication::Codec::kShared:
            std::printf("  codec: shared records, as configured\n");
            return;
        case replication::Codec::kPerClient:
            std::printf("  codec: records of each viewer coded for it alone, as configured\n");
            return;
        case replication::Codec::kAuto:
            break;
    }
    std::printf(
        "  codec: coded for %u viewers alone (%.1f of %u us a tick); shared for %u that are told "
        "too little at a time to gain (%.0f records a packet, %.0f %% of the downlink) and %u that "
        "there is no time for; measured: %.2f us a record, %.2f us a packet\n",
        last.codec.coded,
        1e-3 * last.codec.cost_ns,
        settings.codec_budget_us,
        last.codec.little_to_gain,
        static_cast<double>(replication::CodecPlan::kDense),
        1e2 * static_cast<double>(replication::CodecPlan::kShort),
        last.codec.beyond_budget,
        1e-3 * replicator.codec_price().record_ns,
        1e-3 * replicator.codec_price().packet_ns);
}

void print_zone(const config::ZoneRegion& region,
                const replication::ReplicationSettings& replication,
                const zone::Zone& zone,
                const zone::StepReport& last,
                const ZoneSums& sums,
                const PassForecast& expected,
                const std::vector<ErrorForecast>& errors) {
    const zone::Census& c = last.census;
    std::printf("\nzone %u %s  x %.0f..%.0f  z %.0f..%.0f m\n",
                static_cast<unsigned>(region.id.value),
                region.name.c_str(),
                region.min_x,
                region.max_x,
                region.min_z,
                region.max_z);
    std::printf(
        "  census: %u entities, %u ghosts, %u characters (%u moving), %u agents, %u bodies awake, "
        "%u of %u soft bodies awake, %u viewers\n",
        c.entities,
        c.ghosts,
        c.characters,
        c.moving_characters,
        c.agents,
        c.awake_bodies,
        c.awake_soft,
        c.soft_bodies,
        c.viewers);
    if (c.particle_systems > 0) {
        std::printf(
            "  particles: %u systems, %zu particles in the last tick, %u systems on a device\n",
            c.particle_systems,
            last.particles.particles,
            last.particles.on_device);
    }
    if (const ai::PathService& paths = zone.state().paths; !paths.empty()) {
        const ai::pathfinding::PathCounts w = paths.counts();
        std::printf(
            "  paths: over %s, %zu sizes of characters, %.1f MiB, %llu asked for (%llu straight), "
            "%u "
            "waiting, %llu cut by doors\n",
            name_of(zone.state().settings.ai.pathfinding.map),
            paths.sizes(),
            static_cast<double>(paths.bytes()) / 1048576.0,
            static_cast<unsigned long long>(w.asked),
            static_cast<unsigned long long>(w.straight),
            w.waiting,
            static_cast<unsigned long long>(w.broken));
    }
    if (c.viewers > 0) {
        print_codec(replication, zone.state().replicator, last.replication);
    }
    std::printf("  %-17s %-5s %10s %10s %10s %8s %10s  %s\n",
                "pass",
                "plan",
                "ran/ticks",
                "us/tick",
                "expected",
                "units",
                "error",
                "because");
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        const PassSums& t = sums.passes[p];
        const std::string name(zone::pass_name(static_cast<zone::Pass>(p)));
        const std::string reason(last.plan.reason[p]);
        const std::string error =
            last.plan.runs[p] ? error_of_pass(errors, static_cast<zone::Pass>(p)) : "-";
        std::printf("  %-17s %-5s %5.0f/%-4.0f %10.1f %10.1f %8.1f %10s  %s\n",
                    name.c_str(),
                    last.plan.runs[p] ? "run" : "skip",
                    t.ran,
                    sums.ticks,
                    t.ns * 1e-3 / sums.ticks,
                    1e-3 * std::max(expected[p], 0.0),
                    t.count / sums.ticks,
                    error.c_str(),
                    reason.c_str());
    }
}

/// Explains the actions of an NPC; false where no zone owns an entity of that id with an agent.
bool print_why(const config::Settings& settings, World& world, EntityId entity, Tick now) {
    for (const auto& zone : world.zones()) {
        const std::string text = agent_report(settings, *zone, entity, now);
        if (!text.empty()) {
            std::fputs(text.c_str(), stdout);
            return true;
        }
    }
    std::fprintf(stderr, "zoned: no entity %u with an agent is in the world\n", entity.value);
    return false;
}

/// A world that has just begun drops and settles what it holds, s: a forecast from then is none.
constexpr double kSettling_s = 6.0;

unsigned ticks_of(const config::Settings& settings, double seconds) {
    return static_cast<unsigned>(std::max(1.0, std::round(seconds * settings.tick_rate_hz)));
}

/// Lets the world settle, makes a forecast from as long a time as it then runs on, at least from
/// the ticks of the plan.
std::string analyze(const config::Settings& settings,
                    const ExplainArguments& arguments,
                    WorldProbe& probe) {
    probe.run(ticks_of(settings, kSettling_s));
    probe.clear();
    probe.run(std::max(arguments.ticks, ticks_of(settings, arguments.seconds)));
    const WorldForecast forecast = forecast_world(settings, probe);
    probe.clear();
    probe.run(ticks_of(settings, arguments.seconds));
    return arguments.json ? analysis_json(settings, forecast, probe)
                          : analysis_text(settings, forecast, probe);
}

}  // namespace

int explain(const ExplainArguments& arguments) {
    config::Settings settings;
    if (!load_or_complain(arguments.config, arguments.sets, settings)) {
        return kUsage;
    }
    ParticleDevice device = open_particle_device(settings, 1);  // outlives the world
    World world(settings, 1, &thread_cpu_ns);
    if (device.device) {
        world.use_device(device.device.get(), device.crossover, device.of_flocks);
    }
    const ProbeCrowd crowd{arguments.viewers, arguments.bots};
    WorldProbe probe(world, settings, crowd);
    std::optional<mailbox::CodecPrice> codec;
    if (settings.replication.codec == replication::Codec::kAuto) {
        codec = measure_codec();
        probe.give(*codec);
    }
    // The first ticks, in which things settle, are no measure of what follows.
    probe.run(arguments.ticks / 3);
    std::vector<ZoneSums> sums = probe.zones();
    probe.clear();
    probe.run(arguments.ticks - arguments.ticks / 3);
    for (std::size_t z = 0; z < sums.size(); ++z) {
        sums[z].add(probe.zones()[z]);
    }
    if (arguments.entity != 0) {
        return print_why(settings, world, EntityId(arguments.entity), world.now()) ? kGood : kUsage;
    }
    const WorldForecast forecast = forecast_world(settings, probe);
    if (arguments.json) {
        std::fputs(analyze(settings, arguments, probe).c_str(), stdout);
        return kGood;
    }
    std::printf(
        "plan of the last of %u ticks, with mean thread CPU time per tick (%u viewers), and what "
        "is "
        "expected of later ones\n",
        arguments.ticks,
        arguments.viewers + arguments.bots);
    print_particles(settings, device);
    for (std::size_t z = 0; z < sums.size(); ++z) {
        print_zone(settings.zones[z],
                   settings.replication,
                   *world.zones()[z],
                   world.zones()[z]->report(),
                   sums[z],
                   forecast.zones[z],
                   forecast.errors);
    }
    std::printf("\n%s", errors_text(settings, forecast).c_str());
    std::printf("\n%s", config::methods_text(settings).c_str());
    const std::string parameters = config::parameters_text(settings);
    if (!parameters.empty()) {
        std::printf("\n%s", parameters.c_str());
    }
    std::printf("\n%s\n", config::pathfinding_text(settings).c_str());
    print_store(settings.server.store);
    print_recovery(settings.server.recovery);
    const ProbedWorld own{
        arguments.config, arguments.sets, settings, crowd, arguments.ticks, sums, codec};
    std::printf("\n%s", other_budgets_text(own).c_str());
    if (arguments.analyze) {
        std::fputs(analyze(settings, arguments, probe).c_str(), stdout);
    }
    return kGood;
}

}  // namespace zoned::app
