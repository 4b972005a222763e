#include "server/app/planner/analysis.h"

#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/config/plan/budget_plan.h"
#include "server/replication/packer.h"
#include "shared/core/json.h"

#include <algorithm>
#include <cstdio>
#include <map>

namespace zoned::app {

namespace {

/// Passes that take less of a tick are no figures: the clock's own cost shows, ns.
constexpr double kNotice_ns = 2000.0;

template <class... Numbers>
std::string line(const char* format, Numbers... numbers) {
    std::array<char, 300> text{};
    std::snprintf(text.data(), text.size(), format, numbers...);
    return text.data();
}

PassForecast actual_of(const ZoneSums& sums) {
    PassForecast out{};
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        out[p] = sums.passes[p].ran > 0.0 ? sums.passes[p].ns / sums.ticks : -1.0;
    }
    return out;
}

std::string pass_of(std::size_t p) {
    return std::string(zone::pass_name(static_cast<zone::Pass>(p)));
}

/// "1.07", "-" where one of them is no figure.
std::string ratio_text(double actual, double expected) {
    return expected > 0.0 && actual >= 0.0 ? line("%.2f", actual / expected) : "-";
}

std::vector<PassForecast> actual_zones(const WorldProbe& probe) {
    std::vector<PassForecast> out;
    for (const ZoneSums& sums : probe.zones()) {
        out.push_back(actual_of(sums));
    }
    return out;
}

std::vector<PassForecast> priced_zones(const std::vector<ZoneSums>& sums) {
    std::vector<PassForecast> out;
    for (const ZoneSums& zone : sums) {
        out.push_back(priced(zone));
    }
    return out;
}

/// Methods of `other` that differ from those of `settings`.
std::string changed_methods(const config::Settings& settings, const config::Settings& other) {
    std::map<std::string, std::string> before;
    for (const config::MethodPlan& plan : settings.methods) {
        before[plan.subject] = plan.used;
    }
    std::string out;
    for (const config::MethodPlan& plan : other.methods) {
        const auto it = before.find(plan.subject);
        if (it != before.end() && it->second != plan.used) {
            out += "    " + plan.subject + ": " + it->second + " -> " + plan.used + "\n";
        }
    }
    return out;
}

}  // namespace

double total_ns(const std::vector<PassForecast>& zones) {
    double sum = 0.0;
    for (const PassForecast& zone : zones) {
        for (const double ns : zone) {
            sum += std::max(ns, 0.0);
        }
    }
    return sum;
}

double bytes_per_client_s(const config::Settings& settings, const WorldProbe& probe) {
    double bytes = 0.0;
    double clients = 0.0;
    for (const ZoneSums& sums : probe.zones()) {
        bytes += sums.bytes + static_cast<double>(replication::kPacketOverheadBytes) * sums.packets;
        clients += sums.viewer_ticks;
    }
    return clients > 0.0 ? bytes / clients * settings.tick_rate_hz : 0.0;
}

WorldForecast forecast_world(const config::Settings& settings, const WorldProbe& probe) {
    WorldForecast out;
    for (const ZoneSums& sums : probe.zones()) {
        out.zones.push_back(forecast_of(sums, probe.speed()));
    }
    out.speed = probe.speed();
    out.errors = forecast_errors(settings, probe);
    out.bytes_per_client_s = bytes_per_client_s(settings, probe);
    return out;
}

WorldForecast at_speed_of(WorldForecast forecast, const WorldProbe& after) {
    for (PassForecast& zone : forecast.zones) {
        for (double& ns : zone) {
            ns *= after.speed() / forecast.speed;
        }
    }
    forecast.speed = after.speed();
    return forecast;
}

std::string errors_text(const config::Settings& settings, const WorldForecast& forecast) {
    std::string out = "errors that are expected\n";
    for (const ErrorForecast& error : forecast.errors) {
        out += line("  %-22s %10.3g of at most %.3g %s: %s\n",
                    error.name.c_str(),
                    error.expected,
                    error.promised,
                    error.unit.c_str(),
                    error.basis.c_str());
    }
    const config::WorldBudgets& budget = settings.budgets;
    const double us = 1e-3 * total_ns(forecast.zones) / static_cast<double>(forecast.zones.size());
    out += line("  cost: %.1f us a tick and zone", us);
    if (budget.cpu_us_per_tick > 0.0) {
        out += line(", %s budget.cpu_us_per_tick %g",
                    us > budget.cpu_us_per_tick ? "MORE than" : "within",
                    budget.cpu_us_per_tick);
    }
    out += line("; downlink: %.0f bytes/s a client", forecast.bytes_per_client_s);
    if (budget.bytes_per_client_s > 0.0) {
        out +=
            line(", %s budget.bytes_per_client_s %g",
                 forecast.bytes_per_client_s > budget.bytes_per_client_s ? "MORE than" : "within",
                 budget.bytes_per_client_s);
    }
    return out + "\n";
}

