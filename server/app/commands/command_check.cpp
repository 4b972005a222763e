#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/stability_report.h"
#include "server/config/world/pathfinding_config.h"
#include "server/config/world/spline_config.h"

#include <cstdio>

namespace zoned::app {

bool load_or_complain(const std::string& config,
                      const std::vector<std::string>& sets,
                      config::Settings& settings) {
    std::vector<config::ConfigError> errors;
    if (config::load_settings(config, sets, settings, errors)) {
        return true;
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
    for (const std::string& warning : config::stability_warnings_of(settings)) {
        std::printf("%s: warning: %s\n", config.c_str(), warning.c_str());
    }
    for (const std::string& waypoint : config::waypoint_warnings(settings)) {
        std::printf("%s: warning: %s\n", config.c_str(), waypoint.c_str());
    }
    for (const std::string& track : config::track_warnings(settings)) {
        std::printf("%s: warning: %s\n", config.c_str(), track.c_str());
    }
    return kGood;
}

}  // namespace zoned::app
