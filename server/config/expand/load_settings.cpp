#include "server/config/expand/load_settings.h"

#include "server/config/check/config_checks.h"
#include "server/config/expand/config_expand.h"
#include "server/config/expand/expand_server.h"
#include "server/config/expand/method_plan.h"
#include "server/config/expand/script_config.h"
#include "server/config/groups/group_config.h"
#include "server/config/groups/instance_config.h"
#include "server/config/npc/adaptation_config.h"
#include "server/config/npc/behaviours.h"
#include "server/config/npc/blends.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/fuzzy_config.h"
#include "server/config/npc/poi_config.h"
#include "server/config/npc/policies.h"
#include "server/config/plan/budget_plan.h"
#include "server/config/text/config_set.h"
#include "server/config/text/config_text.h"
#include "server/config/text/read_text.h"
#include "server/config/types/assembly_config.h"
#include "server/config/types/soft_mesh.h"
#include "server/config/world/environment_config.h"
#include "server/config/world/moving/door_config.h"
#include "server/config/world/moving/platform_config.h"
#include "server/config/world/particle_config.h"
#include "server/config/world/pathfinding_config.h"
#include "server/config/world/placed_joints.h"
#include "server/config/world/scatter.h"
#include "server/config/world/statics.h"
#include "server/config/world/surfaces.h"
#include "server/config/world/terrain.h"
#include "server/config/world/trigger_config.h"
#include "server/config/world/world_description.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/text_format.h>

#include <cstring>
#include <filesystem>

