#include "server/config/expand/config_expand.h"

#include "server/config/expand/method_plan.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/poi_config.h"
#include "server/config/settings.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/deformation_config.h"
#include "server/config/types/field_config.h"
#include "server/config/types/soft_types.h"
#include "server/config/types/stances.h"
#include "server/config/types/type_shapes.h"
#include "server/config/world/pathfinding_config.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace zoned::config {

namespace {

std::array<float, world::kStances> expand_radii(const proto::config::Config& config,
                                                const proto::config::Radii& radii) {
    std::array<float, world::kStances> out{};
    out.fill(narrow(radii.normal()));
    if (radii.has_idle()) {
        out[static_cast<std::size_t>(world::Stance::kIdle)] = narrow(radii.idle());
    }
    if (radii.has_running()) {
        out[static_cast<std::size_t>(world::Stance::kRunning)] = narrow(radii.running());
    }
    if (radii.has_riding()) {
        out[static_cast<std::size_t>(world::Stance::kRiding)] = narrow(radii.riding());
    }
    for (const auto& named : radii.named()) {
        const int stance = find_stance(config, named.stance());
        if (stance >= 0) {  // else check_types says so, and nobody uses the settings
            out[static_cast<std::size_t>(stance)] = narrow(named.radius_m());
        }
    }
    return out;
}

std::array<world::Cone, world::kStances> expand_cones(const proto::config::Config& config,
                                                      const proto::config::Radii& radii) {
    std::array<world::Cone, world::kStances> out{};
    for (const auto& named : radii.named()) {
        const int stance = find_stance(config, named.stance());
        if (stance >= 0 && named.has_cone()) {
            out[static_cast<std::size_t>(stance)] = {
                narrow(named.cone().length_m()),
                narrow(named.cone().half_angle_deg() * std::numbers::pi / 180.0)};
        }
    }
    return out;
}

motion::CharacterLimits expand_character(const proto::config::Config& config,
                                         const proto::config::Type& type) {
    const auto& character = type.character();
    motion::CharacterLimits out;
    out.radius = narrow(type.capsule().radius_m());
    out.half_segment = narrow(0.5 * type.capsule().length_m());
    out.speed = narrow(character.speed_mps());
    out.sprint_factor = narrow(character.sprint_factor());
    out.acceleration = narrow(character.acceleration_mps2());
    out.air_acceleration = narrow(character.air_acceleration_mps2());
    out.jump_speed = narrow(character.jump_speed_mps());
    out.max_slope_cos =
        narrow(elementary::cos(character.max_slope_deg() * std::numbers::pi / 180.0));
    out.step_down = narrow(character.step_down_m());
    out.step_up = narrow(character.step_up_m());
    out.gravity = narrow(config.physics().gravity_mps2());
    return out;
}

std::uint16_t brain_of(const proto::config::Config& config, const std::string& brain) {
    for (int m = 0; m < config.brain_size(); ++m) {
        if (!brain.empty() && config.brain(m).name() == brain) {
            return static_cast<std::uint16_t>(m + 1);
        }
    }
    return 0;
}

void expand_solid(const proto::config::Config& config,
                  const proto::config::Type& type,
                  world::EntityType& out,
                  Settings& settings) {
    const auto solid = build_solid(type);
    if (!solid) {
        return;  // check_types says why, and nobody uses the settings
    }
    out.shape = world::TypeShape::kSolid;
    out.radius = solid->radius;
    out.stands = solid->stands;
    out.standing = solid->standing;
    out.solid = static_cast<std::uint16_t>(settings.solids.size());
    settings.solids.push_back(solid->shape);
    out.single_beyond_m = narrow(single_beyond_m(config, type, out.radius, false));
    settings.outers.push_back(out.single_beyond_m > 0.0F ? solid->outer : physics::Shape());
}

void expand_soft(const proto::config::Config& config,
                 const proto::config::Type& type,
                 world::EntityType& out,
                 Settings& settings) {
    auto soft = build_soft(type);
    if (!soft) {
        return;  // as above
    }
    out.shape = world::TypeShape::kSoft;
    out.radius = soft->radius;
    out.half_extents = soft->box.lower.cwiseAbs().cwiseMax(soft->box.upper);
    out.standing = soft->box;
    out.solid = static_cast<std::uint16_t>(settings.softs.size());
    const auto& nodes = soft->def.nodes;
    const bool pinned =
        std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.pinned; });
    out.single_beyond_m = narrow(single_beyond_m(config, type, out.radius, pinned));
    out.deformation = expand_deformation(type, *soft);
    settings.softs.push_back(std::make_shared<const physics::soft::SoftDef>(std::move(soft->def)));
}

