// Suite `representation`: the error and the saving of far props simulated as less than they are;
// zones step, no player is near.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/physics/method_selection/cost_table.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/simulation/representation.h"
#include "tests/bench/comparison.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace zoned::bench {

namespace {

using physics::method_selection::kSingleErrorShare;
using physics::method_selection::kSoftHullErrorShare;

constexpr int kTicks = 150;       ///< 5 s
constexpr int kFlightTicks = 15;  ///< 0.5 s: nothing has landed yet

/// A grid of props of one type, each thrown in a direction of its own.
struct Throw {
    std::string name;
    std::string shape;    ///< of the type, in the config's words
    std::string reduced;  ///< the permitted error and its kind, in the config's words
    double height_m = 0.0;
    float speed_mps = 0.0F;
    double share_in_table = 0.0;  ///< of cost_table.h, for error_max_share; 0: none there
    int side = 8;                 ///< props along each edge of the grid
};

const std::string kTable = R"(compound {
    part { box { x_m: 1.6 y_m: 0.06 z_m: 0.9 } y_m: 0.74 density_kgpm3: 700 }
    part { box { x_m: 0.06 y_m: 0.71 z_m: 0.06 } x_m: 0.7 y_m: 0.355 z_m: 0.35 density_kgpm3: 7800 }
    part { box { x_m: 0.06 y_m: 0.71 z_m: 0.06 } x_m: 0.7 y_m: 0.355 z_m: -0.35 density_kgpm3: 7800 }
    part { box { x_m: 0.06 y_m: 0.71 z_m: 0.06 } x_m: -0.7 y_m: 0.355 z_m: 0.35 density_kgpm3: 7800 }
    part { box { x_m: 0.06 y_m: 0.71 z_m: 0.06 } x_m: -0.7 y_m: 0.355 z_m: -0.35 density_kgpm3: 7800 }
  })";
const std::string kJelly =
    "soft { jelly { size { x_m: 1 y_m: 0.8 z_m: 1 } stiffness_npm: 600 bulk_modulus_pa: 4000 } "
    "thickness_m: 0.03 damping: 0.5 }";
const std::string kRope =
    "soft { rope { length_m: 2.5 nodes: 14 stiffness_npm: 8000 bend_stiffness_npm: 5 level: true "
    "pin_first: false } "
    "thickness_m: 0.05 drag_ps: 0.3 }";

config::Settings settings_of(const Throw& scene, bool reduced) {
    std::string text =
        "world { name: \"far\" min_x_m: -100 min_z_m: -100 max_x_m: 100 max_z_m: 100 }\n"
        "zones { zone_grid { columns: 1 rows: 1 } }\n"
        "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } "
        "character { } }\n"
        "spawn { x_m: 90 z_m: 90 }\n"
        "lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }\n"
        "session { dev_mode_loopback: true }\n"
        "type { name: \"prop\" mass_kg: 20 " +
        scene.shape + (reduced ? " representation { " + scene.reduced + " }" : "") + " }\n";
    for (int i = 0; i < scene.side * scene.side; ++i) {
        const double x = 8.0 * (i % scene.side - 0.5 * (scene.side - 1));
        const double z = 8.0 * (i / scene.side - 0.5 * (scene.side - 1));
        text += "entity { type: \"prop\" x_m: " + std::to_string(x) +
                " y_m: " + std::to_string(scene.height_m) + " z_m: " + std::to_string(z) + " }\n";
    }
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(text, {}, settings, errors)) {
        throw std::runtime_error(config::format_errors("representation", errors));
    }
    return settings;
}

struct Pose {
    Vec3 position;
    Quat orientation;
};

/// A world of one zone, thrown at its first tick.
class FarWorld {
  public:
    FarWorld(const Throw& scene, bool reduced) : world_(settings_of(scene, reduced), 1) {
        tick();
        zone::ZoneContext context(state());
        const std::vector<EntityId> ids = state().entities.id;
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const auto turn = 2.4F * static_cast<float>(i);  // the golden angle: no two alike
            context.add_velocity(ids[i],
                                 scene.speed_mps * Vec3(std::cos(turn), 0.3F, std::sin(turn)));
        }
    }

    /// Of the sphere that holds a prop, m.
    [[nodiscard]] double diameter_m() const {
        const world::TypeTable& types = *world_.zones()[0]->state().settings.types;
        return 2.0 * static_cast<double>(types.back().extent());
    }

    void tick() {
        out_.clear();
        world_.tick({}, out_);
    }

    /// In the order of the entities' ids.
    [[nodiscard]] std::vector<Pose> poses() const {
        const world::Entities& e = world_.zones()[0]->state().entities;
        std::vector<std::pair<EntityId, Pose>> all;
        for (world::Row row = 0; row < e.size(); ++row) {
            all.push_back({e.id[row], {e.position[row], e.orientation[row]}});
        }
        std::sort(
            all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        std::vector<Pose> out;
        for (const auto& [id, pose] : all) {
            out.push_back(pose);
        }
        return out;
    }

    [[nodiscard]] double awake_share() const {
        const world::Entities& e = world_.zones()[0]->state().entities;
        std::size_t awake = 0;
        for (world::Row row = 0; row < e.size(); ++row) {
            awake += e.has(row, world::kAtRest) ? 0 : 1;
        }
        return static_cast<double>(awake) / static_cast<double>(std::max<std::size_t>(e.size(), 1));
    }

    /// Share of the props with a reduced representation.
    [[nodiscard]] double reduced_share() const {
        const world::Entities& e = world_.zones()[0]->state().entities;
        std::size_t reduced = 0;
        for (world::Row row = 0; row < e.size(); ++row) {
            reduced += e.representation[row] != 0 ? 1 : 0;
        }
        return static_cast<double>(reduced) /
               static_cast<double>(std::max<std::size_t>(e.size(), 1));
    }

  private:
    zone::ZoneState& state() { return world_.zones()[0]->state(); }

    app::World world_;
    std::vector<mailbox::OutboxItem> out_;
};

