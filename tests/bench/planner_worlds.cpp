#include "tests/bench/planner_worlds.h"

#include "server/config/expand/load_settings.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace zoned::bench {

namespace {

const std::string kConfigs = ZONED_SOURCE_DIR "/config/";

std::string number(double value) {
    return std::to_string(value);
}

/// What all generated worlds have: level ground, players, and who walks.
std::string common_text(const std::string& name, double half_m, core::Rng& rng) {
    const std::string low = number(-half_m);
    const std::string high = number(half_m);
    return "world { name: \"" + name + "\" seed: " + std::to_string(rng.below(1000) + 1) +
           " min_x_m: " + low + " min_z_m: " + low + " max_x_m: " + high + " max_z_m: " + high +
           " }\nzones { zone_grid { columns: 1 rows: 1 } }\nspawn { x_m: 0 z_m: " +
           number(-0.9 * half_m) + " }\nspawn { x_m: " + number(-0.9 * half_m) +
           " z_m: 0 }\n"
           "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: "
           "80 aura_m { normal: 100 } nimbus_m { normal: 100 } max_acceleration_mps2: 20 "
           "max_velocity_jump_mps: 15 character { } }\n"
           "type { name: \"walker\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: "
           "70 aura_m { normal: 100 } character { speed_mps: " +
           number(rng.range(1.5F, 4.0F)) +
           " } brain: \"walk\" }\n"
           "brain { name: \"walk\" state { name: \"walk\" action: WANDER radius_m: 15 } }\n"
           "session { dev_mode_loopback: true }\nrewind { most_ms: 0 }\n";
}

std::string budget_text(core::Rng& rng, const std::string& parts) {
    return "budget { position_m: " + number(rng.range(0.02F, 0.2F)) +
           " time_s: " + number(rng.range(0.07F, 0.2F)) +
           " orientation_rad: " + number(rng.range(0.05F, 0.3F)) +
           " bytes_per_client_s: " + number(rng.range(16000.0F, 64000.0F)) + " viewers: 8 " +
           parts + "}\n";
}

std::string walkers(std::uint32_t count) {
    return "scatter { type: \"walker\" count: " + std::to_string(count) + " seed: 5 }\n";
}

/// Crates high in the air, with drag: they fall for seconds.
std::string flight(core::Rng& rng) {
    std::string out =
        "type { name: \"crate\" box { x_m: 0.6 y_m: 0.6 z_m: 0.6 } mass_kg: 10 "
        "aura_m { normal: 100 } drag_ps: " +
        number(rng.range(0.1F, 2.0F)) + " }\n";
    const std::uint32_t count = 60 + rng.below(60);
    for (std::uint32_t i = 0; i < count; ++i) {
        out += "entity { type: \"crate\" x_m: " + number(3.0 * (i % 10) - 15.0) +
               " y_m: " + number(rng.range(60.0F, 120.0F)) +
               " z_m: " + number(3.0 * static_cast<double>(i / 10) - 15.0) + " }\n";
    }
    return out;
}

/// Piles of boxes that touch.
std::string piles(core::Rng& rng) {
    std::string out =
        "type { name: \"block\" box { x_m: 1 y_m: 1 z_m: 1 } mass_kg: 20 "
        "aura_m { normal: 100 } }\nphysics { sleep_after_s: 0 }\n";
    const std::uint32_t columns = 12 + rng.below(12);
    for (std::uint32_t c = 0; c < columns; ++c) {
        const std::uint32_t high = 2 + rng.below(6);
        for (std::uint32_t k = 0; k < high; ++k) {
            out += "entity { type: \"block\" x_m: " + number(4.0 * (c % 6) - 12.0) +
                   " y_m: " + number(0.5 + k) +
                   " z_m: " + number(4.0 * static_cast<double>(c / 6) - 8.0) + " }\n";
        }
    }
    return out;
}

std::string crowd(core::Rng& rng) {
    return "ai { avoidance { } suspend_offscreen: false }\n" + walkers(100 + rng.below(100));
}

std::string cloths(core::Rng& rng) {
    std::string out =
        "type { name: \"curtain\" soft { cloth { width_m: 2 height_m: 2 columns: 9 rows: 9 "
        "stiffness_npm: " +
        number(rng.range(400.0F, 2000.0F)) +
        " shear_stiffness_npm: 300 bend_stiffness_npm: 10 pin { column: 0 row: 0 } pin { column: 8 "
        "row: 0 } } thickness_m: 0.03 drag_ps: 0.5 } mass_kg: 3 aura_m { normal: 100 } "
        "max_acceleration_mps2: 60 max_velocity_jump_mps: 25 }\n";
    const std::uint32_t count = 4 + rng.below(6);
    for (std::uint32_t i = 0; i < count; ++i) {
        out += "entity { type: \"curtain\" x_m: " + number(4.0 * i - 16.0) + " y_m: 3 z_m: 4 }\n";
    }
    return out;
}

std::string hail(core::Rng& rng) {
    return "particles { name: \"hail\" cosmetic: false emitter { x_m: 0 y_m: 20 z_m: 0 spread_m: 8 "
           "rate_hz: " +
           number(rng.range(200.0F, 800.0F)) +
           " pitch_deg: -90 cone_deg: 10 speed_min_mps: 5 speed_max_mps: 10 lifetime_min_s: 3 "
           "lifetime_max_s: 5 seed: 3 } drag_per_s: 0.1 quadratic_drag_per_m: 0.01 radius_m: 0.01 "
           "most: 8000 }\n";
}

PlannerWorld with_budgets(const std::string& name, std::vector<std::string> sets) {
    sets.push_back("budget.viewers=8");
    return {name, "", kConfigs + name + ".txtpb", std::move(sets)};
}

/// A world that has bounds of its own, without them.
PlannerWorld without_bounds(const std::string& name, std::vector<std::string> sets) {
    for (const char* bound : {"lod[0].position_bound_m=",
                              "lod[1].position_bound_m=",
                              "lod[0].orientation_bound_rad=",
                              "lod[1].orientation_bound_rad="}) {
        sets.emplace_back(bound);
    }
    return with_budgets(name, std::move(sets));
}

}  // namespace

