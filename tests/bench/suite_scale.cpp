// Scale: what a tick of a world costs against its entities, zones and the share that is awake.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace zoned::bench {

namespace {

/// As many entities as one entry of a config may scatter.
constexpr int kMostInEntry = 100'000;

struct ScalePlan {
    std::string scene;
    std::string parameter;
    int asleep = 0;           ///< crates
    int awake = 0;            ///< walkers that are simulated in full
    int side = 1;             ///< zones along each side of the world
    double entity_m2 = 25.0;  ///< of the world, for each entity
    bool settles = false;     ///< the crates begin awake, and ticks count once they sleep
    bool corner = false;      ///< the same corner is awake and watched, in a world of one size
};

/// A crate on level ground sleeps after a second.
constexpr int kSettleTicks = 600;

/// The corner that is awake: walkers push crates before the eyes of players.
constexpr int kCornerThings = 150;  // walkers, and as many crates
constexpr int kCornerViewers = 3;
constexpr double kCorner_m = 100.0;      // its side
constexpr double kWorldHalf_m = 2600.0;  // of its world

/// `region`: as a config has it; empty: anywhere.
std::string scatters(const char* type, int count, bool asleep, const std::string& region = {}) {
    std::string text;
    for (int seed = 1; count > 0; count -= kMostInEntry, ++seed) {
        text += "scatter { type: \"" + std::string(type) +
                "\" count: " + std::to_string(std::min(count, kMostInEntry)) +
                " seed: " + std::to_string(seed) + region + (asleep ? " asleep: true }\n" : " }\n");
    }
    return text;
}

std::string region(double min_x, double min_z, double max_x, double max_z) {
    return " region { min_x_m: " + std::to_string(min_x) + " min_z_m: " + std::to_string(min_z) +
           " max_x_m: " + std::to_string(max_x) + " max_z_m: " + std::to_string(max_z) + " }";
}

/// The corner first, so that its entities have the same ids in each of these worlds.
std::string corner_scatters(int asleep) {
    const double low = -kWorldHalf_m + 1.0;
    const double end = -kWorldHalf_m + kCorner_m;
    const std::string awake = region(low, low, end, end);
    // Nothing of the sleepers within hearing.
    const double high = kWorldHalf_m - 1.0;
    return scatters("walker", kCornerThings, false, awake) +
           scatters("crate", kCornerThings, false, awake) +
           scatters("crate", asleep, true, region(low, end + 100.0, high, high));
}

/// A level world, as a game designer would write it.
std::string scale_config(const ScalePlan& plan) {
    const int entities = plan.asleep + plan.awake;
    const double half =
        plan.corner ? kWorldHalf_m : std::max(50.0, 0.5 * std::sqrt(plan.entity_m2 * entities));
    const std::string low = std::to_string(-half);
    const std::string high = std::to_string(half);
    return "world { name: \"scale\" seed: 7 min_x_m: " + low + " min_z_m: " + low +
           " max_x_m: " + high + " max_z_m: " + high +
           " }\nzones { zone_grid { columns: " + std::to_string(plan.side) +
           " rows: " + std::to_string(plan.side) +
           " } }\nai { suspend_offscreen: false }\n"
           "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: "
           "80 "
           "aura_m { normal: 30 } nimbus_m { normal: 30 } character { } }\n"
           "type { name: \"crate\" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } mass_kg: 15 "
           "aura_m { normal: 30 } }\n"
           "type { name: \"walker\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: "
           "70 "
           "aura_m { normal: 30 } character { speed_mps: 1.5 } brain: \"walk\" }\n"
           "brain { name: \"walk\" state { name: \"walk\" action: WANDER radius_m: 15 } }\n" +
           (plan.corner ? corner_scatters(plan.asleep)
                        : scatters("crate", plan.asleep, !plan.settles) +
                              scatters("walker", plan.awake, false)) +
           "replication { quantization { horizontal_extent_m: 4096 } }\n"
           "session { dev_mode_loopback: true }\nspawn { x_m: 0 z_m: 0 }\nlod { position_bound_m: "
           "0.05 orientation_bound_rad: 0.1 }\n";
}

config::Settings scale_settings(const ScalePlan& plan) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    const bool good = config::parse_settings(scale_config(plan), {}, settings, errors);
    if (!good) {
        throw std::runtime_error(
            "scale: " + (errors.empty() ? "no config" : errors[0].path + ": " + errors[0].text));
    }
    return settings;
}

std::vector<mailbox::InboxItem> corner_joins() {
    std::vector<mailbox::InboxItem> items;
    for (std::uint32_t client = 1; client <= kCornerViewers; ++client) {
        mailbox::Join join;
        join.client = ClientId(client);
        join.name = "viewer " + std::to_string(client);
        join.placed = true;
        join.spawn[0] = join.spawn[2] = -kWorldHalf_m + 20.0 * client;
        items.emplace_back(join);
    }
    return items;
}

