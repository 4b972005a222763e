#include "server/config/expand/method_plan.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/soft_types.h"
#include "server/physics/method_selection/cost_table.h"
#include "server/physics/method_selection/flight_choice.h"
#include "server/physics/method_selection/particle_choice.h"
#include "server/physics/method_selection/soft_choice.h"
#include "server/physics/soft/soft_body.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zoned::config {

namespace {

namespace selection = physics::method_selection;
namespace soft = physics::soft;
using physics::IntegratorKind;

/// Text for an error: the method that would keep the budget, or comes nearest.
std::string instead_text(const selection::MethodChoice& choice) {
    std::array<char, 200> text{};
    const bool found = choice.chosen.has_value();
    const selection::MethodCandidate* c =
        found ? &choice.candidates[*choice.chosen] : choice.best();
    if (c == nullptr) {
        return "nothing that was tried stays finite";
    }
    std::snprintf(text.data(),
                  text.size(),
                  found ? "the cheapest that keeps it is %s, off by %.3g %s"
                        : "nothing that was tried keeps it: the best is %s, off by %.3g %s",
                  selection::name_of(*c).c_str(),
                  c->error,
                  choice.unit.c_str());
    return text.data();
}

/// Reason against the configured method: that of the nearest candidate, or of the first.
std::string refused_text(const selection::MethodChoice& choice) {
    const selection::MethodCandidate* best = choice.best();
    if (best == nullptr && !choice.candidates.empty()) {
        best = &choice.candidates.back();
    }
    return best == nullptr ? "" : selection::name_of(*best) + ": " + best->refused;
}

/// The settings that bodies and particles have in common.
struct FlightPart {
    std::string subject;
    std::string setting;         ///< the path of the integrator
    std::string budget_setting;  ///< the path of the budget
    std::string nothing;         ///< what there is none of
    bool named = false;
    double error_m = 0.0;
    std::vector<selection::Flight> flights;
    IntegratorKind& kind;
    int& pieces;
};

/// One flight for each drag among the given props.
template <class Wanted>
std::vector<selection::Flight> flights_of(const proto::config::Config& config,
                                          const Wanted& wanted) {
    std::vector<selection::Flight> flights;
    for (const auto& type : config.type()) {
        const bool rigid = type.kind() == proto::config::PROP && !type.has_soft();
        const bool known = std::any_of(flights.begin(), flights.end(), [&](const auto& f) {
            return f.linear_drag == type.drag_ps();
        });
        if (rigid && wanted(type) && !known) {
            selection::Flight flight;
            flight.name = "type " + type.name();
            flight.gravity = Vec3d(0.0, -config.physics().gravity_mps2(), 0.0);
            flight.linear_drag = type.drag_ps();
            flight.fastest = config.replication().quantization().max_speed_mps();
            flights.push_back(flight);
        }
    }
    return flights;
}

/// Without a budget, the configured method only has to be stable.
void keep_flight(const FlightPart& part,
                 double tick_s,
                 MethodPlan& plan,
                 Diagnostics& diagnostics) {
    plan.used = std::string(physics::name_of(part.kind)) + " x 1";
    plan.reason = std::string(part.named ? "named by the config" : "the default") +
                  "; no budget (" + part.budget_setting + ")";
    for (const selection::Flight& flight : part.flights) {
        if (const std::string why = selection::why_unstable(part.kind, 1, flight, tick_s);
            !why.empty()) {
            diagnostics.add(part.setting, why);
            return;
        }
    }
}

void choose_flights(const proto::config::Config& config,
                    const FlightPart& part,
                    double tick_s,
                    MethodPlan& plan,
                    Diagnostics& diagnostics) {
    const selection::FlightBudget wish{part.error_m, config.budget().flight_s(), tick_s};
    const std::array named{part.kind};
    selection::MethodChoice choice =
        part.named ? selection::choose_flight(part.subject, part.flights, wish, named)
                   : selection::choose_flight(part.subject, part.flights, wish);
    std::array<char, 200> basis{};
    std::snprintf(
        basis.data(),
        basis.size(),
        "largest distance from the exact path within %g s, from rest and thrown at %g m/s",
        wish.seconds,
        part.flights.front().fastest);
    choice.basis = basis.data();
    if (choice.chosen) {
        const selection::MethodCandidate& c = choice.candidates[*choice.chosen];
        part.kind = static_cast<IntegratorKind>(c.code);
        part.pieces = c.pieces;
        plan.used = selection::name_of(c);
        plan.reason = part.named ? "named by the config; the fewest pieces that keep the budget"
                                 : "the cheapest that keeps the budget";
    } else if (part.named) {
        diagnostics.add(
            part.setting,
            refused_text(choice) + " (" + part.budget_setting + "); " +
                instead_text(selection::choose_flight(part.subject, part.flights, wish)));
    } else {
        diagnostics.add(part.budget_setting, instead_text(choice));
    }
    plan.choice = std::move(choice);
}

MethodPlan plan_flight(const proto::config::Config& config,
                       const FlightPart& part,
                       double tick_s,
                       Diagnostics& diagnostics) {
    MethodPlan plan;
    plan.subject = part.subject;
    if (part.flights.empty()) {
        plan.reason = "nothing to choose: " + part.nothing;
    } else if (part.error_m > 0.0) {
        choose_flights(config, part, tick_s, plan, diagnostics);
    } else {
        keep_flight(part, tick_s, plan, diagnostics);
    }
    return plan;
}

/// A soft type, the lattice tried in its place, and the choice.
selection::MethodChoice choose_for(const Settings& settings,
                                   const proto::config::Type& type,
                                   const soft::SoftDef& whole,
                                   bool as_named) {
    auto probe = build_soft(type);
    std::uint32_t coarser = 1;
    constexpr std::uint32_t kCoarsest = 64;
    while (probe && probe->def.springs.size() > selection::kMostProbeSprings &&
           coarser < kCoarsest) {
        coarser = type.soft().has_balloon() ? 2 * coarser : coarser + 1;
        auto next = build_soft(coarsened(type, coarser));
        if (!next) {
            break;
        }
        probe = std::move(next);
    }
    selection::SoftSubject subject{"soft type " + type.name(),
                                   whole,
                                   probe ? probe->def : whole,
                                   static_cast<int>(coarser),
                                   settings.physics.gravity,
                                   narrow(1.0 / settings.tick_rate_hz)};
    const double share = settings.config->budget().soft_share();
    const std::array named{static_cast<soft::SoftMethod>(type.soft().method())};
    const bool one = as_named && type.soft().has_method();
    const auto methods = one ? std::span<const soft::SoftMethod>(named) : selection::kSoftMethods;
    return selection::choose_soft(
        subject, share, methods, as_named ? static_cast<int>(type.soft().substeps()) : 0);
}

MethodPlan plan_soft(Settings& settings,
                     const proto::config::Type& type,
                     std::shared_ptr<const soft::SoftDef>& def,
                     const std::string& path,
                     Diagnostics& diagnostics) {
    MethodPlan plan;
    plan.subject = "soft type " + type.name();
    const auto& from = type.soft();
    const bool named = from.has_method() || from.substeps() > 0;
    if (settings.config->budget().soft_share() <= 0.0) {
        const int n = soft::make_body(*def).substeps(narrow(1.0 / settings.tick_rate_hz));
        plan.used = std::string(soft::name_of(def->solver.method)) + " x " + std::to_string(n);
        plan.reason = std::string(named ? "named by the config" : "the default") +
                      "; no budget (budget.soft_share)";
        return plan;
    }
    selection::MethodChoice choice = choose_for(settings, type, *def, true);
    if (choice.chosen) {
        const selection::MethodCandidate& c = choice.candidates[*choice.chosen];
        auto chosen = std::make_shared<soft::SoftDef>(*def);
        chosen->solver.method = static_cast<soft::SoftMethod>(c.code);
        chosen->solver.substeps = c.pieces;
        def = std::move(chosen);
        plan.used = selection::name_of(c);
        plan.reason = named ? "the cheapest within what the config names that keeps the budget"
                            : "the cheapest that keeps the budget";
    } else if (named) {
        diagnostics.add(path + (from.has_method() ? ".soft.method" : ".soft.substeps"),
                        refused_text(choice) + " (budget.soft_share); " +
                            instead_text(choose_for(settings, type, *def, false)));
    } else {
        diagnostics.add("budget.soft_share", plan.subject + ": " + instead_text(choice));
    }
    plan.choice = std::move(choice);
    return plan;
}

double longest_life_of(const zone::ParticleSource& source) {
    float longest = source.burst ? source.burst->lifetime_max_s : 0.0F;
    for (const motion::Emitter& emitter : source.emitters) {
        longest = std::max(longest, emitter.lifetime_max_s);
    }
    return static_cast<double>(longest);
}

/// Bursts are unknown before rules emit them: they are taken to be as fast as any entity that is
/// sent.
double fastest_of(const proto::config::Config& config, const zone::ParticleSource& source) {
    double fastest = source.burst ? config.replication().quantization().max_speed_mps() : 0.0;
    for (const motion::Emitter& emitter : source.emitters) {
        fastest = std::max(fastest, static_cast<double>(emitter.speed_max));
    }
    return fastest;
}

MethodPlan plan_particles(const Settings& settings,
                          zone::ParticleSource& source,
                          double tick_s,
                          Diagnostics& diagnostics) {
    MethodPlan plan;
    plan.subject = "particle system " + source.def.name;
    const proto::config::Config& config = *settings.config;
    if (source.def.flock) {
        plan.used = "semi_implicit_euler x 1";
        plan.reason = "the only one; a flock has no exact path";
        return plan;
    }
    if (config.budget().particles_m() <= 0.0) {
        plan.used = "semi_implicit_euler x 1";
        plan.reason = "the default; no budget (budget.particles_m)";
        return plan;
    }
    const selection::FlightBudget wish{
        config.budget().particles_m(),
        std::min(config.budget().flight_s(), longest_life_of(source)),
        tick_s};
    const double fastest = fastest_of(config, source);
    selection::MethodChoice choice = selection::choose_particle_pieces(source.def, fastest, wish);
    choice.basis =
        text_of("largest distance from the exact path within %g s, from rest and thrown at %g m/s",
                wish.seconds,
                fastest);
    if (choice.chosen) {
        source.def.pieces = choice.candidates[*choice.chosen].pieces;
        plan.used = selection::name_of(choice.candidates[*choice.chosen]);
        plan.reason = "the fewest pieces that keep the budget";
    } else {
        diagnostics.add("budget.particles_m", plan.subject + ": " + instead_text(choice));
    }
    plan.choice = std::move(choice);
    return plan;
}

/// A type that is one hull far away: the distance and its reason.
MethodPlan plan_representation(const proto::config::Config& config,
                               const proto::config::Type& from,
                               const world::EntityType& type) {
    MethodPlan plan;
    plan.subject = "type " + type.name + " far away";
    plan.used = text_of("one hull beyond %.3g m", static_cast<double>(type.single_beyond_m));
    if (from.representation().has_single_beyond_m()) {
        plan.reason = "named by the config";
        return plan;
    }
    const double share =
        from.has_soft() ? selection::kSoftHullErrorShare : selection::kSingleErrorShare;
    plan.reason = text_of(
        "where %.3g m, %g of its diameter, by which it is off then, are seen "
        "under %g rad",
        2.0 * static_cast<double>(type.radius) * share,
        share,
        config.budget().representation_rad());
    return plan;
}

/// One line of a candidate: method and pieces, error, cost, verdict.
std::string candidate_text(const selection::MethodCandidate& c) {
    std::array<char, 64> error{};
    if (std::isnan(c.error)) {
        error[0] = '-';
    } else {
        std::snprintf(error.data(), error.size(), "%.3g", c.error);
    }
    std::array<char, 400> line{};
    std::snprintf(line.data(),
                  line.size(),
                  "    %-26s %10s %11s  %s\n",
                  selection::name_of(c).c_str(),
                  error.data(),
                  ((std::isnan(c.error) ? ">= " : "") + selection::time_text(c.cost_ns)).c_str(),
                  c.refused.empty() ? "chosen" : c.refused.c_str());
    return line.data();
}

}  // namespace

