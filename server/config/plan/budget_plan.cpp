#include "server/config/plan/budget_plan.h"

#include "server/config/plan/budget_load.h"
#include "server/config/plan/error_models.h"
#include "server/config/plan/pass_costs.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/replication/packer.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace zoned::config {

namespace {

using physics::method_selection::MethodChoice;
using proto::config::Config;

/// Shares of the position budget that are tried for the simulation; the rest is for the bound.
constexpr std::array kSimulationShares{1.0 / 32.0, 1.0 / 16.0, 0.125, 0.25, 0.5, 0.75};
constexpr std::array kTickRates_hz{10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 90.0, 120.0};
/// An input waits for up to one tick, and shows at the end of the next.
constexpr double kTicksToEffect = 2.0;
/// Agents beyond ai.far_m steer in every 4th tick.
constexpr double kFarTicks = 4.0;
/// A step of position is this share of the bound: its rounding stays below a tenth of it.
constexpr double kStepShare = 0.1;
constexpr double kQuantumShare = 0.125;  ///< of an orientation's bound, for its rounding
/// Far levels show their bound under the angle of the nearest level's bound at this share of its
/// radius.
constexpr double kNearShare = 0.25;
constexpr double kWidestTurn_rad = 1.0;
/// Part of the time of a tick that coding for single clients, and path finding, may take.
constexpr double kPartOfTick = 0.25;
constexpr double kWorkUnit_us = 0.002;
/// Bytes of a record that all clients share, and of one that is coded for a client, with its share
/// of headers.
constexpr double kSharedRecord_bytes = 14.0;
constexpr double kCodedRecord_bytes = 7.0;

double price(zone::Pass pass, std::string_view unit) {
    const PassCost& cost = cost_of(pass);
    for (std::size_t k = 0; k < kUnitKinds; ++k) {
        if (cost.unit[k] == unit) {
            return cost.ns[k];
        }
    }
    return 0.0;
}

/// Fills in the plans one after the other: time first, since the tick decides about the others.
class BudgetPlanner {
  public:
    BudgetPlanner(Config& config, Diagnostics& diagnostics)
        : config_(config),
          diagnostics_(diagnostics),
          load_(load_of(config)) {}

    std::vector<MethodPlan> run() {
        const auto& budget = config_.budget();
        if (budget.time_s() > 0.0) {
            plan_time(budget.time_s());
        }
        if (budget.position_m() > 0.0) {
            plan_position(budget.position_m());
            name_methods();
        }
        if (budget.orientation_rad() > 0.0) {
            plan_orientation(budget.orientation_rad());
        }
        if (budget.bytes_per_client_s() > 0.0) {
            plan_bytes(budget.bytes_per_client_s());
        }
        if (budget.position_m() > 0.0 || budget.bytes_per_client_s() > 0.0) {
            plan_codec();
        }
        if (budget.cpu_us_per_tick() > 0.0) {
            plan_cpu(budget.cpu_us_per_tick());
        }
        return std::move(plans_);
    }

  private:
    [[nodiscard]] double tick_s() const { return 1.0 / config_.world().tick_rate_hz(); }

    [[nodiscard]] double heartbeat_s() const {
        return config_.replication().heartbeat_ticks() * tick_s();
    }

    MethodPlan& add(std::string path, std::string used, std::string reason) {
        plans_.push_back({std::move(path), std::move(used), std::move(reason), {}});
        return plans_.back();
    }

    /// Sets a field by its accessors unless the config does.
    template <class Set>
    void fill(const std::string& path,
              bool has,
              double given,
              double value,
              const Set& set,
              const std::string& reason) {
        if (has) {
            add(path, text_of("%g", given), kAsConfigured);
            return;
        }
        set(value);
        add(path, text_of("%g", value), reason);
    }

    void plan_time(double budget_s);
    void plan_position(double budget_m);
    void plan_parts(double part_m, double bound_m);
    void plan_levels(double bound_m);
    void name_methods();
    void plan_orientation(double budget_rad);
    void plan_bytes(double budget);
    void plan_codec();
    void plan_cpu(double budget_us);
    [[nodiscard]] double contacts_ns(double budget_m) const;
    [[nodiscard]] double updates_ns(double bound_m) const;

