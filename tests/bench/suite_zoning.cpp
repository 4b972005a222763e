// Suite `zoning`: what borders between zones cost, and how far a world in several zones strays from
// the same world in one.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace zoned::bench {

namespace {

/// Where a thing is put, which is its name over worlds of any number of zones, and how it moves.
struct Thrown {
    Vec3d position = Vec3d::Zero();
    Vec3 velocity = Vec3::Zero();
};

struct ZoningScene {
    std::string name;
    std::string type;
    std::vector<Thrown> things;
    double seconds = 5.0;
};

/// Things of a scene after a while, in its order, and what that took.
struct ZoningOutcome {
    std::vector<Vec3d> position;
    Vec3d momentum = Vec3d::Zero();  ///< per mass, m/s
    std::vector<double> tick_us;     ///< CPU time of all zones
    std::uint64_t handoffs = 0;
    std::size_t ghosts = 0;  ///< most at a time
};

constexpr double kHalf_m = 60.0;
constexpr double kHeight_m = 100.0;  ///< of what must not touch the ground

/// Balls that roll across x = 0, each in a lane of its own.
ZoningScene crossing(int count) {
    core::Rng rng(11);
    ZoningScene scene{"crossing", "ball", {}, 5.0};
    for (int i = 0; i < count; ++i) {
        const double lane_m = -50.0 + 100.0 * i / count;
        const float speed = rng.range(2.0F, 8.0F);
        const double begin_m = -static_cast<double>(speed) * rng.range(0.5F, 3.0F);
        scene.things.push_back({{begin_m, 0.5, lane_m}, {speed, 0.0F, 0.0F}});
    }
    return scene;
}

/// Pairs of balls that meet at x = 0 in flight. Nothing else acts on them but gravity, so their
/// momentum along the level is kept.
ZoningScene collisions(int pairs) {
    core::Rng rng(12);
    ZoningScene scene{"collision", "ball", {}, 2.0};
    for (int i = 0; i < pairs; ++i) {
        const double lane_m = -50.0 + 100.0 * i / pairs;
        const float speed = rng.range(2.0F, 8.0F);
        const double begin_m = 0.5 + static_cast<double>(speed);
        const double beside_m = rng.range(-0.3F, 0.3F);
        scene.things.push_back({{-begin_m, kHeight_m, lane_m}, {speed, 0.0F, 0.0F}});
        scene.things.push_back({{begin_m, kHeight_m, lane_m + beside_m}, {-speed, 0.0F, 0.0F}});
    }
    return scene;
}

/// Piles of boxes that stand on the border.
ZoningScene piles(int count) {
    ZoningScene scene{"pile", "crate", {}, 5.0};
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < 5; ++k) {
            scene.things.push_back(
                {{k % 2 == 0 ? 0.2 : -0.2, 0.5 + k, -50.0 + 100.0 * i / count}, Vec3::Zero()});
        }
    }
    return scene;
}

std::string config_of(const ZoningScene& scene, int zones) {
    std::ostringstream text;
    text << "world { name: \"zoning\" seed: 7 tick_rate_hz: 30 min_x_m: " << -kHalf_m
         << " min_z_m: " << -kHalf_m << " max_x_m: " << kHalf_m << " max_z_m: " << kHalf_m
         << " }\nzones { zone_grid { columns: " << zones
         << " rows: 1 } ghost_margin_m: 25 handoff_hysteresis_m: 1 }\n"
         << "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } "
            "mass_kg: 80 aura_m { normal: 20 } nimbus_m { normal: 20 } character { } }\n"
         << "type { name: \"ball\" sphere { radius_m: 0.5 } mass_kg: 2 aura_m { normal: 20 } }\n"
         << "type { name: \"crate\" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 10 aura_m { normal: 20 } "
            "}\n"
         << "session { dev_mode_loopback: true }\nspawn { x_m: 0 z_m: 55 }\n"
         << "lod { position_bound_m: 0.05 orientation_bound_rad: 0.1 }\n";
    for (const Thrown& thing : scene.things) {
        text << "entity { type: \"" << scene.type << "\" x_m: " << thing.position.x()
             << " y_m: " << thing.position.y() << " z_m: " << thing.position.z() << " }\n";
    }
    return text.str();
}

