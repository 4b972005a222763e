#include "server/config/world/particle_config.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>

namespace zoned::config {

namespace {

using System = proto::config::ParticleSystem;

/// Particles of a cosmetic system alive at a time: a client computes each of them for each picture.
constexpr double kMostCosmetic = 1e6;

double highest_speed(const proto::config::Emitter& e) {
    return e.has_speed_max_mps() ? e.speed_max_mps() : e.speed_min_mps();
}

/// Of an emitter or a burst.
template <class Message>
double longest_life(const Message& m) {
    return m.has_lifetime_max_s() ? m.lifetime_max_s() : m.lifetime_min_s();
}

double alive(const proto::config::Emitter& e) {
    const double most = e.most() > 0 ? static_cast<double>(e.most()) : kMostCosmetic * 1e6;
    return std::min(most, e.rate_hz() * longest_life(e));
}

void check_emitter(const proto::config::World& world,
                   const proto::config::Emitter& e,
                   bool cosmetic,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    if (highest_speed(e) < e.speed_min_mps()) {
        diagnostics.add(
            path + ".speed_max_mps",
            text_of("%g is less than speed_min_mps, %g", e.speed_max_mps(), e.speed_min_mps()));
    }
    if (longest_life(e) < e.lifetime_min_s()) {
        diagnostics.add(
            path + ".lifetime_max_s",
            text_of("%g is less than lifetime_min_s, %g", e.lifetime_max_s(), e.lifetime_min_s()));
    }
    const bool inside = e.x_m() >= world.min_x_m() && e.x_m() <= world.max_x_m() &&
                        e.z_m() >= world.min_z_m() && e.z_m() <= world.max_z_m();
    if (!cosmetic && !inside) {
        diagnostics.add(
            path,
            text_of(
                "x %g, z %g lies outside the world, where no zone simulates it", e.x_m(), e.z_m()));
    }
}

/// Settings that a cosmetic system, which clients compute in closed form, does not use; named as in
/// the config.
void check_cosmetic(const System& system, const std::string& path, Diagnostics& diagnostics) {
    const std::array<std::pair<bool, const char*>, 7> given = {{
        {system.has_quadratic_drag_per_m(), "quadratic_drag_per_m"},
        {system.has_radius_m(), "radius_m"},
        {system.has_restitution(), "restitution"},
        {system.has_friction(), "friction"},
        {system.has_most(), "most"},
        {system.has_characters_met(), "characters_met"},
        {system.wind().gust_mps() > 0.0, "wind.gust_mps"},
    }};
    for (const auto& [is, name] : given) {
        if (is) {
            diagnostics.add(path + "." + name,
                            "has no meaning for a cosmetic system, which clients replay in closed "
                            "form: leave it out, or set cosmetic: false");
        }
    }
    double particles = 0.0;
    for (const auto& emitter : system.emitter()) {
        particles += alive(emitter);
    }
    if (particles > kMostCosmetic) {
        diagnostics.add(path,
                        text_of("%g particles alive at a time (rate_hz x lifetime) are more than "
                                "the %g that a client replays",
                                particles,
                                kMostCosmetic));
    }
}

/// Settings of falling, which a flock does not do; named as in the config.
void check_flock_alone(const System& system, const std::string& path, Diagnostics& diagnostics) {
    const std::array<std::pair<bool, const char*>, 8> given = {{
        {system.has_gravity_factor(), "gravity_factor"},
        {system.has_drag_per_s(), "drag_per_s"},
        {system.has_quadratic_drag_per_m(), "quadratic_drag_per_m"},
        {system.has_wind(), "wind"},
        {system.has_radius_m(), "radius_m"},
        {system.has_restitution(), "restitution"},
        {system.has_friction(), "friction"},
        {system.has_characters_met(), "characters_met"},
    }};
    for (const auto& [is, name] : given) {
        if (is) {
            diagnostics.add(path + "." + name,
                            "has no meaning for a flock, which neither falls nor touches "
                            "anything: leave it out");
        }
    }
    if (system.cosmetic()) {
        diagnostics.add(path + ".cosmetic",
                        "clients cannot replay a flock in closed form, as each animal steers by "
                        "the others: set cosmetic: false");
    }
}

struct Range {
    double low = 0.0;
    double high = 0.0;
    const char* low_name = "";
    const char* high_name = "";
};

/// The home of a flock along x, y and z.
std::array<Range, 3> home_of(const proto::config::World& world, const proto::config::Flock& f) {
    return {{{f.has_min_x_m() ? f.min_x_m() : world.min_x_m(),
              f.has_max_x_m() ? f.max_x_m() : world.max_x_m(),
              ".min_x_m",
              ".max_x_m"},
             {f.min_y_m(), f.max_y_m(), ".min_y_m", ".max_y_m"},
             {f.has_min_z_m() ? f.min_z_m() : world.min_z_m(),
              f.has_max_z_m() ? f.max_z_m() : world.max_z_m(),
              ".min_z_m",
              ".max_z_m"}}};
}

void check_flock(const proto::config::World& world,
                 const System& system,
                 const std::string& system_path,
                 Diagnostics& diagnostics) {
    const proto::config::Flock& flock = system.flock();
    const std::string path = system_path + ".flock";
    check_flock_alone(system, system_path, diagnostics);
    const auto order = [&](double low, double high, const char* name, const char* of) {
        if (low > high) {
            diagnostics.add(path + name,
                            text_of("%g is less than ", high) + of + text_of(", %g", low));
        }
    };
    order(flock.separation_radius_m(), flock.radius_m(), ".radius_m", "separation_radius_m");
    order(flock.speed_min_mps(), flock.speed_max_mps(), ".speed_max_mps", "speed_min_mps");
    for (const Range& side : home_of(world, flock)) {
        if (side.high - side.low < 1.0) {
            diagnostics.add(path + side.high_name,
                            text_of("%g must be at least 1 m above ", side.high) +
                                (side.low_name + 1) + text_of(", %g", side.low));
        }
    }
    if (flock.path_size() == 1) {
        diagnostics.add(path + ".path", "a path has two points or more");
    }
    const bool path_settings =
        flock.has_closed() || flock.has_path_width_m() || flock.has_follow_per_s();
    if (flock.path_size() == 0 && path_settings) {
        diagnostics.add(path + ".path",
                        "closed, path_width_m and follow_per_s have no meaning without a path");
    }
}

void check_burst(const proto::config::Burst& burst,
                 bool cosmetic,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    const std::array<std::pair<bool, const char*>, 3> given = {{
        {burst.has_visibility_filter(), "visibility_filter"},
        {burst.has_aura_m(), "aura_m"},
        {burst.has_events_per_s(), "events_per_s"},
    }};
    for (const auto& [is, name] : given) {
        if (is && !cosmetic) {
            diagnostics.add(path + "." + name,
                            "has no meaning for a simulated system, of which no client is told: "
                            "leave it out, or set cosmetic: true");
        }
    }
    if (burst.visibility_filter() == proto::config::RULES) {
        diagnostics.add(path + ".visibility_filter",
                        "rules are asked about entities, not about places");
    }
    if (longest_life(burst) < burst.lifetime_min_s()) {
        diagnostics.add(path + ".lifetime_max_s",
                        text_of("%g is less than lifetime_min_s, %g",
                                burst.lifetime_max_s(),
                                burst.lifetime_min_s()));
    }
}

float cosine_of(double degrees) {
    return narrow(elementary::cos(degrees * std::numbers::pi / 180.0));
}

Vec3 axis_of(const proto::config::Emitter& e) {
    const double yaw = e.yaw_deg() * std::numbers::pi / 180.0;
    const double pitch = e.pitch_deg() * std::numbers::pi / 180.0;
    return Vec3d(elementary::cos(pitch) * elementary::sin(yaw),
                 elementary::sin(pitch),
                 elementary::cos(pitch) * elementary::cos(yaw))
        .cast<float>();
}

motion::Emitter emitter_of(const proto::config::Emitter& e, std::uint64_t seed) {
    motion::Emitter out;
    out.seed = core::mix(seed ^ core::mix(e.seed()));
    out.start = static_cast<Tick>(e.start_tick());
    out.rate_hz = e.rate_hz();
    out.most = e.most() > 0 ? e.most() : UINT64_MAX;
    out.position = Vec3d(e.x_m(), e.y_m(), e.z_m()).cast<float>();
    out.spread = narrow(e.spread_m());
    out.direction = axis_of(e);
    out.cone_cosine = cosine_of(e.cone_deg());
    out.speed_min = narrow(e.speed_min_mps());
    out.speed_max = narrow(highest_speed(e));
    out.lifetime_min_s = narrow(e.lifetime_min_s());
    out.lifetime_max_s = narrow(longest_life(e));
    return out;
}

Vec3 wind_of(const System& system) {
    return Vec3d(system.wind().x_mps(), system.wind().y_mps(), system.wind().z_mps()).cast<float>();
}

std::optional<motion::BurstKind> burst_of(const System& system) {
    if (!system.has_burst()) {
        return std::nullopt;
    }
    const proto::config::Burst& burst = system.burst();
    return motion::BurstKind{cosine_of(burst.cone_deg()),
                             narrow(burst.slowest()),
                             narrow(burst.spread_m()),
                             narrow(burst.lifetime_min_s()),
                             narrow(longest_life(burst))};
}

physics::FlockDef flock_of(const proto::config::World& world, const proto::config::Flock& from) {
    physics::FlockDef out;
    out.radius = narrow(from.radius_m());
    out.separation_radius = narrow(from.separation_radius_m());
    out.separation = narrow(from.separation());
    out.alignment = narrow(from.alignment_per_s());
    out.cohesion = narrow(from.cohesion_per_s2());
    out.most_acceleration = narrow(from.max_acceleration_mps2());
    out.least_speed = narrow(from.speed_min_mps());
    out.most_speed = narrow(from.speed_max_mps());
    const std::array<Range, 3> home = home_of(world, from);
    out.low = Vec3d(home[0].low, home[1].low, home[2].low);
    out.high = Vec3d(home[0].high, home[1].high, home[2].high);
    out.turn_back = narrow(from.turn_back_mps2());
    for (const auto& point : from.path()) {
        out.path.emplace_back(point.x_m(), point.z_m());
    }
    out.closed = from.closed();
    out.path_width = narrow(from.path_width_m());
    out.follow = narrow(from.follow_per_s());
    return out;
}

zone::ParticleSource source_of(const System& system) {
    zone::ParticleSource out;
    out.def.name = system.name();
    out.def.linear_drag = narrow(system.drag_per_s());
    out.def.quadratic_drag = narrow(system.quadratic_drag_per_m());
    out.def.wind.uniform = wind_of(system);
    out.def.wind.gust_speed = narrow(system.wind().gust_mps());
    out.def.wind.gust_size = narrow(system.wind().gust_size_m());
    out.def.wind.seed = system.wind().gust_seed();
    out.def.radius = narrow(system.radius_m());
    out.def.restitution = narrow(system.restitution());
    out.def.friction = narrow(system.friction());
    out.def.most = system.most();
    out.characters_met = system.characters_met();
    out.burst = burst_of(system);
    return out;
}

}  // namespace

void check_particles(const proto::config::Config& config, Diagnostics& diagnostics) {
    std::set<std::string> names;
    for (int s = 0; s < config.particles_size(); ++s) {
        const System& system = config.particles(s);
        const std::string path = join_path("", "particles", s);
        if (check_name(system.name(), "particle system", path, diagnostics) &&
            !names.insert(system.name()).second) {
            diagnostics.add(path + ".name", "'" + system.name() + "' is given twice");
        }
        if (system.emitter_size() == 0 && !system.has_burst()) {
            diagnostics.add(path, "has neither an emitter nor a burst: nothing is ever born");
        }
        const bool drag = system.drag_per_s() > 0.0 || system.quadratic_drag_per_m() > 0.0;
        if (system.has_wind() && !drag) {
            diagnostics.add(path + ".wind", "has no effect without drag_per_s");
        }
        for (int e = 0; e < system.emitter_size(); ++e) {
            check_emitter(config.world(),
                          system.emitter(e),
                          system.cosmetic(),
                          join_path(path, "emitter", e),
                          diagnostics);
        }
        check_burst(system.burst(), system.cosmetic(), path + ".burst", diagnostics);
        if (system.has_flock()) {
            check_flock(config.world(), system, path, diagnostics);
        } else if (system.cosmetic()) {
            check_cosmetic(system, path, diagnostics);
        }
    }
}

void expand_particles(const proto::config::Config& config, Settings& settings) {
    settings.particles.clear();
    settings.cosmetics.clear();
    settings.cosmetic_bursts.clear();
    for (int s = 0; s < config.particles_size(); ++s) {
        const System& system = config.particles(s);
        const Vec3 gravity(
            0.0F, narrow(-system.gravity_factor() * config.physics().gravity_mps2()), 0.0F);
        std::vector<motion::Emitter> emitters;
        std::vector<Vec3d> positions;
        for (int e = 0; e < system.emitter_size(); ++e) {
            const auto& emitter = system.emitter(e);
            const std::uint64_t place =
                (static_cast<std::uint64_t>(s) << 32U) | static_cast<std::uint64_t>(e);
            emitters.push_back(emitter_of(emitter, config.world().seed() ^ core::mix(place)));
            positions.emplace_back(emitter.x_m(), emitter.y_m(), emitter.z_m());
        }
        if (system.cosmetic()) {
            if (system.has_burst()) {
                settings.cosmetic_bursts.push_back(
                    {system.name(),
                     static_cast<std::uint32_t>(settings.cosmetics.size()),
                     *burst_of(system),
                     narrow(system.burst().aura_m()),
                     narrow(system.burst().events_per_s()),
                     system.burst().visibility_filter() == proto::config::LINE_OF_SIGHT});
            }
            settings.cosmetics.push_back({system.name(),
                                          gravity,
                                          narrow(system.drag_per_s()),
                                          wind_of(system),
                                          std::move(emitters),
                                          burst_of(system)});
            continue;
        }
        zone::ParticleSource source = source_of(system);
        source.def.gravity = gravity;
        if (system.has_flock()) {
            source.def.flock = flock_of(config.world(), system.flock());
        }
        source.emitters = std::move(emitters);
        source.positions = std::move(positions);
        settings.particles.push_back(std::move(source));
    }
}

std::size_t most_particles(const Settings& settings) {
    std::size_t most = 0;
    for (const zone::ParticleSource& source : settings.particles) {
        most += source.def.most;
    }
    return most;
}

}  // namespace zoned::config