    Config& config_;
    Diagnostics& diagnostics_;
    BudgetLoad load_;
    std::vector<MethodPlan> plans_;
};

/// Contact solves of a tick whose contacts may give by so much, ns.
double BudgetPlanner::contacts_ns(double budget_m) const {
    const int substeps =
        config_.physics().substeps() > 0
            ? static_cast<int>(config_.physics().substeps())
            : substeps_for(budget_m, kImpactLoad * load_.pile.load_mps2(), tick_s());
    return kAwakeShare * load_.bodies * kPointsOfContact * substeps *
           price(zone::Pass::kPhysics, "contact sweeps");
}

/// Publications of a tick within such a bound, and their copies for viewers, ns.
double BudgetPlanner::updates_ns(double bound_m) const {
    const double updates =
        tick_s() * publications_ps(bound_m, kMissed_mps2, heartbeat_s(), tick_s());
    const double movers = load_.movers + kAwakeShare * load_.bodies;
    return updates *
           (movers * price(zone::Pass::kReplication, "publications") +
            load_.viewers * load_.heard * price(zone::Pass::kReplication, "copied records"));
}

void BudgetPlanner::plan_time(double budget_s) {
    auto& world = *config_.mutable_world();
    MethodChoice choice{
        "world.tick_rate_hz",
        "s",
        budget_s,
        "two ticks from an input to its effect; cost of a second's ticks as a share "
        "of 1 us each",
        {},
        {}};
    std::vector<physics::method_selection::MethodOption> options;
    for (std::size_t r = 0; r < kTickRates_hz.size(); ++r) {
        const double rate = kTickRates_hz[r];
        if (!world.has_tick_rate_hz() || world.tick_rate_hz() == rate) {
            options.push_back({static_cast<int>(r), text_of("%g Hz", rate), 0, 0.0, "", [rate] {
                                   return physics::method_selection::MethodTrial{
                                       kTicksToEffect / rate, 1e3 * rate, 0.0};
                               }});
        }
    }
    const bool given = world.has_tick_rate_hz();
    if (given && kTicksToEffect / world.tick_rate_hz() > budget_s) {
        diagnostics_.add("world.tick_rate_hz",
                         text_of("two ticks are %.3g s: more than budget.time_s %g",
                                 kTicksToEffect / world.tick_rate_hz(),
                                 budget_s));
    }
    if (!given) {
        physics::method_selection::choose(choice, options);
        if (!choice.chosen) {
            diagnostics_.add(
                "budget.time_s",
                text_of("%g s is less than two ticks at %g Hz", budget_s, kTickRates_hz.back()));
            return;
        }
        world.set_tick_rate_hz(
            kTickRates_hz[static_cast<std::size_t>(choice.candidates[*choice.chosen].code)]);
    }
    add("world.tick_rate_hz",
        text_of("%g", world.tick_rate_hz()),
        given ? kAsConfigured : "the lowest rate that keeps budget.time_s");
    if (!given) {
        plans_.back().choice = std::move(choice);
    }
    auto& replication = *config_.mutable_replication();
    fill(
        "replication.silence_ticks",
        replication.has_silence_ticks(),
        replication.silence_ticks(),
        usual_silence_ticks(world.tick_rate_hz()),
        [&](double v) { replication.set_silence_ticks(static_cast<std::uint32_t>(v)); },
        "half a second at this tick rate, or the default");
    auto& ai = *config_.mutable_ai();
    fill(
        "ai.reduce_far",
        ai.has_reduce_far(),
        ai.reduce_far() ? 1.0 : 0.0,
        kFarTicks * tick_s() <= budget_s ? 1.0 : 0.0,
        [&](double v) { ai.set_reduce_far(v > 0.0); },
        "far agents steer every 4th tick where budget.time_s allows it");
}

void BudgetPlanner::plan_position(double budget_m) {
    auto& physics = *config_.mutable_physics();
    const bool contacts_given = physics.has_error_budget_m();
    const bool bound_given = config_.lod_size() > 0 && config_.lod(0).has_position_bound_m();
    // The sag of the tallest pile over the give of its most loaded contact, at most: edges and
    // corners give more than flat boxes.
    const double piled =
        pile_sag_m(load_.pile, 1, 1.0) / kFlatShare / contact_give_m(load_.pile.load_mps2(), 1.0);
    MethodChoice choice{"position",
                        "m",
                        budget_m,
                        text_of("sag of %g bodies on each other, and the bound of the nearest "
                                "level; costs of a tick with %g players",
                                load_.pile.bodies,
                                load_.viewers),
                        {},
                        {}};
    std::vector<physics::method_selection::MethodOption> options;
    std::vector<std::pair<double, double>> parts;  // of the simulation, of the bound
    const auto offer = [&](double part_m, double bound_m) {
        const int code = static_cast<int>(parts.size());
        parts.emplace_back(part_m, bound_m);
        options.push_back(
            {code,
             text_of("sag %.3g + bound %.3g", part_m, bound_m),
             0,
             0.0,
             "",
             [this, part_m, bound_m, piled] {
                 return physics::method_selection::MethodTrial{
                     part_m + bound_m, contacts_ns(part_m / piled) + updates_ns(bound_m), 0.0};
             }});
    };
    const double given_part = physics.error_budget_m() * piled;
    const double given_bound = bound_given ? config_.lod(0).position_bound_m() : 0.0;
    if (contacts_given || bound_given) {
        const double part = contacts_given ? given_part : budget_m - given_bound;
        offer(part, bound_given ? given_bound : budget_m - part);
    } else {
        for (const double share : kSimulationShares) {
            offer(share * budget_m, (1.0 - share) * budget_m);
        }
    }
    const auto [part, bound] = parts.front();
    if (part <= 0.0 || bound <= 0.0 || part + bound > budget_m * (1.0 + 1e-9)) {
        diagnostics_.add(
            bound_given ? "lod[0].position_bound_m" : "physics.error_budget_m",
            text_of(
                "leaves nothing of budget.position_m %g: contacts take %.3g m, the bound %.3g m",
                budget_m,
                contacts_given ? given_part : 0.0,
                given_bound));
        return;
    }
    choice.budget *= 1.0 + 1e-9;  // the parts add up but for rounding
    physics::method_selection::choose(choice, options);
    const auto [part_m, bound_m] =
        parts[static_cast<std::size_t>(choice.candidates[choice.chosen.value_or(0)].code)];
    add("position",
        text_of("sag %.3g m + bound %.3g m", part_m, bound_m),
        "the cheapest way to share it");
    plans_.back().choice = std::move(choice);
    fill(
        "physics.error_budget_m",
        contacts_given,
        physics.error_budget_m(),
        std::clamp(part_m / piled, 1e-5, 1.0),
        [&](double v) { physics.set_error_budget_m(v); },
        "the part of contacts, of which a pile has several");
    plan_parts(part_m, bound_m);
    plan_levels(bound_m);
    const double least_m = physics.error_budget_m() * piled + config_.lod(0).position_bound_m();
    if (least_m > budget_m * (1.0 + 1e-6)) {
        diagnostics_.add(
            "budget.position_m",
            text_of(
                "%g m cannot be kept: contacts and bound take at least %.3g m", budget_m, least_m));
    }
}

/// Budgets of the parts of the simulation.
void BudgetPlanner::plan_parts(double part_m, double bound_m) {
    auto& budget = *config_.mutable_budget();
    const auto& types = config_.type();
    const bool props = std::any_of(types.begin(), types.end(), [](const auto& type) {
        return type.kind() == proto::config::PROP && !type.has_soft();
    });
    if (props) {
        fill(
            "budget.free_flight_m",
            budget.has_free_flight_m(),
            budget.free_flight_m(),
            part_m,
            [&](double v) { budget.set_free_flight_m(v); },
            "the part of the simulation");
    }
    const bool simulated = std::any_of(config_.particles().begin(),
                                       config_.particles().end(),
                                       [](const auto& p) { return !p.cosmetic(); });
    if (simulated) {
        fill(
            "budget.particles_m",
            budget.has_particles_m(),
            budget.particles_m(),
            part_m + bound_m,
            [&](double v) { budget.set_particles_m(v); },
            "all of budget.position_m: particles are not sent");
    }
    double longest_m = 0.0;
    for (const auto& type : types) {
        const auto& soft = type.soft();
        longest_m = std::max(
            {longest_m,
             soft.has_cloth() ? std::max(soft.cloth().width_m(), soft.cloth().height_m()) : 0.0,
             soft.has_rope() ? soft.rope().length_m() : 0.0,
             soft.has_jelly() ? std::max({soft.jelly().size().x_m(),
                                          soft.jelly().size().y_m(),
                                          soft.jelly().size().z_m()})
                              : 0.0,
             soft.has_balloon() ? 2.0 * soft.balloon().radius_m() : 0.0});
    }
    if (longest_m > 0.0) {
        fill(
            "budget.soft_share",
            budget.has_soft_share(),
            budget.soft_share(),
            std::min(1.0, part_m / longest_m),
            [&](double v) { budget.set_soft_share(v); },
            text_of("the part of the simulation, of the longest soft body's %.3g m", longest_m));
    }
}

void BudgetPlanner::plan_levels(double bound_m) {
    if (config_.lod_size() == 0 && load_.nimbus_m > 0.0) {
        config_.add_lod()->set_radius_m(kNearShare * load_.nimbus_m);
        config_.add_lod();
        add("lod[0].radius_m",
            text_of("%g", kNearShare * load_.nimbus_m),
            "no level is configured: a quarter of the widest nimbus, and all beyond");
    } else if (config_.lod_size() == 0) {
        config_.add_lod();
    }
    double inner_m = 0.0;
    const double nearest_m = config_.lod(0).radius_m();
    for (int l = 0; l < config_.lod_size(); ++l) {
        auto& lod = *config_.mutable_lod(l);
        const double wider = l == 0 ? 1.0 : inner_m / (kNearShare * nearest_m);
        fill(
            join_path("", "lod", l) + ".position_bound_m",
            lod.has_position_bound_m(),
            lod.position_bound_m(),
            std::clamp(wider * bound_m, 1e-3, 100.0),
            [&](double v) { lod.set_position_bound_m(v); },
            l == 0 ? "the part of the bound"
                   : "seen under the angle of the nearest level's at a quarter of its radius");
        inner_m = lod.radius_m();
    }
    auto& q = *config_.mutable_replication()->mutable_quantization();
    fill(
        "replication.quantization.position_step_m",
        q.has_position_step_m(),
        q.position_step_m(),
        std::clamp(kStepShare * bound_m, 5e-4, 1.0),
        [&](double v) { q.set_position_step_m(v); },
        "a tenth of the nearest bound");
}

/// Methods that cost time and that no budget decides about, with the reason.
void BudgetPlanner::name_methods() {
    const auto& physics = config_.physics();
    add("physics.method",
        proto::config::ContactMethod_Name(physics.method()),
        physics.has_method() ? kAsConfigured
                             : "no other says how far off it will be: they end after so many "
                               "passes, DIRECT with islands beyond its rows");
    const auto& ai = config_.ai();
    if (ai.has_pathfinding() && ai.pathfinding().map() == proto::config::Pathfinding::GRID) {
        const auto& paths = ai.pathfinding();
        add("ai.pathfinding.search",
            proto::config::Pathfinding::Search_Name(paths.search()),
            paths.has_search() ? kAsConfigured : "shortest paths, which no other finds faster");
    }
    if (ai.has_avoidance()) {
        add("ai.avoidance.horizon_s",
            text_of("%g", ai.avoidance().horizon_s()),
            ai.avoidance().has_horizon_s() ? kAsConfigured
                                           : "the default: people overlap with none");
    }
}

void BudgetPlanner::plan_orientation(double budget_rad) {
    if (config_.lod_size() == 0) {
        config_.add_lod();
    }
    for (int l = 0; l < config_.lod_size(); ++l) {
        auto& lod = *config_.mutable_lod(l);
        const double wider = lod.position_bound_m() / config_.lod(0).position_bound_m();
        const double bound = std::min(budget_rad * wider, std::max(budget_rad, kWidestTurn_rad));
        fill(
            join_path("", "lod", l) + ".orientation_bound_rad",
            lod.has_orientation_bound_rad(),
            lod.orientation_bound_rad(),
            std::clamp(bound, 1e-3, 3.2),
            [&](double v) { lod.set_orientation_bound_rad(v); },
            l == 0 ? "all of budget.orientation_rad" : "wider as its bound of position is");
    }
    if (config_.lod(0).orientation_bound_rad() > budget_rad * (1.0 + 1e-9)) {
        diagnostics_.add("lod[0].orientation_bound_rad",
                         text_of("%g rad is more than budget.orientation_rad %g",
                                 config_.lod(0).orientation_bound_rad(),
                                 budget_rad));
    }
    int bits = 5;
    while (bits < 15 && orientation_quantum_rad(bits) > kQuantumShare * budget_rad) {
        ++bits;
    }
    auto& q = *config_.mutable_replication()->mutable_quantization();
    fill(
        "replication.quantization.orientation_bits",
        q.has_orientation_bits(),
        q.orientation_bits(),
        bits,
        [&](double v) { q.set_orientation_bits(static_cast<std::uint32_t>(v)); },
        "the fewest whose rounding takes an eighth of the bound");
    fill(
        "replication.quantization.yaw_bits",
        q.has_yaw_bits(),
        q.yaw_bits(),
        bits,
        [&](double v) { q.set_yaw_bits(static_cast<std::uint32_t>(v)); },
        "as orientation_bits");
}

void BudgetPlanner::plan_bytes(double budget) {
    auto& replication = *config_.mutable_replication();
    fill(
        "replication.budget_bytes_per_s",
        replication.has_budget_bytes_per_s(),
        replication.budget_bytes_per_s(),
        std::clamp(budget, 1e3, 1e7),
        [&](double v) { replication.set_budget_bytes_per_s(static_cast<std::uint32_t>(v)); },
        "all of budget.bytes_per_client_s");
    if (replication.budget_bytes_per_s() > budget * (1.0 + 1e-9)) {
        diagnostics_.add("replication.budget_bytes_per_s",
                         text_of("%g is more than budget.bytes_per_client_s %g",
                                 replication.budget_bytes_per_s(),
                                 budget));
    }
}

/// The cheapest codec whose bytes fit into what each client may get.
void BudgetPlanner::plan_codec() {
    auto& replication = *config_.mutable_replication();
    const double budget = replication.budget_bytes_per_s();
    const double bound = config_.lod_size() > 0 ? config_.lod(0).position_bound_m()
                                                : proto::config::Lod().position_bound_m();
    const double updates =
        load_.heard * publications_ps(bound, kMissed_mps2, heartbeat_s(), tick_s());
    const double datagrams = static_cast<double>(replication::kPacketOverheadBytes) *
                             std::min(std::max(updates, 2.0), config_.world().tick_rate_hz());
    MethodChoice choice{
        "replication.codec",
        "bytes/s",
        budget,
        text_of("%.3g records a second for each of %g players", updates, load_.viewers),
        {},
        {}};
    const auto option = [&](proto::config::Codec codec, const char* name, double bytes, double ns) {
        return physics::method_selection::MethodOption{
            codec, name, 0, 0.0, "", [=, this] {
                return physics::method_selection::MethodTrial{
                    datagrams + updates * bytes, load_.viewers * updates * tick_s() * ns, 0.0};
            }};
    };
    physics::method_selection::choose(choice,
                                      {option(proto::config::SHARED,
                                              "SHARED",
                                              kSharedRecord_bytes,
                                              price(zone::Pass::kReplication, "copied records")),
                                       option(proto::config::PER_CLIENT,
                                              "PER_CLIENT",
                                              kCodedRecord_bytes,
                                              price(zone::Pass::kReplication, "coded records"))});
    const int codec = choice.chosen ? choice.candidates[*choice.chosen].code
                                    : static_cast<int>(proto::config::PER_CLIENT);
    const bool given = replication.has_codec();
    if (!given) {
        replication.set_codec(static_cast<proto::config::Codec>(codec));
    }
    add("replication.codec",
        proto::config::Codec_Name(replication.codec()),
        given ? kAsConfigured
              : (choice.chosen ? "the cheapest that fits into replication.budget_bytes_per_s"
                               : "the fewest bytes; bounds widen where they do not suffice"));
    plans_.back().choice = std::move(choice);
}

void BudgetPlanner::plan_cpu(double budget_us) {
    auto& replication = *config_.mutable_replication();
    fill(
        "replication.codec_budget_us_per_tick",
        replication.has_codec_budget_us_per_tick(),
        replication.codec_budget_us_per_tick(),
        std::floor(kPartOfTick * std::min(budget_us, 1e6)),
        [&](double v) { replication.set_codec_budget_us_per_tick(static_cast<std::uint32_t>(v)); },
        "a quarter of budget.cpu_us_per_tick");
    if (config_.ai().has_pathfinding()) {
        auto& paths = *config_.mutable_ai()->mutable_pathfinding();
        fill(
            "ai.pathfinding.work_per_tick",
            paths.has_work_per_tick(),
            static_cast<double>(paths.work_per_tick()),
            std::max(1e3, std::floor(kPartOfTick * std::min(budget_us, 1e6) / kWorkUnit_us)),
            [&](double v) { paths.set_work_per_tick(static_cast<std::uint64_t>(v)); },
            "a quarter of budget.cpu_us_per_tick");
    }
}

}  // namespace