namespace zoned::config {

namespace {

using proto::config::Config;

/// Files that a config names are relative to the config's own folder.
void resolve(std::string& file, const std::filesystem::path& folder) {
    const std::filesystem::path path(file);
    if (!file.empty() && path.is_relative() && !folder.empty()) {
        file = (folder / path).lexically_normal().string();
    }
}

void resolve_files(const std::filesystem::path& folder, Config& config) {
    if (config.session().has_tls_certificate_file()) {
        resolve(*config.mutable_session()->mutable_tls_certificate_file(), folder);
    }
    if (config.session().has_tls_key_file()) {
        resolve(*config.mutable_session()->mutable_tls_key_file(), folder);
    }
    if (config.network().has_admin_certificate_file()) {
        resolve(*config.mutable_network()->mutable_admin_certificate_file(), folder);
    }
    if (config.network().has_admin_key_file()) {
        resolve(*config.mutable_network()->mutable_admin_key_file(), folder);
    }
    for (int k = 0; k < config.session().ticket_public_key_file_size(); ++k) {
        resolve(*config.mutable_session()->mutable_ticket_public_key_file(k), folder);
    }
    if (!folder.empty()) {
        std::string state = config.session().state_folder();  // the default too
        resolve(state, folder);
        config.mutable_session()->set_state_folder(state);
    }
    if (config.recording().has_file()) {
        resolve(*config.mutable_recording()->mutable_file(), folder);
    }
    if (config.store().has_file()) {
        resolve(*config.mutable_store()->mutable_file(), folder);
    }
    if (config.testing().travel().has_journal()) {
        resolve(*config.mutable_testing()->mutable_travel()->mutable_journal(), folder);
    }
    if (config.compute().has_cache_folder()) {
        resolve(*config.mutable_compute()->mutable_cache_folder(), folder);
    }
    for (int k = 0; k < config.statics().surface_size(); ++k) {
        if (config.statics().surface(k).has_file()) {
            resolve(*config.mutable_statics()->mutable_surface(k)->mutable_file(), folder);
        }
    }
    for (int k = 0; k < config.type_size(); ++k) {
        if (config.type(k).soft().mesh().has_file()) {
            resolve(*config.mutable_type(k)->mutable_soft()->mutable_mesh()->mutable_file(),
                    folder);
        }
    }
    if (config.script().has_file()) {
        resolve(*config.mutable_script()->mutable_file(), folder);
    }
    if (config.ai().pathfinding().has_waypoints_file()) {
        resolve(*config.mutable_ai()->mutable_pathfinding()->mutable_waypoints_file(), folder);
    }
    for (int k = 0; k < config.policy_size(); ++k) {
        if (config.policy(k).has_file()) {
            resolve(*config.mutable_policy(k)->mutable_file(), folder);
        }
    }
}

/// Relations and expansion. Values lie within their ranges by now, so nothing here can run wild.
/// `config` is that of the settings; `written`: the config with the contents of its files, before
/// brains are made of behaviours.
void check_and_expand(Config& config,
                      Config& written,
                      Settings& settings,
                      Diagnostics& diagnostics) {
    settings.surfaces = load_surfaces(config, diagnostics);
    note_soft_meshes(config);
    const Policies policies = load_policies(config, diagnostics);
    load_waypoints(config, diagnostics);
    settings.script = load_script(config, diagnostics);
    written = config;
    settings.zones = expand_zones(config, diagnostics);
    settings.parameters = build_behaviours(config, diagnostics);
    make_part_types(config, diagnostics);
    check_fuzzy(config, diagnostics);
    check_choices(config, diagnostics);
    check_points_of_interest(config, settings.zones, diagnostics);
    check_blends(config, diagnostics);
    check_brains(config, diagnostics);
    check_types(config, diagnostics);
    check_replication(config, settings.zones, diagnostics);
    check_physics(config, diagnostics);
    check_server(config, settings.zones, diagnostics);
    check_particles(config, diagnostics);
    check_shared_environment(config, diagnostics);
    check_ground_maps(config, settings.zones, diagnostics);
    expand_stages(config, settings);
    expand_assemblies(config, settings, diagnostics);
    settings.server = expand_server(config);
    settings.ai.points_of_interest.tracks = build_tracks(config, diagnostics);
    give_policies(config, policies, settings.ai.brains, diagnostics);
    expand_particles(config, settings);
    settings.environment = expand_shared_environment(config);
    settings.boxes = expand_statics(config, diagnostics);
    settings.doors = expand_doors(config, diagnostics);
    settings.platforms = expand_platforms(config, diagnostics);
    settings.triggers = expand_triggers(config, settings.types, diagnostics);
    settings.parties = expand_parties(config);
    settings.matches = expand_matches(config, diagnostics);
    const Terrain terrain(settings.boxes, settings.ground_height_m, settings.surfaces);
    settings.spawn_points.clear();
    settings.initial.clear();
    place_spawn_points(config, terrain, settings, diagnostics);
    place_entities(config, terrain, settings, diagnostics);
    place_joints(config, settings, diagnostics);
    expand_instances(config, settings, diagnostics);
    settings.methods.clear();
    if (diagnostics.empty()) {
        expand_adaptation(written, policies, settings, diagnostics);
    }
    if (diagnostics.empty()) {
        ai::compile(settings.ai, static_cast<float>(1.0 / settings.tick_rate_hz));
        plan_default_paths(settings);
        plan_methods(settings, diagnostics);
    }
}

bool parse_in_folder(const std::string& text,
                     const std::vector<std::string>& sets,
                     const std::filesystem::path& folder,
                     Settings& settings,
                     std::vector<ConfigError>& errors) {
    Diagnostics diagnostics;
    settings = Settings();
    const auto config = std::make_shared<Config>();
    settings.config = config;
    const bool complete = parse_config_text(text, *config, diagnostics);
    for (const std::string& set : sets) {
        apply_set(set, *config, diagnostics);
    }
    resolve_files(folder, *config);
    std::vector<MethodPlan> budgets;
    if (complete && diagnostics.empty()) {
        budgets = plan_budgets(*config, diagnostics);
    }
    check_ranges(*config, complete, diagnostics);
    Config written;
    if (complete) {
        diagnostics.silence_reported_lines();
        check_and_expand(*config, written, settings, diagnostics);
    }
    errors = diagnostics.sorted();
    if (!errors.empty()) {
        return false;
    }
    settings.methods.insert(settings.methods.begin(), budgets.begin(), budgets.end());
    settings.budgets = world_budgets(*config);
    google::protobuf::TextFormat::PrintToString(written, &settings.text);
    settings.digest = world_digest(settings);
    return true;
}

}  // namespace

bool load_settings(const std::string& file,
                   const std::vector<std::string>& sets,
                   Settings& settings,
                   std::vector<ConfigError>& errors) {
    std::string text;
    const std::string wrong = read_text(file, text);
    if (!wrong.empty()) {
        errors = {{0, 0, "", wrong}};
        return false;
    }
    return parse_in_folder(text, sets, std::filesystem::path(file).parent_path(), settings, errors);
}

bool parse_settings(const std::string& text,
                    const std::vector<std::string>& sets,
                    Settings& settings,
                    std::vector<ConfigError>& errors) {
    return parse_in_folder(text, sets, {}, settings, errors);
}

}  // namespace zoned::config
