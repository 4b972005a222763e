#include "tests/network_matrix/cell.h"

#include "client-sim/app/swarm.h"
#include "tests/harness/virtual_server.h"

#include <array>
#include <cstdio>
#include <stdexcept>

namespace zoned::network_matrix {

namespace {

constexpr std::array<double, 6> kLosses = {0.0, 0.01, 0.05, 0.10, 0.20, 0.30};
constexpr std::array<double, 3> kJitters_s = {0.0, 0.033, 0.100};
constexpr double kDuplicate = 0.05;
constexpr double kReorder = 0.10;
constexpr double kOutageEvery_s = 2.0;
constexpr double kOutageLength_s = 0.25;
constexpr double kFrozenAudit_s = 0.1;

}  // namespace

std::vector<Cell> all_cells() {
    std::vector<Cell> cells;
    for (const double loss : kLosses) {
        for (const double jitter_s : kJitters_s) {
            for (int bits = 0; bits < 8; ++bits) {
                cells.push_back({loss,
                                 jitter_s,
                                 (bits & 1) != 0 ? kDuplicate : 0.0,
                                 (bits & 2) != 0 ? kReorder : 0.0,
                                 (bits & 4) != 0});
            }
        }
    }
    return cells;
}

std::vector<Cell> pairwise_cells() {
    // Each loss meets each jitter once, which gives 18 rows. Three columns of two settings go over
    // them: per jitter (six rows, one for each loss) and per loss (three rows) each setting occurs,
    // and any two columns show all four combinations.
    static constexpr std::array<std::array<int, 3>, 6> kTwoWay = {
        {{0, 3, 5}, {7, 4, 2}, {1, 6, 4}, {6, 1, 3}, {2, 5, 7}, {5, 0, 6}}};
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < kLosses.size(); ++i) {
        for (std::size_t j = 0; j < kJitters_s.size(); ++j) {
            const int bits = kTwoWay[i][j];
            cells.push_back({kLosses[i],
                             kJitters_s[j],
                             (bits & 1) != 0 ? kDuplicate : 0.0,
                             (bits & 2) != 0 ? kReorder : 0.0,
                             (bits & 4) != 0});
        }
    }
    return cells;
}

link::ConditionerSettings network_of(const Cell& cell, std::uint64_t seed) {
    link::ConditionerSettings network;
    network.delay_s = 0.02 + cell.jitter_s;
    network.jitter_s = cell.jitter_s;
    network.loss = cell.loss;
    network.duplicate = cell.duplicate;
    network.reorder = cell.reorder;
    if (cell.outages) {
        network.outage_every_s = kOutageEvery_s;
        network.outage_length_s = kOutageLength_s;
    }
    network.seed = seed;
    return network;
}

std::string name_of(const Cell& cell) {
    char text[120];
    std::snprintf(text,
                  sizeof(text),
                  "loss_%.0f_jitter_%.0f%s%s%s",
                  100.0 * cell.loss,
                  1000.0 * cell.jitter_s,
                  cell.duplicate > 0.0 ? "_duplicates" : "",
                  cell.reorder > 0.0 ? "_reordering" : "",
                  cell.outages ? "_outages" : "");
    return text;
}

CellResult run_cell(const Cell& cell, const CellSettings& settings) {
    harness::VirtualServerSettings server;
    server.config = settings.config;
    server.sets = settings.sets;
    server.network = network_of(cell, settings.seed);
    server.threads = settings.threads;
    harness::VirtualServer world(server);
    app::SwarmSettings bots;
    bots.bots = settings.bots;
    bots.path_spread_s = server.network.spread_s();
    bots.seconds = settings.seconds;
    bots.seed = settings.seed;
    bots.audit_every_s = 0.5;
    bots.freeze_wait_s = settings.heal_s;
    bots.frozen_audit_s = kFrozenAudit_s;
    app::Swarm swarm(bots, [&](std::size_t) { return world.connect(); });
    CellResult result;
    double healed_from_s = -1.0;
    while (!swarm.done()) {
        world.step();
        if (settings.each_step) {
            settings.each_step(world);
        }
        swarm.advance(world.client_time_s());
        if (swarm.phase() == app::Swarm::RunPhase::kFreeze && healed_from_s < 0.0) {
            healed_from_s = world.now_s();
            world.heal();
        }
        if (swarm.phase() == app::Swarm::RunPhase::kGoodbye && result.healed_s == 0.0 &&
            healed_from_s >= 0.0) {
            result.healed_s = world.now_s() - healed_from_s;
        }
        if (world.now_s() > settings.seconds + 60.0) {
            throw std::runtime_error(name_of(cell) + ": the swarm does not come to its end");
        }
    }
    result.report = swarm.report();
    result.healed = result.report.auditing_bots > 0 &&
                    result.report.converged_bots == result.report.auditing_bots;
    return result;
}

}  // namespace zoned::network_matrix