std::vector<PlannerWorld> shipped_worlds() {
    return {without_bounds("minimal", {"budget.position_m=0.05", "budget.orientation_rad=0.1"}),
            with_budgets("solids", {"budget.position_m=0.04", "budget.orientation_rad=0.2"}),
            without_bounds(
                "cloth",
                {"budget.position_m=0.1", "budget.orientation_rad=0.2", "budget.soft_share=0.02"}),
            without_bounds(
                "weather",
                {"budget.position_m=0.1", "budget.orientation_rad=0.1", "budget.particles_m=0.5"}),
            without_bounds("circuit", {"budget.position_m=0.1", "budget.orientation_rad=0.2"}),
            without_bounds("arena", {"budget.position_m=0.03", "budget.orientation_rad=0.1"})};
}

std::vector<PlannerWorld> generated_worlds(std::uint64_t seed) {
    core::Rng rng(seed);
    std::vector<PlannerWorld> out;
    const auto add = [&](const std::string& name,
                         double half_m,
                         const std::string& what,
                         const std::string& parts = "") {
        const std::string common = common_text(name, half_m, rng);
        out.push_back({name, common + budget_text(rng, parts) + what, "", {}});
    };
    add("flight", 60.0, flight(rng));
    add("piles", 40.0, piles(rng) + walkers(10));
    add("crowd", 40.0, crowd(rng));
    add("soft", 40.0, cloths(rng) + walkers(6), "soft_share: 0.02 ");
    add("particles", 50.0, hail(rng) + walkers(20), "particles_m: 0.3 ");
    add("mixed",
        60.0,
        piles(rng) + crowd(rng) + cloths(rng) + hail(rng),
        "soft_share: 0.03 particles_m: 0.3 ");
    return out;
}

std::vector<PlannerWorld> all_shipped_worlds() {
    std::vector<PlannerWorld> out;
    for (const auto& entry : std::filesystem::directory_iterator(kConfigs)) {
        if (entry.path().extension() == ".txtpb") {
            out.push_back({entry.path().stem().string(), "", entry.path().string(), {}});
        }
    }
    std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    return out;
}

std::string try_settings(const PlannerWorld& world,
                         const std::vector<std::string>& more,
                         config::Settings& settings) {
    std::vector<std::string> sets = world.sets;
    sets.insert(sets.end(), more.begin(), more.end());
    std::vector<config::ConfigError> errors;
    const bool good = world.text.empty()
                          ? config::load_settings(world.file, sets, settings, errors)
                          : config::parse_settings(world.text, sets, settings, errors);
    return good ? "" : config::format_errors(world.name, errors);
}

config::Settings settings_of(const PlannerWorld& world, const std::vector<std::string>& more) {
    config::Settings settings;
    const std::string wrong = try_settings(world, more, settings);
    if (!wrong.empty()) {
        throw std::runtime_error(wrong);
    }
    return settings;
}

}  // namespace zoned::bench