std::string other_budgets_text(const ProbedWorld& own) {
    const double before_ns = total_ns(priced_zones(own.sums));
    std::string out =
        "with all budgets and bounds halved or doubled (units counted in a run, "
        "prices of the table)\n";
    for (const double factor : {0.5, 2.0}) {
        config::Settings other;
        std::vector<config::ConfigError> errors;
        std::vector<std::string> more = own.sets;
        const std::vector<std::string> scaled = config::scaled_budgets(own.settings, factor);
        more.insert(more.end(), scaled.begin(), scaled.end());
        if (!config::load_settings(own.file, more, other, errors)) {
            out += line("  %g x: refused: ", factor) +
                   (errors.empty() ? "" : errors.front().path + ": " + errors.front().text) + "\n";
            continue;
        }
        declare_fields(other);
        World world(other, 1);
        WorldProbe probe(world, other, own.crowd);
        if (own.codec) {
            probe.give(*own.codec);
        }
        probe.run(own.ticks);
        const double ns = total_ns(priced_zones(probe.zones()));
        const std::vector<ErrorForecast> expected = forecast_errors(other, probe);
        out += line("  %g x: cost %.2f x, downlink %.0f bytes/s; ",
                    factor,
                    ns / before_ns,
                    bytes_per_client_s(other, probe));
        for (const ErrorForecast& error : expected) {
            out += line("%s %.3g %s%s",
                        error.name.c_str(),
                        error.expected,
                        error.unit.c_str(),
                        &error == &expected.back() ? "\n" : ", ");
        }
        out += changed_methods(own.settings, other);
    }
    return out;
}

std::string analysis_text(const config::Settings& settings,
                          const WorldForecast& before,
                          const WorldProbe& after) {
    const WorldForecast forecast = at_speed_of(before, after);
    const std::vector<PassForecast> actual = actual_zones(after);
    const double ticks = after.zones().empty() ? 0.0 : after.zones().front().ticks;
    std::string out = line("\nexpected beside actual, over %.0f ticks (%.3g s)\n",
                           ticks,
                           ticks / settings.tick_rate_hz);
    for (std::size_t z = 0; z < actual.size(); ++z) {
        out += line("zone %u %s\n  %-18s %12s %12s %7s\n",
                    static_cast<unsigned>(settings.zones[z].id.value),
                    settings.zones[z].name.c_str(),
                    "pass",
                    "expected us",
                    "actual us",
                    "ratio");
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            const double expected_ns = forecast.zones[z][p];
            const double actual_ns = actual[z][p];
            if (std::max(expected_ns, actual_ns) > kNotice_ns) {
                out += line("  %-18s %12.1f %12.1f %7s\n",
                            pass_of(p).c_str(),
                            1e-3 * std::max(expected_ns, 0.0),
                            1e-3 * std::max(actual_ns, 0.0),
                            ratio_text(actual_ns, expected_ns).c_str());
            }
        }
    }
    const double expected_ns = total_ns(forecast.zones);
    const double actual_ns = total_ns(actual);
    out += line("world\n  %-22s %12.1f %12.1f %7s us a tick\n",
                "cost",
                1e-3 * expected_ns,
                1e-3 * actual_ns,
                ratio_text(actual_ns, expected_ns).c_str());
    const double bytes = bytes_per_client_s(settings, after);
    out += line("  %-22s %12.0f %12.0f %7s bytes/s a client\n",
                "downlink",
                forecast.bytes_per_client_s,
                bytes,
                ratio_text(bytes, forecast.bytes_per_client_s).c_str());
    const std::vector<double> errors = actual_errors(after);
    for (std::size_t e = 0; e < errors.size(); ++e) {
        const ErrorForecast& error = forecast.errors[e];
        if (errors[e] >= 0.0) {
            out += line("  %-22s %12.4g %12.4g %7s %s%s\n",
                        error.name.c_str(),
                        error.expected,
                        errors[e],
                        ratio_text(errors[e], error.expected).c_str(),
                        error.unit.c_str(),
                        errors[e] > error.promised ? ", MORE than promised" : "");
        }
    }
    return out;
}

std::string analysis_json(const config::Settings& settings,
                          const WorldForecast& before,
                          const WorldProbe& after) {
    const WorldForecast forecast = at_speed_of(before, after);
    const std::vector<PassForecast> actual = actual_zones(after);
    core::JsonWriter json;
    json.begin_object().field("world", settings.world_name);
    json.field("ticks", after.zones().empty() ? 0.0 : after.zones().front().ticks);
    json.field("expected_cost_us", 1e-3 * total_ns(forecast.zones));
    json.field("actual_cost_us", 1e-3 * total_ns(actual));
    json.field("expected_bytes_per_client_s", forecast.bytes_per_client_s);
    json.field("actual_bytes_per_client_s", bytes_per_client_s(settings, after));
    json.key("zones").begin_array();
    for (std::size_t z = 0; z < actual.size(); ++z) {
        json.begin_object().field("zone", settings.zones[z].name).key("passes").begin_array();
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            if (forecast.zones[z][p] >= 0.0 || actual[z][p] >= 0.0) {
                json.begin_object().field("pass", pass_of(p));
                json.field("expected_us", 1e-3 * std::max(forecast.zones[z][p], 0.0));
                json.field("actual_us", 1e-3 * std::max(actual[z][p], 0.0)).end_object();
            }
        }
        json.end_array().end_object();
    }
    json.end_array().key("errors").begin_array();
    const std::vector<double> errors = actual_errors(after);
    for (std::size_t e = 0; e < errors.size(); ++e) {
        const ErrorForecast& error = forecast.errors[e];
        if (errors[e] >= 0.0) {
            json.begin_object().field("name", error.name).field("unit", error.unit);
            json.field("expected", error.expected).field("promised", error.promised);
            json.field("actual", errors[e]).end_object();
        }
    }
    json.end_array().end_object();
    return json.text() + "\n";
}

}  // namespace zoned::app