world::EntityType expand_type(const proto::config::Config& config,
                              const proto::config::Type& type,
                              Settings& settings) {
    world::EntityType out;
    out.name = type.name();
    out.rewindable = type.rewindable();
    out.visibility_filter = static_cast<world::VisibilityFilter>(type.visibility_filter());
    if (type.kind() == proto::config::CHARACTER) {
        out.kind = world::EntityKind::kCharacter;
        out.character = expand_character(config, type);
    }
    if (type.has_box()) {
        out.shape = world::TypeShape::kBox;
        out.half_extents = Vec3(narrow(0.5 * type.box().x_m()),
                                narrow(0.5 * type.box().y_m()),
                                narrow(0.5 * type.box().z_m()));
    } else if (type.has_sphere()) {
        out.shape = world::TypeShape::kSphere;
        out.radius = narrow(type.sphere().radius_m());
    } else if (type.has_capsule()) {
        out.shape = world::TypeShape::kCapsule;
        out.radius = narrow(type.capsule().radius_m());
        out.half_segment = narrow(0.5 * type.capsule().length_m());
    } else if (type.has_soft()) {
        expand_soft(config, type, out, settings);
    } else {
        expand_solid(config, type, out, settings);
    }
    out.mass = narrow(type.mass_kg());
    out.inertia = given_inertia(type, out.stands);
    out.friction = narrow(type.friction());
    out.restitution = narrow(type.restitution());
    out.rolling_m = narrow(type.rolling_friction_m());
    out.spinning_m = narrow(type.spinning_friction_m());
    out.drag = narrow(type.drag_ps());
    out.angular_drag = narrow(type.angular_drag_ps());
    out.aura_m = expand_radii(config, type.aura_m());
    out.nimbus_m = expand_radii(config, type.nimbus_m());
    out.nimbus_cone = expand_cones(config, type.nimbus_m());
    out.max_acceleration_mps2 = narrow(type.max_acceleration_mps2());
    out.max_velocity_jump_mps = narrow(type.max_velocity_jump_mps());
    out.priority = narrow(type.priority());
    out.particle_beyond_m = narrow(type.representation().particle_beyond_m());
    out.brain = brain_of(config, type.brain());
    expand_fields(config, type, out);
    out.lever = expand_lever(type);
    return out;
}

// The enums of the config and of the stages have the same numbers, so that casts are exact.
static_assert(static_cast<int>(world::Stance::kRiding) == proto::config::RIDING);
static_assert(static_cast<int>(world::VisibilityFilter::kRules) == proto::config::RULES);

/// Steps of rates that are not set follow from the nearest level's bounds; publications are half a
/// heartbeat apart in the mean where prediction is at its best.
wire::Quantization expand_quantization(const proto::config::Config& config) {
    const auto& q = config.replication().quantization();
    const double horizon_s =
        0.5 * config.replication().heartbeat_ticks() / config.world().tick_rate_hz();
    const auto& nearest =
        config.lod_size() > 0 ? config.lod(0) : proto::config::Lod::default_instance();
    const wire::RateSteps steps = wire::rate_steps(narrow(nearest.position_bound_m()),
                                                   narrow(nearest.orientation_bound_rad()),
                                                   narrow(horizon_s));
    wire::Quantization out;
    out.position_step_m = narrow(q.position_step_m());
    out.velocity_step_mps =
        q.has_velocity_step_mps() ? narrow(q.velocity_step_mps()) : steps.velocity_mps;
    out.acceleration_step_mps2 = q.has_acceleration_step_mps2() ? narrow(q.acceleration_step_mps2())
                                                                : steps.acceleration_mps2;
    out.angular_velocity_step_rps = q.has_angular_velocity_step_rps()
                                        ? narrow(q.angular_velocity_step_rps())
                                        : steps.angular_velocity_rps;
    out.orientation_bits = static_cast<int>(q.orientation_bits());
    out.yaw_bits = static_cast<int>(q.yaw_bits());
    out.horizontal_extent_m = narrow(q.horizontal_extent_m());
    out.vertical_extent_m = narrow(q.vertical_extent_m());
    out.max_speed_mps = narrow(q.max_speed_mps());
    return out;
}