/// Gives the things their velocities; by entity, their places in the scene.
std::map<EntityId, std::size_t> throw_things(const ZoningScene& scene, app::World& world) {
    std::map<EntityId, std::size_t> thrown;
    for (const auto& zone : world.zones()) {
        const world::Entities& e = zone->state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const Vec3d at =
                zone->state().settings.region().origin() + e.position[row].cast<double>();
            for (std::size_t i = 0; i < scene.things.size(); ++i) {
                if ((scene.things[i].position - at).norm() < 1e-2) {
                    zone::ZoneContext(zone->state())
                        .add_velocity(e.id[row], scene.things[i].velocity);
                    thrown.emplace(e.id[row], i);
                }
            }
        }
    }
    if (thrown.size() != scene.things.size()) {
        throw std::runtime_error("zoning: things lie where they were not placed");
    }
    return thrown;
}

ZoningOutcome run_zones(const ZoningScene& scene, int zones, bool quick) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(config_of(scene, zones), {}, settings, errors)) {
        throw std::runtime_error("zoning: " + config::format_errors(scene.name, errors));
    }
    app::World world(settings, 1);
    const std::map<EntityId, std::size_t> thrown = throw_things(scene, world);
    ZoningOutcome out;
    out.position.resize(scene.things.size());
    std::vector<mailbox::OutboxItem> items;
    const auto ticks = static_cast<int>((quick ? 1.5 : scene.seconds) * settings.tick_rate_hz);
    for (int t = 0; t < ticks; ++t) {
        items.clear();
        const std::int64_t before = thread_cpu_ns();
        world.tick({}, items);
        out.tick_us.push_back(1e-3 * static_cast<double>(thread_cpu_ns() - before));
        std::size_t ghosts = 0;
        for (const auto& zone : world.zones()) {
            ghosts += zone->report().census.ghosts;
        }
        out.ghosts = std::max(out.ghosts, ghosts);
    }
    out.handoffs = world.handoffs();
    for (const auto& zone : world.zones()) {
        const world::Entities& e = zone->state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            const auto it = thrown.find(e.id[row]);
            if (it != thrown.end() && !e.has(row, world::kGhost)) {
                out.position[it->second] =
                    zone->state().settings.region().origin() + e.position[row].cast<double>();
                out.momentum += e.velocity[row].cast<double>();
            }
        }
    }
    return out;
}

void run_zoning_scene(Session& session, const ZoningScene& scene) {
    session.progress("zoning " + scene.name);
    double moving_mps = 0.0;
    for (const Thrown& thing : scene.things) {
        moving_mps += static_cast<double>(thing.velocity.norm());
    }
    std::vector<Row> rows;
    ZoningOutcome one;
    for (const int zones : {1, 2, 4}) {
        const ZoningOutcome out = run_zones(scene, zones, session.quick);
        if (zones == 1) {
            one = out;
        }
        Row row;
        row.suite = "zoning";
        row.scene = scene.name;
        row.method = "default";
        row.parameter = "zones=" + std::to_string(zones);
        row.time_us_p50 = median(out.tick_us);
        row.time_us_p99 = quantile(out.tick_us, 0.99);
        row.error_unit = "m from one zone";
        for (std::size_t i = 0; i < out.position.size(); ++i) {
            row.error = std::max(row.error, (out.position[i] - one.position[i]).norm());
        }
        row.metric("handoffs", static_cast<double>(out.handoffs));
        row.metric("ghosts", static_cast<double>(out.ghosts));
        row.metric("time_over_one_zone", median(out.tick_us) / median(one.tick_us));
        if (moving_mps > 0.0) {
            row.metric("momentum_off_share", (out.momentum - one.momentum).norm() / moving_mps);
        }
        rows.push_back(row);
    }
    session.add(rows);
}

void run_zoning(Session& session) {
    if (!session.wants_method("default", "")) {
        return;
    }
    const int many = session.quick ? 8 : 40;
    for (const ZoningScene& scene : {crossing(many), collisions(many), piles(many / 2)}) {
        if (session.wants_scene(scene.name)) {
            run_zoning_scene(session, scene);
        }
    }
    session.note(
        "zoning: things on borders of zones beside the same things in one zone, all in one thread; "
        "the error is the farthest that one is from where it is in one zone");
}

const Registration kZoning({"zoning",
                            "what borders of zones cost, and how far physics strays across them",
                            {"crossing", "collision", "pile"},
                            {"default"},
                            run_zoning});

}  // namespace

}  // namespace zoned::bench