/// The full simulation, tick by tick.
using Truth = std::vector<std::vector<Pose>>;

Truth truth_of(const Throw& scene, int ticks) {
    FarWorld world(scene, false);
    Truth truth;
    for (int i = 0; i < ticks; ++i) {
        world.tick();
        truth.push_back(world.poses());
    }
    return truth;
}

class FarTrial : public JudgedTrial {
  public:
    FarTrial(const Throw& scene, bool reduced, const Truth& truth)
        : world_(scene, reduced),
          truth_(truth),
          share_(scene.share_in_table) {}

    void frame() override { world_.tick(); }

    void observe() override {
        const std::vector<Pose>& full = truth_[tick_];
        const std::vector<Pose> now = world_.poses();
        sum_ = largest_ = turned_ = 0.0;
        for (std::size_t i = 0; i < now.size(); ++i) {
            const auto off = static_cast<double>((now[i].position - full[i].position).norm());
            sum_ += off;
            largest_ = std::max(largest_, off);
            turned_ = std::max(
                turned_,
                static_cast<double>(now[i].orientation.angularDistance(full[i].orientation)));
        }
        if (++tick_ <= kFlightTicks) {
            in_flight_ = std::max(in_flight_, largest_);
        }
        reduced_ = std::max(reduced_, world_.reduced_share());
    }

    void judge(Row& row) override {
        row.error = sum_ / static_cast<double>(truth_.front().size());
        row.error_unit = "m";
        row.metric("error_max_m", largest_);
        row.metric("error_max_share", largest_ / world_.diameter_m());
        if (share_ > 0.0) {
            row.metric("error_max_share_table", share_);
        }
        row.metric("error_flight_m", in_flight_);
        row.metric("turn_error_max_rad", turned_);
        row.metric("reduced_share", reduced_);
        row.metric("awake_share", world_.awake_share());
    }

  private:
    FarWorld world_;
    const Truth& truth_;
    double share_;
    std::size_t tick_ = 0;
    double sum_ = 0.0;
    double largest_ = 0.0;
    double turned_ = 0.0;
    double in_flight_ = 0.0;
    double reduced_ = 0.0;
};

void run_representation(Session& session) {
    session.note(
        "representation: 64 props thrown, nobody within sight; a frame is a tick of 1/30 s. The "
        "error is the mean distance from the full simulation after 5 s");
    const std::vector<Throw> scenes{
        {"tables_as_hulls", kTable, "single_beyond_m: 1", 4.0, 4.0F, kSingleErrorShare},
        {"tables_as_points", kTable, "particle_beyond_m: 1", 4.0, 4.0F},
        {"jellies_as_hulls", kJelly, "single_beyond_m: 1", 4.0, 4.0F, kSoftHullErrorShare},
        {"ropes_as_hulls", kRope, "single_beyond_m: 1", 4.0, 4.0F, kSoftHullErrorShare}};
    for (Throw scene : scenes) {
        if (!session.wants_scene(scene.name)) {
            continue;
        }
        scene.side = session.quick ? 3 : scene.side;
        const int ticks = session.quick ? 30 : kTicks;
        session.progress("representation " + scene.name);
        const Truth truth = truth_of(scene, ticks);
        const auto as = [&](const char* name, bool reduced) {
            return Method{name, "", [&scene, &truth, reduced] {
                              return std::make_unique<FarTrial>(scene, reduced, truth);
                          }};
        };
        session.add(compare("representation",
                            scene.name,
                            "",
                            wanted(session, {as("default", true), as("full", false)}),
                            {0, ticks, session.quick ? 1 : session.repeats}));
    }
}

const Registration kRepresentation(
    {"representation",
     "props far from players as less than they are: error and time against the full simulation",
     {"tables_as_hulls", "tables_as_points", "jellies_as_hulls", "ropes_as_hulls"},
     {"default", "full"},
     run_representation});

}  // namespace

}  // namespace zoned::bench
