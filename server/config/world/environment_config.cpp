#include "server/config/world/environment_config.h"

#include "server/config/text/check_name.h"
#include "proto/config/config.pb.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace zoned::config {

void check_shared_environment(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::set<std::string> names;
    const auto check_name = [&](const std::string& name, const std::string& path) {
        if (name.empty()) {
            diagnostics.add(path, "a clock or a variable has a name");
        } else if (!names.insert(name).second) {
            diagnostics.add(path + ".name", "'" + name + "' is the name of another one");
        }
    };
    for (int c = 0; c < config.environment().clock_size(); ++c) {
        check_name(config.environment().clock(c).name(), join_path("environment", "clock", c));
    }
    for (int v = 0; v < config.environment().variable_size(); ++v) {
        const auto& variable = config.environment().variable(v);
        const std::string path = join_path("environment", "variable", v);
        check_name(variable.name(), path);
        if (variable.phase_size() == 0) {
            diagnostics.add(path, "a variable has at least one phase");
        }
        for (int p = 0; p < variable.phase_size(); ++p) {
            const auto& phase = variable.phase(p);
            if (phase.has_max_s() && phase.max_s() < phase.min_s()) {
                diagnostics.add(join_path(path, "phase", p) + ".max_s", "is less than min_s");
            }
        }
    }
}

clock::EnvironmentDefs expand_shared_environment(const proto::config::Config& config) {
    clock::EnvironmentDefs out;
    out.sync_ticks =
        std::max<Tick>(1,
                       static_cast<Tick>(std::llround(config.environment().sync_every_s() *
                                                      config.world().tick_rate_hz())));
    for (const auto& from : config.environment().clock()) {
        out.clocks.push_back({from.name(), from.period(), {0, from.start(), from.rate_per_s()}});
    }
    for (const auto& from : config.environment().variable()) {
        clock::SharedVariableDef& to = out.variables.emplace_back();
        to.name = from.name();
        to.seed = core::mix(config.world().seed()) ^ from.seed();
        to.blend_s = from.blend_s();
        for (const auto& phase : from.phase()) {
            to.phases.push_back({phase.name(),
                                 phase.value(),
                                 phase.weight(),
                                 phase.min_s(),
                                 phase.has_max_s() ? phase.max_s() : phase.min_s()});
        }
    }
    return out;
}

}  // namespace zoned::config
