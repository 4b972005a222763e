#include "server/app/planner/world_probe.h"
#include "server/app/runtime/tick_loop.h"
#include "tests/bench/planner_worlds.h"
#include "tests/bench/suite_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace zoned::bench {

namespace {

constexpr std::uint64_t kFitSeed = 7;
constexpr int kSweeps = 20'000;  ///< over the prices of a pass

/// Means over the runs of a pass in one zone and window.
struct CostSample {
    config::PassUnits units{};
    double ns = 0.0;
};

using CostSamples = std::array<std::vector<CostSample>, zone::kPasses>;

void sample(const PlannerWorld& world,
            const app::ProbeCrowd& crowd,
            bool quick,
            CostSamples& samples,
            std::vector<double>& speeds) {
    const config::Settings settings = settings_of(world, {});
    app::World running(settings, 1, &app::thread_cpu_ns);
    app::WorldProbe probe(running, settings, crowd);
    probe.run(15);
    for (int window = 0; window < (quick ? 1 : 4); ++window) {
        probe.clear();
        probe.run(quick ? 10 : 25);
        speeds.push_back(probe.speed());
        for (const app::ZoneSums& zone : probe.zones()) {
            for (std::size_t p = 0; p < zone::kPasses; ++p) {
                const app::PassSums& pass = zone.passes[p];
                if (pass.ran <= 0.0 || pass.ns <= 0.0) {
                    continue;
                }
                CostSample one{pass.units, pass.ns / pass.ran / probe.speed()};
                for (double& unit : one.units) {
                    unit /= pass.ran;
                }
                samples[p].push_back(one);
            }
        }
    }
}

/// Prices p >= 0 that make sum over samples of (units p / ns - 1)^2 least, by coordinates
/// (Lawson and Hanson's problem; it is convex, so that sweeps find its least value).
std::array<double, config::kUnitKinds> fit(const std::vector<CostSample>& samples) {
    constexpr std::size_t kKinds = config::kUnitKinds;
    std::array<std::array<double, kKinds>, kKinds> a{};
    std::array<double, kKinds> b{};
    for (const CostSample& s : samples) {
        for (std::size_t i = 0; i < kKinds; ++i) {
            b[i] += s.units[i] / s.ns;
            for (std::size_t j = 0; j < kKinds; ++j) {
                a[i][j] += s.units[i] * s.units[j] / (s.ns * s.ns);
            }
        }
    }
    std::array<double, kKinds> price{};
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        for (std::size_t i = 0; i < kKinds; ++i) {
            if (a[i][i] <= 0.0) {
                continue;
            }
            double rest = b[i];
            for (std::size_t j = 0; j < kKinds; ++j) {
                rest -= j == i ? 0.0 : a[i][j] * price[j];
            }
            price[i] = std::max(0.0, rest / a[i][i]);
        }
    }
    return price;
}

double rms(const std::vector<CostSample>& samples,
           const std::array<double, config::kUnitKinds>& price) {
    double sum = 0.0;
    for (const CostSample& s : samples) {
        double ns = 0.0;
        for (std::size_t k = 0; k < config::kUnitKinds; ++k) {
            ns += price[k] * s.units[k];
        }
        sum += std::pow(ns / s.ns - 1.0, 2.0);
    }
    return samples.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(samples.size()));
}

}  // namespace

void run_planner_costs(Session& session) {
    std::vector<PlannerWorld> worlds = generated_worlds(kFitSeed);
    if (!session.quick) {
        const std::vector<PlannerWorld> shipped = all_shipped_worlds();
        worlds.insert(worlds.end(), shipped.begin(), shipped.end());
    }
    CostSamples samples;
    std::vector<double> speeds;
    for (const PlannerWorld& world : worlds) {
        session.progress("planner costs " + world.name);
        for (const app::ProbeCrowd& crowd :
             {app::ProbeCrowd{0, 0}, app::ProbeCrowd{4, 4}, app::ProbeCrowd{0, 24}}) {
            sample(world, crowd, session.quick, samples, speeds);
        }
    }
    std::sort(speeds.begin(), speeds.end());
    session.note("planner costs: this machine takes " + std::to_string(speeds[speeds.size() / 2]) +
                 " of the reference machine's time (median)");
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        if (samples[p].empty()) {
            continue;
        }
        const auto pass = static_cast<zone::Pass>(p);
        const config::PassCost& table = config::cost_of(pass);
        const std::array<double, config::kUnitKinds> price = fit(samples[p]);
        double mean_ns = 0.0;
        for (const CostSample& s : samples[p]) {
            mean_ns += s.ns / static_cast<double>(samples[p].size());
        }
        Row row;
        row.suite = "planner";
        row.scene = std::string("costs_") + std::string(zone::pass_name(pass));
        row.time_us_p50 = 1e-3 * mean_ns;
        row.time_us_p99 = 1e-3 * mean_ns;
        row.error = rms(samples[p], table.ns);
        row.error_unit = "of the cost, by the table";
        row.metric("error_fitted_share", rms(samples[p], price));
        row.metric("samples", static_cast<double>(samples[p].size()));
        for (std::size_t k = 0; k < config::kUnitKinds; ++k) {
            if (!table.unit[k].empty()) {
                std::string unit(table.unit[k]);
                std::replace(unit.begin(), unit.end(), ' ', '_');
                row.metric(unit + "_fitted_ns", price[k]);
                row.metric(unit + "_table_ns", table.ns[k]);
            }
        }
        session.add({row});
    }
}

}  // namespace zoned::bench
