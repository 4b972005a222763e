#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"
#include "server/app/world/world_rules.h"
#include "server/app/world/world_settings.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/stability_report.h"
#include "server/config/expand/world_warnings.h"
#include "server/config/world/pathfinding_config.h"
#include "server/config/world/spline_config.h"

#include <cstdio>
#include <exception>

namespace zoned::app {

namespace {

/// The rules check their settings when they are made, and declare their fields.
bool rules_take(const std::string& config, config::Settings& settings) {
    try {
        declare_fields(settings);
        try_world_rules(settings);
        return true;
    } catch (const std::exception& error) {
        std::fprintf(stderr,
                     "%s: rules: %s\nzoned: the rules refuse their settings; nothing was started\n",
                     config.c_str(),
                     error.what());
        return false;
    }
}

bool maps_can_be_baked(const std::string& config, const config::Settings& settings) {
    const std::string defect = paths_defect(settings);
    if (!defect.empty()) {
        std::fprintf(stderr,
                     "%s: ai.pathfinding: %s\nzoned: no map can be baked; nothing was started\n",
                     config.c_str(),
                     defect.c_str());
    }
    return defect.empty();
}

}  // namespace

bool load_or_complain(const std::string& config,
                      const std::vector<std::string>& sets,
                      config::Settings& settings) {
    std::vector<config::ConfigError> errors;
    if (config::load_settings(config, sets, settings, errors)) {
        return rules_take(config, settings) && maps_can_be_baked(config, settings);
    }
    std::fputs(config::format_errors(config, errors).c_str(), stderr);
    std::fprintf(stderr,
                 "zoned: %zu mistake%s in %s; nothing was started\n",
                 errors.size(),
                 errors.size() == 1 ? "" : "s",
                 config.c_str());
    return false;
}

int check(const std::string& config, const std::vector<std::string>& sets) {
    config::Settings settings;
    if (!load_or_complain(config, sets, settings)) {
        return kUsage;
    }
    std::printf("%s: good: %zu zones, %zu types, %zu static boxes, %zu entities, digest %.16s\n",
                config.c_str(),
                settings.zones.size(),
                settings.types.size(),
                settings.boxes.size(),
                settings.initial.size(),
                settings.digest.c_str());
    for (const config::SurfaceSettings& surface : settings.surfaces) {
        const bool field = surface.shape.kind == physics::ShapeKind::kHeightfield;
        std::printf("%s: %s: %s from %s, %s\n",
                    config.c_str(),
                    surface.path.c_str(),
                    field ? "heightfield" : "mesh",
                    surface.file.c_str(),
                    surface.replicated ? "told to clients" : "not told to clients");
    }
    std::printf("%s: %s\n", config.c_str(), config::pathfinding_text(settings).c_str());
    for (const auto& warnings : {config::world_warnings_of(settings),
                                 config::stability_warnings_of(settings),
                                 config::waypoint_warnings(settings),
                                 config::track_warnings(settings)}) {
        for (const std::string& warning : warnings) {
            std::printf("%s: warning: %s\n", config.c_str(), warning.c_str());
        }
    }
    return kGood;
}

}  // namespace zoned::app
