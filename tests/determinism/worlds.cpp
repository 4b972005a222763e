#include "client-sim/app/swarm.h"
#include "server/app/world/world.h"
#include "tests/determinism/hashes.h"
#include "tests/harness/virtual_server.h"

#include <bit>
#include <cstdio>

namespace zoned::determinism {

std::string hex(unsigned long long value) {
    char text[17];
    std::snprintf(text, sizeof(text), "%016llx", value);
    return text;
}

std::vector<Line> world_lines(const std::string& name, std::size_t bot_count, unsigned threads) {
    harness::VirtualServerSettings server;
    server.config = ZONED_SOURCE_DIR "/config/" + name + ".txtpb";
    server.network.loss = 0.03;
    server.network.delay_s = 0.03;
    server.network.jitter_s = 0.01;
    server.threads = threads;
    app::SwarmSettings bots;
    bots.bots = bot_count;
    bots.seconds = 10.0;
    harness::VirtualServer world(server);
    app::Swarm swarm(bots, [&](std::size_t) { return world.connect(); });
    std::vector<Line> lines;
    Tick printed = 0;
    while (!swarm.done()) {
        world.step();
        swarm.advance(world.client_time_s());
        const Tick now = world.world().now();
        if (now % 60 != 0 || now == printed) {
            continue;
        }
        printed = now;
        for (const auto& zone : world.world().zones()) {
            lines.push_back({name + "/zone " + std::to_string(zone->state().settings.id.value),
                             "tick " + std::to_string(now),
                             hex(zone->state_hash())});
        }
    }
    const measure::RunReport report = swarm.report();
    const auto exact = [](double value) {
        return hex(std::bit_cast<std::uint64_t>(value));
    };
    const std::string clients = name + "/clients";
    lines.push_back({clients, "samples", std::to_string(report.audit.samples)});
    lines.push_back({clients, "greatest error", exact(report.audit.displayed_m.max())});
    lines.push_back({clients, "events", std::to_string(report.events_delivered)});
    lines.push_back({clients, "verdict", report.consistent ? "consistent" : "not"});
    return lines;
}

}  // namespace zoned::determinism
