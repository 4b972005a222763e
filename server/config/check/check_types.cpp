#include "server/config/check/config_checks.h"
#include "server/config/text/check_name.h"
#include "server/config/types/field_config.h"
#include "server/config/types/soft_types.h"
#include "server/config/types/stances.h"
#include "server/config/types/type_shapes.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <map>
#include <utility>

namespace zoned::config {

namespace {

/// All movable entities fall; characters accelerate and jump on their own: the declared limits must
/// allow it.
void check_limits(const proto::config::Config& config,
                  const proto::config::Type& type,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    const double declared = type.max_acceleration_mps2();
    const std::string here = path + ".max_acceleration_mps2";
    if (declared < config.physics().gravity_mps2()) {
        diagnostics.add(here,
                        text_of("%g is less than gravity, %g: a falling body would exceed it",
                                declared,
                                config.physics().gravity_mps2()));
    }
    if (type.kind() != proto::config::CHARACTER) {
        return;
    }
    const auto& character = type.character();
    const double own = std::max(character.acceleration_mps2(), character.air_acceleration_mps2());
    if (declared < own) {
        diagnostics.add(
            here, text_of("%g is less than the character's own acceleration, %g", declared, own));
    }
    if (type.max_velocity_jump_mps() < character.jump_speed_mps()) {
        diagnostics.add(path + ".max_velocity_jump_mps",
                        text_of("%g is less than the character's jump_speed_mps, %g",
                                type.max_velocity_jump_mps(),
                                character.jump_speed_mps()));
    }
    const double fastest = character.speed_mps() * character.sprint_factor();
    const double limit = config.replication().quantization().max_speed_mps();
    if (fastest > limit) {
        diagnostics.add(
            path + ".character.speed_mps",
            text_of("a sprint of %g m/s exceeds quantization.max_speed_mps, %g", fastest, limit));
    }
    for (int h = 0; h < config.statics().hill_size(); ++h) {
        if (config.statics().hill(h).ramp_slope_deg() > character.max_slope_deg()) {
            diagnostics.add(path + ".character.max_slope_deg",
                            text_of("%g is less than a hill's ramp of %g: nobody could walk it",
                                    character.max_slope_deg(),
                                    config.statics().hill(h).ramp_slope_deg()));
        }
    }
}

void check_rolling(const proto::config::Config& config,
                   const proto::config::Type& type,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    const std::pair<double, const char*> given[] = {
        {type.rolling_friction_m(), ".rolling_friction_m"},
        {type.spinning_friction_m(), ".spinning_friction_m"}};
    for (const auto& [length, name] : given) {
        if (length == 0.0) {
            continue;
        }
        if (type.kind() == proto::config::CHARACTER || type.has_soft()) {
            diagnostics.add(path + name, "belongs to rigid props only");
        } else if (config.physics().method() != proto::config::SOFT_STEP) {
            diagnostics.add(path + name, "works with physics.method: SOFT_STEP alone");
        }
    }
}

void check_inertia(const proto::config::Type& type,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    if (!type.has_inertia()) {
        return;
    }
    physics::BodyDef body;
    body.shape = physics::Shape::sphere(1.0F);
    body.inertia = given_inertia(type, Quat::Identity());
    const std::string unfit = type.kind() == proto::config::CHARACTER || type.has_soft()
                                  ? "belongs to rigid props only"
                              : body.inertia.isZero() ? "needs xx_kg_m2, yy_kg_m2 and zz_kg_m2"
                                                      : physics::why_unfit(body);
    if (!unfit.empty()) {
        diagnostics.add(path, unfit);
    }
}

void check_shape(const proto::config::Config& config,
                 const proto::config::Type& type,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    const bool character = type.kind() == proto::config::CHARACTER;
    if (type.shape_case() == proto::config::Type::SHAPE_NOT_SET) {
        diagnostics.add(
            path,
            character
                ? "a character needs a capsule { ... }"
                : "a prop needs a shape: box, sphere, capsule, hull, compound or soft { ... }");
    } else if (character && !type.has_capsule()) {
        diagnostics.add(path, "a character is a capsule { ... }, no other shape");
    } else if (type.has_hull() || type.has_compound()) {
        const auto solid = build_solid(type);
        if (!solid) {
            diagnostics.add(path + (type.has_hull() ? ".hull" : ".compound"), solid.error());
        }
    } else if (type.has_soft()) {
        check_soft(config, type, path, diagnostics);
    }
    if (type.angular_drag_ps() > 0.0 && (character || type.has_soft())) {
        diagnostics.add(path + ".angular_drag_ps", "belongs to rigid props only");
    }
    check_inertia(type, path + ".inertia", diagnostics);
    check_rolling(config, type, path, diagnostics);
    if (type.drag_ps() > 0.0 && (character || type.has_soft())) {
        diagnostics.add(path + ".drag_ps",
                        character ? "belongs to props only: what walks sets its own speed"
                                  : "a soft body has its own, soft.drag_ps");
    }
    if (!character && type.has_character()) {
        diagnostics.add(path + ".character", "belongs to kind: CHARACTER only");
    }
    if (!character && type.has_brain()) {
        diagnostics.add(path + ".brain", "only characters have an agent");
    }
}

/// Stepping up from a point may move a prop by its own size: no client may receive it there.
void check_representation(const proto::config::Config& config,
                          const proto::config::Type& type,
                          const std::string& path,
                          Diagnostics& diagnostics) {
    if (!type.has_representation()) {
        return;
    }
    const std::string here = path + ".representation";
    const double single = type.representation().single_beyond_m();
    const double particle = type.representation().particle_beyond_m();
    if (type.kind() == proto::config::CHARACTER) {
        diagnostics.add(here, "belongs to props only");
    }
    if (single > 0.0 && !type.has_compound() && !type.has_soft()) {
        diagnostics.add(here + ".single_beyond_m",
                        "only a compound or soft { ... } is more than one rigid body");
    }
    if (single > 0.0 && particle > 0.0 && particle <= single) {
        diagnostics.add(here + ".particle_beyond_m",
                        text_of("%g m is no farther than single_beyond_m, %g", particle, single));
    }
    if (particle > 0.0 && type.has_soft()) {
        diagnostics.add(here + ".particle_beyond_m", "a soft body is never simulated as a point");
        return;
    }
    double nimbus = 0.0;
    for (const auto& other : config.type()) {
        nimbus = std::max(nimbus, largest_radius(other.nimbus_m()));
    }
    const double heard = std::min(nimbus, largest_radius(type.aura_m())) *
                         (1.0 + config.interest().hysteresis()) / 0.9;
    if (particle > 0.0 && particle < heard) {
        diagnostics.add(
            here + ".particle_beyond_m",
            text_of("%g m is too near: players hear of it, at least %g", particle, heard));
    }
}

}  // namespace

void check_types(const proto::config::Config& config, Diagnostics& diagnostics) {
    check_stances(config, diagnostics);
    check_fields(config, diagnostics);
    check_levers(config, diagnostics);
    std::map<std::string, int> names;
    std::map<std::string, int> brains;
    for (int m = 0; m < config.brain_size(); ++m) {
        brains.emplace(config.brain(m).name(), m);
    }
    for (int t = 0; t < config.type_size(); ++t) {
        const auto& type = config.type(t);
        const std::string path = join_path("", "type", t);
        if (check_name(type.name(), "type", path, diagnostics) &&
            !names.emplace(type.name(), t).second) {
            diagnostics.add(path + ".name", "'" + type.name() + "' is the name of another type");
        }
        check_shape(config, type, path, diagnostics);
        check_limits(config, type, path, diagnostics);
        check_representation(config, type, path, diagnostics);
        if (type.rewindable() && type.has_soft()) {
            diagnostics.add(path + ".rewindable", "a soft body has no pose to go back to");
        }
        if (type.has_brain() && brains.count(type.brain()) == 0) {
            diagnostics.add(path + ".brain", "there is no brain named '" + type.brain() + "'");
        }
    }
}

}  // namespace zoned::config
