#include "server/app/planner/forecast.h"

#include "server/config/plan/error_models.h"
#include "server/config/text/check_name.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace zoned::app {

namespace {

/// A view that was off by less than this share of its bound in the probe is taken to stay so.
constexpr double kSettled = 0.5;

PassForecast per_tick(const ZoneSums& probed, double table_runs_speed, bool measured) {
    PassForecast out{};
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        const PassSums& sums = probed.passes[p];
        if (sums.ran <= 0.0 || probed.ticks <= 0.0) {
            out[p] = -1.0;
            continue;
        }
        const auto pass = static_cast<zone::Pass>(p);
        config::PassUnits mean = sums.units;
        for (double& unit : mean) {
            unit /= sums.ran;
        }
        const double table = config::table_ns(pass, mean);
        const double run =
            measured ? config::expected_ns(table, table_runs_speed, sums.ns / sums.ran, sums.ran)
                     : table;
        out[p] = run * sums.ran / probed.ticks;
    }
    return out;
}

/// Bodies that the config places above each other, at most.
int tallest_pile(const config::Settings& settings) {
    config::PileCount piles;
    for (const config::InitialEntity& entity : settings.initial) {
        const world::EntityType& type = settings.types[entity.type];
        if (type.kind == world::EntityKind::kProp && type.shape != world::TypeShape::kSoft) {
            piles.add(entity.position.x(), entity.position.z());
        }
    }
    return piles.most();
}

/// Give of the lowest contact of the tallest pile.
double expected_give_m(const config::Settings& settings) {
    const config::Pile pile{tallest_pile(settings),
                            -static_cast<double>(settings.physics.gravity.y())};
    const double tick_s = 1.0 / settings.tick_rate_hz;
    const int substeps =
        settings.physics.substeps > 0
            ? settings.physics.substeps
            : config::substeps_for(
                  static_cast<double>(settings.physics.error_budget_m), pile.load_mps2(), tick_s);
    return config::kFlatShare *
           config::contact_give_m(pile.gravity_mps2 * pile.bodies, tick_s / substeps);
}

/// Passes by the beginnings of the subjects of plans.
constexpr std::array<std::pair<std::string_view, zone::Pass>, 4> kPassOfSubject{{
    {"bodies", zone::Pass::kPhysics},
    {"props as points", zone::Pass::kPhysics},
    {"particle system ", zone::Pass::kParticles},
    {"soft type ", zone::Pass::kSoft},
}};

void add_methods(const config::Settings& settings, std::vector<ErrorForecast>& out) {
    for (const config::MethodPlan& plan : settings.methods) {
        for (const auto& [subject, pass] : kPassOfSubject) {
            if (plan.choice && plan.choice->chosen && plan.subject.starts_with(subject)) {
                const auto& choice = *plan.choice;
                out.push_back({plan.subject,
                               choice.unit,
                               choice.basis,
                               choice.candidates[*choice.chosen].error,
                               choice.budget,
                               pass});
            }
        }
    }
}

/// News leave when a prediction misses its bound; where the probe saw none leave, it goes on so.
double expected_view(double bound, double quantum, double probed) {
    return probed > kSettled * bound ? bound : std::max(probed, 0.5 * quantum);
}

}  // namespace

PassForecast forecast_of(const ZoneSums& probed, double speed) {
    return per_tick(probed, speed, true);
}

PassForecast priced(const ZoneSums& probed) {
    return per_tick(probed, 1.0, false);
}

std::vector<ErrorForecast> forecast_errors(const config::Settings& settings,
                                           const WorldProbe& probe) {
    std::vector<ErrorForecast> out;
    const replication::ReplicationSettings& to = settings.replication;
    for (std::size_t l = 0; l < probe.views().size(); ++l) {
        const ViewErrors& views = probe.views()[l];
        const wire::Quantization q = wire::at_lod(to.quantization, static_cast<std::uint8_t>(l));
        const double quantum_m = static_cast<double>(q.position_quantum_m());
        const double quantum_rad = static_cast<double>(
            std::max(q.orientation_quantum_rad(true), q.orientation_quantum_rad(false)));
        const auto bound_m = static_cast<double>(to.lods[l].position_m);
        const auto bound_rad = static_cast<double>(to.lods[l].orientation_rad);
        const std::string level = "level " + std::to_string(l);
        const auto add =
            [&](const char* what, const char* unit, double bound, double quantum, double probed) {
                out.push_back({level + what,
                               unit,
                               probed > kSettled * bound
                                   ? "news leave when a prediction misses its bound"
                                   : "nothing misses its bound, as in the probe",
                               expected_view(bound, quantum, probed),
                               bound + quantum,
                               zone::Pass::kReplication});
            };
        add(" position", "m", bound_m, quantum_m, views.most_m);
        add(" orientation", "rad", bound_rad, quantum_rad, views.most_rad);
    }
    const double probed_m = probe.give_m();
    out.push_back({"contacts",
                   "m",
                   probed_m > 0.0 ? "give of bodies on the ground, as in the probe"
                                  : "give of the lowest contact of the tallest pile that is placed",
                   probed_m > 0.0 ? probed_m : expected_give_m(settings),
                   static_cast<double>(settings.physics.error_budget_m),
                   zone::Pass::kPhysics});
    add_methods(settings, out);
    return out;
}

std::string error_of_pass(const std::vector<ErrorForecast>& errors, zone::Pass pass) {
    const ErrorForecast* nearest = nullptr;
    const auto share = [](const ErrorForecast& e) {
        return e.expected / e.promised;
    };
    for (const ErrorForecast& error : errors) {
        if (error.pass == pass && (nearest == nullptr || share(error) > share(*nearest))) {
            nearest = &error;
        }
    }
    return nearest == nullptr ? "-" : config::text_of("%.2g ", nearest->expected) + nearest->unit;
}

std::vector<double> actual_errors(const WorldProbe& probe) {
    std::vector<double> out;
    for (const ViewErrors& views : probe.views()) {
        out.push_back(views.samples > 0 ? views.most_m : -1.0);
        out.push_back(views.samples > 0 ? views.most_rad : -1.0);
    }
    out.push_back(probe.give_m());
    return out;
}

}  // namespace zoned::app
