#include "tests/bench/npc_zone.h"

#include "server/config/expand/load_settings.h"
#include "tests/bench/cpu_clock.h"

#include <algorithm>
#include <stdexcept>

namespace zoned::bench {

namespace {

/// In the order of the config's scatters: fishers, farmers, porters, pilgrims, guards, mayflies;
/// one each of hounds, children and deer.
constexpr std::array kShares = {0.3, 0.3, 0.06, 0.2, 0.04, 0.1, 0.0, 0.0, 0.0};
/// At the density of the town with its ten thousand, people could not be placed.
constexpr int kPlain = 10'000;
constexpr int kSpawns = 5;  ///< of the config

std::uint64_t cpu_now() {
    return static_cast<std::uint64_t>(thread_cpu_ns());
}

std::vector<std::string> sets_of(const NpcZone::Plan& plan) {
    std::vector<std::string> sets = {
        "zones.zone_grid.columns=1",
        "zones.zone_grid.rows=1",
        "ai.dawn_s=60",
        std::string("ai.suspend_offscreen=") + (plan.suspend_offscreen ? "true" : "false")};
    for (std::size_t k = 0; k < kShares.size(); ++k) {
        const std::string scatter = "scatter[" + std::to_string(k) + "]";
        sets.push_back(scatter + ".count=" +
                       std::to_string(std::max(1, static_cast<int>(kShares[k] * plan.people))));
        if (plan.people > kPlain) {
            sets.push_back(scatter + ".min_distance_m=0.1");
        }
    }
    // Beyond the homes of pilgrims: some of them come as near as this.
    for (int k = 0; k < kSpawns; ++k) {
        const std::string spawn = "spawn[" + std::to_string(k) + "]";
        sets.push_back(spawn + ".x_m=-570");
        sets.push_back(spawn + ".z_m=-570");
    }
    return sets;
}

}  // namespace

NpcZone::NpcZone(const Plan& plan) : people_(plan.people) {
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(
            ZONED_SOURCE_DIR "/config/town.txtpb", sets_of(plan), settings_, errors)) {
        throw std::runtime_error("config/town.txtpb: " +
                                 (errors.empty() ? "unreadable" : errors.front().text));
    }
    world_ = std::make_unique<app::World>(settings_, 1, cpu_now);
    if (plan.viewer) {
        mailbox::Join join;
        join.client = ClientId(1);
        join.name = "viewer";
        in_.emplace_back(join);
    }
}

void NpcZone::tick() {
    world_->tick(in_, out_);
    in_.clear();
    out_.clear();
}

void NpcZone::settle(int ticks) {
    for (int t = 0; t < ticks; ++t) {
        tick();
    }
}

/// Of all people.
NpcZoneCost NpcZone::measured_tick() {
    NpcZoneCost cost;
    const std::uint64_t begin = cpu_now();
    tick();
    cost.ns = static_cast<double>(cpu_now() - begin);
    const zone::StepReport& report = world_->zones().front()->report();
    cost.rest_ns = cost.ns;
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        cost.pass_ns[p] = static_cast<double>(report.passes[p].ns);
        cost.rest_ns -= cost.pass_ns[p];
    }
    cost.active = report.ai.active;
    cost.events_per_tick = report.ai.events;
    return cost;
}

NpcZoneCost NpcZone::mean(std::span<const NpcZoneCost> ticks) const {
    NpcZoneCost mean;
    const auto count = static_cast<double>(ticks.size());
    for (const NpcZoneCost& tick : ticks) {
        mean.ns += tick.ns / (count * people_);
        mean.rest_ns += tick.rest_ns / (count * people_);
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            mean.pass_ns[p] += tick.pass_ns[p] / (count * people_);
        }
        mean.active += tick.active / count;
        mean.events_per_tick += tick.events_per_tick / count;
    }
    return mean;
}

NpcZoneCost NpcZone::run(int ticks) {
    return day(ticks, ticks).mean;
}

NpcZoneDay NpcZone::day(int ticks, int stretch) {
    std::vector<NpcZoneCost> costs;
    costs.reserve(static_cast<std::size_t>(ticks));
    for (int t = 0; t < ticks; ++t) {
        costs.push_back(measured_tick());
    }
    const auto length = static_cast<std::size_t>(std::min(ticks, stretch));
    std::size_t busiest = 0;
    double events = 0.0;
    double most = 0.0;
    for (std::size_t t = 0; t < costs.size(); ++t) {
        events +=
            costs[t].events_per_tick - (t >= length ? costs[t - length].events_per_tick : 0.0);
        if (t + 1 >= length && events > most) {
            most = events;
            busiest = t + 1 - length;
        }
    }
    return {mean(costs), mean(std::span(costs).subspan(busiest, length))};
}

}  // namespace zoned::bench
