// Suite `worlds`: what the players of each shipped world see, against what its server spends on it.
#include "client-sim/app/swarm.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"
#include "tests/harness/virtual_server.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace zoned::bench {

namespace {

/// The shipped worlds that run alone, each at its own population.
const std::vector<std::string> kWorlds = {"minimal",
                                          "arena",
                                          "bridge",
                                          "circuit",
                                          "cloth",
                                          "cubes",
                                          "doors",
                                          "hamlet",
                                          "hills",
                                          "learned",
                                          "machines",
                                          "solids",
                                          "weather",
                                          "city",
                                          "town",
                                          "valley"};

/// Small ones, for a quick run.
const std::vector<std::string> kQuickWorlds = {"minimal", "arena", "bridge"};

/// What the world's bounds of position and orientation are multiplied by.
struct BoundFactor {
    const char* method = "";
    double factor = 1.0;
};

constexpr BoundFactor kFactors[] = {{"bounds_x_1/4", 0.25},
                                    {"bounds_x_1/2", 0.5},
                                    {"default", 1.0},
                                    {"bounds_x_2", 2.0},
                                    {"bounds_x_4", 4.0}};

std::string file_of(const std::string& world) {
    return ZONED_SOURCE_DIR "/config/" + world + ".txtpb";
}

std::string text_of_number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

/// The world's levels of detail with other bounds; of a world with budgets, these, from which its
/// bounds follow.
std::vector<std::string> scaled_bounds(const std::string& world, double factor) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(file_of(world), {}, settings, errors)) {
        throw std::runtime_error("worlds: " + config::format_errors(world, errors));
    }
    std::vector<std::string> sets;
    if (factor == 1.0) {
        return sets;
    }
    if (const config::WorldBudgets& budgets = settings.budgets; budgets.position_m > 0.0) {
        return {"budget.position_m=" + text_of_number(factor * budgets.position_m),
                "budget.orientation_rad=" +
                    text_of_number(std::min(3.2, factor * budgets.orientation_rad))};
    }
    for (std::size_t k = 0; k < settings.replication.lods.size(); ++k) {
        const std::string at = "lod[" + std::to_string(k) + "].";
        const auto& lod = settings.replication.lods[k];
        sets.push_back(at + "position_bound_m=" +
                       text_of_number(factor * static_cast<double>(lod.position_m)));
        sets.push_back(
            at + "orientation_bound_rad=" +
            text_of_number(std::min(3.2, factor * static_cast<double>(lod.orientation_rad))));
    }
    return sets;
}

/// Empty, or why a config cannot ask for the world's bounds times the factor: finer than the
/// finest.
std::string refusal(const std::string& world, double factor) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    return config::load_settings(file_of(world), scaled_bounds(world, factor), settings, errors)
               ? ""
               : errors.front().path + ": " + errors.front().text;
}

struct TrialSettings {
    std::string world;
    BoundFactor factor;
    std::size_t bots = 0;
    double seconds = 0.0;
};

/// Server, bots and paths in one process, on virtual time: errors and bytes repeat to the bit.
class WorldTrial {
  public:
    explicit WorldTrial(const TrialSettings& trial) {
        harness::VirtualServerSettings server;
        server.config = file_of(trial.world);
        server.sets = scaled_bounds(trial.world, trial.factor.factor);
        server.network.delay_s = 0.03;
        server_ = std::make_unique<harness::VirtualServer>(server);
        app::SwarmSettings bots;
        bots.bots = trial.bots;
        bots.seconds = trial.seconds;
        bots.audit_every_s = 0.25;
        bots.freeze = false;
        bots.path_spread_s = server.network.spread_s();
        swarm_ =
            std::make_unique<app::Swarm>(bots, [this](std::size_t) { return server_->connect(); });
        limit_s_ = trial.seconds + 120.0;
    }