void expand_replication(const proto::config::Config& config,
                        replication::ReplicationSettings& out) {
    const auto& from = config.replication();
    out.quantization = expand_quantization(config);
    out.quantization.gravity_mps2 = narrow(config.physics().gravity_mps2());
    out.lods.clear();
    for (const auto& lod : config.lod()) {
        out.lods.push_back({narrow(lod.position_bound_m()), narrow(lod.orientation_bound_rad())});
    }
    for (std::size_t i = 1; i < out.lods.size(); ++i) {
        out.quantization.lod_shift[i] = wire::lod_shift(out.lods[0].position_m,
                                                        out.lods[0].orientation_rad,
                                                        out.lods[i].position_m,
                                                        out.lods[i].orientation_rad);
    }
    out.heartbeat_ticks = from.heartbeat_ticks();
    out.keyframe_every = from.keyframe_every();
    out.budget_bytes_per_s = from.budget_bytes_per_s();
    out.own_state_every_ticks = from.own_state_every_ticks();
    out.silence_ticks = from.has_silence_ticks()
                            ? from.silence_ticks()
                            : usual_silence_ticks(config.world().tick_rate_hz());
    out.tick_s = narrow(1.0 / config.world().tick_rate_hz());
    out.forced_order = static_cast<int>(from.predictor()) - 1;
    out.redundancy_target = narrow(from.redundancy_target());
    out.codec = static_cast<replication::Codec>(from.codec());
    out.codec_budget_us = from.codec_budget_us_per_tick();
    out.meter = from.bandwidth_meter();
    out.resend = !config.testing().never_again();
}

/// The enumerations of the schema list their values in the engine's order: see the checks below.
void expand_methods(const proto::config::MethodParameters& from, physics::VariantSettings& out) {
    out.iterations = static_cast<int>(from.iterations());
    out.tolerance_mps = narrow(from.tolerance_mps());
    out.omega = narrow(from.omega());
    out.shuffle = from.shuffle();
    out.warm_start = from.warm_start();
    out.direct_rows = static_cast<int>(from.direct_rows());
    out.friction = static_cast<physics::FrictionModel>(from.friction());
    out.manifold = static_cast<physics::ManifoldMode>(from.manifold());
    out.stabilisation = static_cast<physics::Stabilisation>(from.stabilisation());
    out.beta = narrow(from.beta());
    out.soft_hz = narrow(from.soft_hz());
    out.soft_damping_ratio = narrow(from.soft_damping_ratio());
    out.push_speed_mps = narrow(from.push_speed_mps());
    out.slop_m = narrow(from.slop_m());
    out.penalty_share = narrow(from.penalty_share());
    out.penalty_damping_ratio = narrow(from.penalty_damping_ratio());
    out.penalty_integrator = static_cast<physics::PenaltyIntegrator>(from.penalty_integrator());
}

template <class Ours>
constexpr bool same(int theirs, Ours ours) {
    return theirs == static_cast<int>(ours);
}

static_assert(same(proto::config::SHARED, replication::Codec::kShared) &&
              same(proto::config::PER_CLIENT, replication::Codec::kPerClient) &&
              same(proto::config::AUTO, replication::Codec::kAuto));
static_assert(same(proto::config::SOFT_STEP, physics::SolverVariant::kSoftStep) &&
              same(proto::config::JACOBI, physics::SolverVariant::kJacobi) &&
              same(proto::config::GAUSS_SEIDEL, physics::SolverVariant::kGaussSeidel) &&
              same(proto::config::OVER_RELAXATION, physics::SolverVariant::kOverRelaxation) &&
              same(proto::config::CONJUGATE_GRADIENT, physics::SolverVariant::kConjugateGradient) &&
              same(proto::config::DIRECT, physics::SolverVariant::kDirect) &&
              same(proto::config::IMPULSE, physics::SolverVariant::kImpulse) &&
              same(proto::config::PROJECTION, physics::SolverVariant::kProjection) &&
              same(proto::config::PENALTY, physics::SolverVariant::kPenalty));
