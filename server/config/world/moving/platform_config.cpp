#include "server/config/world/moving/platform_config.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/world/statics.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace zoned::config {

namespace {

/// Stops that are nearer to each other are one place, m.
constexpr double kStopsApart_m = 0.01;

Tick rounded_ticks(const proto::config::Config& config, double seconds) {
    return static_cast<Tick>(std::llround(seconds * config.world().tick_rate_hz()));
}

/// The centres of its box at all stops.
std::vector<Vec3d> places_of(const proto::config::Platform& platform) {
    std::vector<Vec3d> places = {
        Vec3d(platform.box().x_m(), platform.box().y_m(), platform.box().z_m())};
    for (const auto& stop : platform.stop()) {
        places.emplace_back(stop.x_m(), stop.y_m(), stop.z_m());
    }
    return places;
}

/// Whole ticks, so that it is never faster than it may be.
Tick travel_ticks(const proto::config::Config& config,
                  const proto::config::Platform& platform,
                  const Vec3d& from,
                  const Vec3d& to) {
    const double ticks = (to - from).norm() / platform.speed_mps() * config.world().tick_rate_hz();
    return std::max<Tick>(1, static_cast<Tick>(std::ceil(ticks)));
}

void check_stops(const proto::config::Config& config,
                 const proto::config::Platform& platform,
                 const std::vector<Vec3d>& places,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    if (platform.stop_size() == 0) {
        diagnostics.add(path, "has one stop, its box: give it a stop to travel to");
    }
    for (std::size_t i = 1; i < places.size(); ++i) {
        const std::string stop = join_path(path, "stop", static_cast<int>(i) - 1);
        if ((places[i] - places[i - 1]).norm() < kStopsApart_m) {
            diagnostics.add(stop, "is where the stop before it is");
        }
        motion::StaticBox box = static_box(platform.box());
        box.centre = places[i].cast<float>();
        check_inside(config.world(), box, stop, diagnostics);
    }
    if (platform.loop() && places.size() > 1 &&
        (places.back() - places.front()).norm() < kStopsApart_m) {
        diagnostics.add(join_path(path, "stop", platform.stop_size() - 1),
                        "is where the box begins: a loop comes back there by itself");
    }
}

/// Settings that are for the other kind of mover.
void check_mover(const proto::config::Platform& platform,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    if (platform.moved_by() != proto::config::Platform::RULES) {
        if (platform.has_start_stop()) {
            diagnostics.add(path + ".start_stop", "is for platforms with moved_by: RULES");
        }
        return;
    }
    if (platform.loop() || platform.has_wait_s() || platform.has_begin_s()) {
        diagnostics.add(path, "is moved by rules: it has no wait_s, loop or begin_s of its own");
    }
    if (static_cast<int>(platform.start_stop()) > platform.stop_size()) {
        diagnostics.add(path + ".start_stop",
                        text_of("there is no stop %g: the last one is %g",
                                platform.start_stop(),
                                platform.stop_size()));
    }
}

motion::PlatformPath path_of(const proto::config::Config& config,
                             const proto::config::Platform& platform,
                             const std::vector<Vec3d>& places,
                             std::uint32_t number) {
    motion::PlatformPath out;
    Tick at = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        at += i == 0 ? 0 : travel_ticks(config, platform, places[i - 1], places[i]);
        motion::PlatformStop& stop = out.stops.emplace_back();
        stop.at = at;
        for (int axis = 0; axis < 3; ++axis) {
            stop.offset[axis] = motion::on_platform_step(places[i][axis] - places[0][axis]);
        }
    }
    if (platform.moved_by() == proto::config::Platform::RULES) {
        out.by_rules = number;
        out.start = out.stops[std::min<std::size_t>(platform.start_stop(), places.size() - 1)].at;
        return out;
    }
    out.back = platform.loop() ? travel_ticks(config, platform, places.back(), places[0]) : 0;
    out.wait = rounded_ticks(config, platform.wait_s());
    out.shift = rounded_ticks(config, platform.begin_s());
    return out;
}

}  // namespace

std::vector<NamedPlatform> expand_platforms(const proto::config::Config& config,
                                            Diagnostics& diagnostics) {
    std::vector<NamedPlatform> out;
    std::set<std::string> names;
    for (int i = 0; i < config.platform_size(); ++i) {
        const auto& platform = config.platform(i);
        const std::string path = join_path("", "platform", i);
        if (check_name(platform.name(), "a platform", path, diagnostics) &&
            !names.insert(platform.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + platform.name() + "' is the name of another platform");
        }
        NamedPlatform& named = out.emplace_back();
        named.name = platform.name();
        named.platform.box = static_box(platform.box());
        if (!platform.has_box()) {
            diagnostics.add(path, "a platform has a box");
        } else {
            check_inside(config.world(), named.platform.box, path + ".box", diagnostics);
        }
        const std::vector<Vec3d> places = places_of(platform);
        check_stops(config, platform, places, path, diagnostics);
        check_mover(platform, path, diagnostics);
        named.platform.path = path_of(config, platform, places, static_cast<std::uint32_t>(i));
    }
    return out;
}

}  // namespace zoned::config