    measure::RunReport run() {
        while (!swarm_->done()) {
            step();
            swarm_->advance(server_->client_time_s());
            if (server_->now_s() > limit_s_) {
                throw std::runtime_error("worlds: the bots do not come to their end");
            }
        }
        return swarm_->report();
    }

    /// Of the server, for each tick of the run itself: world, sessions and sealing, and the paths
    /// of the datagrams that a tick sends.
    [[nodiscard]] const std::vector<double>& tick_us() const { return tick_us_; }

  private:
    void step() {
        const Tick before = server_->world().now();
        const std::int64_t begin = thread_cpu_ns();
        server_->step();
        const auto spent = static_cast<double>(thread_cpu_ns() - begin) - clock_cost_ns();
        if (server_->world().now() != before && swarm_->phase() == app::Swarm::RunPhase::kRun) {
            tick_us_.push_back(std::max(0.0, spent) * 1e-3);
        }
    }

    std::unique_ptr<harness::VirtualServer> server_;
    std::unique_ptr<app::Swarm> swarm_;  // its transports lead to the server
    double limit_s_ = 0.0;
    std::vector<double> tick_us_;
};

Row run_trial(const TrialSettings& settings) {
    WorldTrial trial(settings);
    const measure::RunReport report = trial.run();
    if (report.bots_joined != settings.bots || report.audit.displayed_m.count() == 0 ||
        report.down_bytes_per_s.count() == 0 || trial.tick_us().empty()) {
        throw std::runtime_error("worlds: nothing was seen or counted in " + settings.world);
    }
    Row row;
    row.suite = "worlds";
    row.scene = settings.world;
    row.method = settings.factor.method;
    row.time_us_p50 = median(trial.tick_us());
    row.time_us_p99 = quantile(trial.tick_us(), 0.99);
    row.error = report.audit.displayed_m.percentile(0.99);
    row.error_unit = "m";
    row.metric("displayed_p50_m", report.audit.displayed_m.percentile(0.5));
    row.metric("displayed_p99_m", report.audit.displayed_m.percentile(0.99));
    row.metric("predicted_p50_m", report.audit.predicted_m.percentile(0.5));
    row.metric("predicted_p99_m", report.audit.predicted_m.percentile(0.99));
    row.metric("wire_bytes_per_s", report.down_bytes_per_s.mean());
    row.metric("bound_violations", static_cast<double>(report.audit.position_violations));
    row.metric("samples", static_cast<double>(report.audit.samples));
    row.metric("clients", static_cast<double>(settings.bots));
    row.metric("ticks", static_cast<double>(trial.tick_us().size()));
    return row;
}

void run_worlds(Session& session) {
    session.note(
        "worlds: the error is the position that players see displayed against the truth, p99; the "
        "time is the server's CPU for a tick, world and sessions, one thread; wire_bytes_per_s are "
        "those of one client, headers counted; 30 ms one way, no loss; the method multiplies the "
        "bounds of position and orientation of all levels of detail");
    for (const std::string& world : session.quick ? kQuickWorlds : kWorlds) {
        if (!session.wants_scene(world)) {
            continue;
        }
        std::vector<Row> rows;
        for (const BoundFactor& factor : kFactors) {
            if (!session.wants_method(factor.method, "")) {
                continue;
            }
            session.progress("worlds " + world + " " + factor.method);
            const std::string why = refusal(world, factor.factor);
            if (!why.empty()) {
                session.note("worlds " + world + " " + factor.method + ": skipped, " + why);
                continue;
            }
            rows.push_back(run_trial({world,
                                      factor,
                                      session.quick ? std::size_t{4} : std::size_t{16},
                                      session.quick ? 6.0 : 15.0}));
        }
        session.add(std::move(rows));
    }
}

const Registration kWorldsSuite(
    {"worlds",
     "what players of each shipped world see, against CPU and bytes",
     kWorlds,
     {"default", "bounds_x_1/4", "bounds_x_1/2", "bounds_x_2", "bounds_x_4"},
     run_worlds});

}  // namespace

}  // namespace zoned::bench