static_assert(same(proto::config::CONE, physics::FrictionModel::kCone) &&
              same(proto::config::PYRAMID, physics::FrictionModel::kPyramid) &&
              same(proto::config::WEIGHT, physics::FrictionModel::kWeight));
static_assert(same(proto::config::POINTS, physics::ManifoldMode::kPoints) &&
              same(proto::config::DIVIDED, physics::ManifoldMode::kDivided));
static_assert(same(proto::config::BAUMGARTE, physics::Stabilisation::kBaumgarte) &&
              same(proto::config::SOFT, physics::Stabilisation::kSoft) &&
              same(proto::config::SPLIT, physics::Stabilisation::kSplit));
static_assert(same(proto::config::SEMI_IMPLICIT_EULER,
                   physics::PenaltyIntegrator::kSemiImplicitEuler) &&
              same(proto::config::VELOCITY_VERLET, physics::PenaltyIntegrator::kVelocityVerlet));

static_assert(same(proto::config::AUTOMATIC, physics::BroadphaseKind::kAutomatic) &&
              same(proto::config::ALL_PAIRS, physics::BroadphaseKind::kAllPairs) &&
              same(proto::config::GRID, physics::BroadphaseKind::kGrid) &&
              same(proto::config::OCTREE, physics::BroadphaseKind::kOctree) &&
              same(proto::config::QUADTREE, physics::BroadphaseKind::kQuadtree) &&
              same(proto::config::SORT_AND_SWEEP, physics::BroadphaseKind::kSortAndSweep) &&
              same(proto::config::TREE, physics::BroadphaseKind::kTree));

using Flight = proto::config::Physics;
static_assert(same(Flight::DEFAULT, physics::IntegratorKind::kDefault) &&
              same(Flight::EXPLICIT_EULER, physics::IntegratorKind::kExplicitEuler) &&
              same(Flight::IMPLICIT_EULER, physics::IntegratorKind::kImplicitEuler) &&
              same(Flight::SEMI_IMPLICIT_EULER, physics::IntegratorKind::kSemiImplicitEuler) &&
              same(Flight::VERLET, physics::IntegratorKind::kVerlet) &&
              same(Flight::VELOCITY_VERLET, physics::IntegratorKind::kVelocityVerlet) &&
              same(Flight::RK2, physics::IntegratorKind::kRk2) &&
              same(Flight::RK4, physics::IntegratorKind::kRk4) &&
              same(Flight::ADAPTIVE, physics::IntegratorKind::kAdaptive));

void expand_physics(const proto::config::Physics& from, physics::PhysicsSettings& out) {
    out.gravity = Vec3(0.0F, -narrow(from.gravity_mps2()), 0.0F);
    out.substeps = static_cast<int>(from.substeps());
    out.velocity_iterations = static_cast<int>(from.velocity_iterations());
    out.error_budget_m = narrow(from.error_budget_m());
    out.sleep_speed_mps = narrow(from.sleep_speed_mps());
    out.sleep_spin_rps = narrow(from.sleep_spin_rps());
    out.sleep_after_s = narrow(from.sleep_after_s());
    out.broadphase = static_cast<physics::BroadphaseKind>(from.broadphase());
    out.cell_m = narrow(from.broadphase_cell_m());
    out.cell_depth = static_cast<int>(from.cell_depth());
    out.boxes_per_cell = static_cast<int>(from.boxes_per_cell());
    out.method = static_cast<physics::SolverVariant>(from.method());
    out.body_integrator = static_cast<physics::IntegratorKind>(from.body_integrator());
    out.particle_integrator = static_cast<physics::IntegratorKind>(from.particle_integrator());
    expand_methods(from.method_parameters(), out.methods);
}