/// Ticks by CPU time of the caller, who does all of the work.
void run_scale(Session& session, const ScalePlan& plan) {
    session.progress("scale " + plan.scene + " " + plan.parameter);
    const config::Settings settings = scale_settings(plan);
    app::World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    const auto tick = [&world, &out] {
        const std::int64_t before = thread_cpu_ns();
        world.tick({}, out);
        const auto spent = static_cast<double>(thread_cpu_ns() - before) - clock_cost_ns();
        out.clear();
        return std::max(spent, 0.0) * 1e-3;
    };
    if (plan.corner) {
        world.tick(corner_joins(), out);
        out.clear();
    }
    for (int i = 0; i < (session.quick ? 5 : 60); ++i) {
        tick();
    }
    for (int i = 0; plan.settles && !world.idle(); ++i) {
        if (i > kSettleTicks) {
            throw std::runtime_error("scale: crates do not come to rest");
        }
        tick();
    }
    std::vector<double> us;
    const double enough = session.quick ? 20e3 : 2e6;
    for (double sum = 0.0; us.size() < 20 || (sum < enough && us.size() < 2000); sum += us.back()) {
        us.push_back(tick());
    }
    std::size_t awake = 0;
    std::size_t entities = 0;
    std::size_t ghosts = 0;
    for (const auto& zone : world.zones()) {
        const zone::Census& census = zone->report().census;
        awake += census.moving_characters + census.awake_bodies;
        entities += census.entities;
        ghosts += census.ghosts;
    }
    Row row;
    row.suite = "scale";
    row.scene = plan.scene;
    row.parameter = plan.parameter;
    row.time_us_p50 = median(us);
    row.time_us_p99 = quantile(us, 0.99);
    row.metric("entities", static_cast<double>(entities));
    row.metric("ghosts", static_cast<double>(ghosts));
    row.metric("awake", static_cast<double>(awake));
    row.metric("walkers", plan.corner ? kCornerThings : plan.awake);
    row.metric("ticks", static_cast<double>(us.size()));
    row.metric("idle", world.idle() ? 1.0 : 0.0);
    row.metric("ns_per_entity",
               entities == 0 ? 0.0 : 1e3 * row.time_us_p50 / static_cast<double>(entities));
    session.add({row});
}

std::string entities_text(int count) {
    return "entities=" + std::to_string(count);
}

std::vector<ScalePlan> scale_plans(bool quick) {
    std::vector<ScalePlan> plans{{"empty", "", 0, 0, 1}};
    std::vector<int> sizes{100, 300, 1000};
    if (!quick) {
        sizes.insert(sizes.end(), {10'000, 100'000});
    }
    for (const int n : sizes) {
        plans.push_back({"asleep", entities_text(n), n, 0, 1});
        plans.push_back({"settled", entities_text(n), n, 0, 1, 25.0, true});
        plans.push_back({"awake_tenth", entities_text(n), n - n / 10, n / 10, 1});
        if (n <= 10'000) {
            plans.push_back({"awake", entities_text(n), 0, n, 1});
        }
    }
    if (!quick) {
        plans.push_back({"asleep", entities_text(1'000'000), 1'000'000, 0, 1});
    }
    for (const int asleep :
         quick ? std::vector<int>{0, 1000, 3000} : std::vector<int>{0, 10'000, 100'000, 999'000}) {
        plans.push_back(
            {"corner", "asleep=" + std::to_string(asleep), asleep, 0, 1, 0.0, false, true});
    }
    const int n = quick ? 1000 : 10'000;
    for (const int side : {1, 2, 4}) {
        plans.push_back(
            {"zones", "zones=" + std::to_string(side * side), n - n / 10, n / 10, side, 400.0});
    }
    for (const int share : {1, 3, 10, 30, 100}) {
        const int awake = n * share / 100;
        plans.push_back({"share", "awake=" + std::to_string(awake), n - awake, awake, 1});
    }
    return plans;
}

void run_scales(Session& session) {
    session.note(
        "scale: a tick of a whole world, one thread; walkers are "
        "simulated in full, crates lie asleep, 25 m2 for each (zones: 400 m2); in `corner` 150 "
        "walkers push 150 crates before three players, and all else sleeps; no error is measured");
    if (!session.wants_method("default", "")) {
        return;
    }
    for (const ScalePlan& plan : scale_plans(session.quick)) {
        if (session.wants_scene(plan.scene)) {
            run_scale(session, plan);
        }
    }
}

const Registration kScale(
    {"scale",
     "a whole world's tick against its entities, zones and awake share",
     {"empty", "asleep", "settled", "awake_tenth", "awake", "corner", "zones", "share"},
     {"default"},
     run_scales});

}  // namespace

}  // namespace zoned::bench