std::vector<MethodPlan> plan_budgets(Config& config, Diagnostics& diagnostics) {
    return config.has_budget() ? BudgetPlanner(config, diagnostics).run()
                               : std::vector<MethodPlan>();
}

WorldBudgets world_budgets(const Config& config) {
    const auto& from = config.budget();
    return {from.position_m(),
            from.orientation_rad(),
            from.time_s(),
            from.bytes_per_client_s(),
            from.cpu_us_per_tick()};
}

std::vector<std::string> scaled_budgets(const Settings& settings, double factor) {
    std::vector<std::string> sets;
    const auto scale = [&](const std::string& path, bool has, double value, double most) {
        const auto filled = [&](const MethodPlan& plan) {
            return plan.subject == path && plan.reason != kAsConfigured;
        };
        if (has && value > 0.0 &&
            std::none_of(settings.methods.begin(), settings.methods.end(), filled)) {
            sets.push_back(path + "=" + text_of("%.9g", std::min(factor * value, most)));
        }
    };
    const Config& config = *settings.config;
    const auto& b = config.budget();
    scale("budget.free_flight_m", b.has_free_flight_m(), b.free_flight_m(), 1e3);
    scale("budget.particles_m", b.has_particles_m(), b.particles_m(), 1e3);
    scale("budget.soft_share", b.has_soft_share(), b.soft_share(), 1.0);
    scale("budget.representation_rad", b.has_representation_rad(), b.representation_rad(), 1.0);
    scale("budget.position_m", b.has_position_m(), b.position_m(), 100.0);
    scale("budget.orientation_rad", b.has_orientation_rad(), b.orientation_rad(), 3.2);
    scale("budget.time_s", b.has_time_s(), b.time_s(), 60.0);
    scale("budget.bytes_per_client_s", b.has_bytes_per_client_s(), b.bytes_per_client_s(), 1e7);
    scale("budget.cpu_us_per_tick", b.has_cpu_us_per_tick(), b.cpu_us_per_tick(), 1e6);
    scale("physics.error_budget_m", true, config.physics().error_budget_m(), 1.0);
    for (int l = 0; l < config.lod_size(); ++l) {
        const std::string path = join_path("", "lod", l);
        scale(path + ".position_bound_m", true, config.lod(l).position_bound_m(), 100.0);
        scale(path + ".orientation_bound_rad", true, config.lod(l).orientation_bound_rad(), 3.2);
    }
    return sets;
}

}  // namespace zoned::config