/// Largest distance at which a viewer may receive an entity with an agent, or such an entity may
/// notice a viewer, m.
float farthest_sight(const Settings& settings, float hysteresis) {
    float nimbus = 0.0F;
    float aura = 0.0F;
    float perception = 0.0F;
    for (const world::EntityType& type : settings.types) {
        nimbus = std::max(nimbus, *std::max_element(type.nimbus_m.begin(), type.nimbus_m.end()));
        if (type.brain != 0) {
            aura = std::max(aura, *std::max_element(type.aura_m.begin(), type.aura_m.end()));
        }
    }
    for (const ai::Brain& brain : settings.ai.brains) {
        perception = std::max(perception, brain.perception_m);
    }
    return std::max(std::min(nimbus, aura) * (1.0F + hysteresis), perception);
}

std::optional<ai::steering::AvoidanceSettings> expand_avoidance(
    const proto::config::Config& config) {
    if (!config.ai().has_avoidance()) {
        return std::nullopt;
    }
    const proto::config::Avoidance& from = config.ai().avoidance();
    ai::steering::AvoidanceSettings out;
    out.horizon_s = narrow(from.horizon_s());
    out.wall_horizon_s = narrow(from.wall_horizon_s());
    out.neighbour_m = narrow(from.neighbour_m());
    out.comfort_m = narrow(from.comfort_m());
    out.restless = narrow(from.restless());
    out.keep_right = narrow(from.keep_right());
    return out;
}

}  // namespace

void expand_stages(const proto::config::Config& config, Settings& settings) {
    settings.world_name = config.world().name();
    settings.tick_rate_hz = config.world().tick_rate_hz();
    settings.seed = config.world().seed();
    settings.ground_height_m = narrow(config.world().ground_height_m());
    settings.ghost_margin_m = narrow(config.zones().ghost_margin_m());
    settings.handoff_hysteresis_m = narrow(config.zones().handoff_hysteresis_m());
    settings.types.clear();
    settings.solids.clear();
    settings.outers.clear();
    settings.softs.clear();
    for (const auto& type : config.type()) {
        settings.types.push_back(expand_type(config, type, settings));
    }
    settings.ai.brains = expand_brains(config);
    settings.ai.max_decisions_per_tick = config.ai().max_decisions_per_tick();
    settings.ai.reduce_far = config.ai().reduce_far();
    settings.ai.far_m = narrow(config.ai().far_m());
    settings.ai.max_sight_rays_per_tick = config.ai().max_sight_rays_per_tick();
    settings.ai.max_plan_nodes = config.ai().max_plan_nodes();
    settings.ai.avoidance = expand_avoidance(config);
    settings.ai.points_of_interest = expand_points_of_interest(config);
    if (config.ai().has_pathfinding()) {
        settings.ai.pathfinding = expand_pathfinding(config);
    }
    settings.ai.suspend_after_s = narrow(config.ai().suspend_after_s());
    settings.ai.viewer_range_m =
        config.ai().suspend_offscreen()
            ? farthest_sight(settings, narrow(config.interest().hysteresis()))
            : std::numeric_limits<float>::infinity();
    settings.interest.hysteresis = narrow(config.interest().hysteresis());
    settings.interest.lod_lead_m = narrow(config.interest().lod_lead_m());
    settings.stances.assign(config.stance().begin(), config.stance().end());
    settings.interest.lod_radius_m.clear();
    for (int l = 0; l + 1 < config.lod_size(); ++l) {
        settings.interest.lod_radius_m.push_back(narrow(config.lod(l).radius_m()));
    }
    expand_replication(config, settings.replication);
    expand_physics(config.physics(), settings.physics);
    settings.visibility_filter = {config.interest().filter_checks_per_tick(),
                                  config.interest().filter_stale_ticks(),
                                  config.interest().filter_grace_ticks()};
    settings.rewind = {
        static_cast<Tick>(std::lround(config.rewind().most_ms() * 1e-3 * settings.tick_rate_hz)),
        narrow(config.rewind().slack_m())};
    settings.audit = {config.audit().enabled(), config.audit().period_ticks()};
    settings.rules.clear();
    for (const auto& rule : config.rules()) {
        settings.rules.emplace_back(rule.name(), rule.value());
    }
}

}  // namespace zoned::config