double single_beyond_m(const proto::config::Config& config,
                       const proto::config::Type& type,
                       float radius,
                       bool pinned) {
    const double angle = config.budget().representation_rad();
    const bool reducible = type.has_compound() || (type.has_soft() && !pinned);
    if (type.representation().has_single_beyond_m() || angle <= 0.0 || !reducible) {
        return type.representation().single_beyond_m();
    }
    const double share =
        type.has_soft() ? selection::kSoftHullErrorShare : selection::kSingleErrorShare;
    return 2.0 * static_cast<double>(radius) * share / angle;
}

void plan_methods(Settings& settings, Diagnostics& diagnostics) {
    const proto::config::Config& config = *settings.config;
    const double tick_s = 1.0 / settings.tick_rate_hz;
    const FlightPart bodies{"bodies",
                            "physics.body_integrator",
                            "budget.free_flight_m",
                            "no type is a rigid prop",
                            config.physics().has_body_integrator(),
                            config.budget().free_flight_m(),
                            flights_of(config, [](const auto&) { return true; }),
                            settings.physics.body_integrator,
                            settings.physics.body_flight_pieces};
    const FlightPart particles{
        "props as points",
        "physics.particle_integrator",
        "budget.particles_m",
        "no type is ever a point (representation.particle_beyond_m)",
        config.physics().has_particle_integrator(),
        config.budget().particles_m(),
        flights_of(config,
                   [](const auto& type) { return type.representation().particle_beyond_m() > 0; }),
        settings.physics.particle_integrator,
        settings.physics.particle_flight_pieces};
    settings.methods.push_back(plan_flight(config, bodies, tick_s, diagnostics));
    settings.methods.push_back(plan_flight(config, particles, tick_s, diagnostics));
    for (zone::ParticleSource& source : settings.particles) {
        settings.methods.push_back(plan_particles(settings, source, tick_s, diagnostics));
    }
    for (int t = 0; t < config.type_size(); ++t) {
        const world::EntityType& type = settings.types[static_cast<std::size_t>(t)];
        if (type.single_beyond_m > 0.0F) {
            settings.methods.push_back(plan_representation(config, config.type(t), type));
        }
        if (type.shape == world::TypeShape::kSoft) {
            settings.methods.push_back(plan_soft(settings,
                                                 config.type(t),
                                                 settings.softs[type.solid],
                                                 join_path("", "type", t),
                                                 diagnostics));
        }
    }
    if (settings.softs.empty()) {
        settings.methods.push_back({"soft bodies", "", "nothing to choose: no soft type", {}});
    }
}

std::string methods_text(const Settings& settings) {
    std::string out = "methods, chosen from the config and the table of measured costs\n";
    for (const MethodPlan& plan : settings.methods) {
        out += "  " + plan.subject + ": " + (plan.used.empty() ? "" : plan.used + ", ") +
               plan.reason + "\n";
        if (!plan.choice) {
            continue;
        }
        std::array<char, 120> head{};
        std::snprintf(head.data(),
                      head.size(),
                      "    budget %.3g %s; errors: ",
                      plan.choice->budget,
                      plan.choice->unit.c_str());
        out += head.data() + plan.choice->basis + "\n";
        std::snprintf(head.data(),
                      head.size(),
                      "    %-26s %10s %11s  %s\n",
                      "method x pieces",
                      "error",
                      "per tick",
                      "because");
        out += head.data();
        for (const selection::MethodCandidate& c : plan.choice->candidates) {
            out += candidate_text(c);
        }
    }
    return out;
}

}  // namespace zoned::config
