#include "server/config/world/world_description.h"

#include "server/config/settings.h"
#include "server/config/text/sha256.h"

#include <google/protobuf/text_format.h>

namespace zoned::config {

namespace {

static_assert(static_cast<int>(wire::DeclaredKind::kText) == proto::DECLARED_TEXT);

void describe_fields(const wire::FieldSchema& schema, proto::EntityType& out) {
    for (const wire::DeclaredField& field : schema.fields()) {
        proto::DeclaredField& to = *out.add_fields();
        to.set_name(field.name);
        to.set_kind(static_cast<proto::DeclaredKind>(field.kind));
        if (field.kind == wire::DeclaredKind::kNumber) {
            to.set_minimum(field.minimum);
            to.set_quantum(field.quantum);
            to.set_steps(field.most);
        }
        for (const std::string& value : field.values) {
            to.add_values(value);
        }
        to.set_interval_ticks(static_cast<std::uint32_t>(field.interval));
        to.mutable_initial()->Add(field.initial.begin(), field.initial.begin() + field.words);
    }
}

void describe_deformation(const world::EntityType& type, proto::Deformation& out) {
    const wire::DeformationLattice& from = *type.deformation;
    out.set_first_field(type.first_control_point);
    out.mutable_points()->Add(from.points.begin(), from.points.end());
    for (int axis = 0; axis < 3; ++axis) {
        out.add_lower(from.lower[axis]);
        out.add_upper(from.upper[axis]);
    }
    out.set_quantum_m(from.quantum_m);
    out.set_bound_m(from.bound_m);
}

void describe_type(const world::EntityType& type, proto::EntityType& out) {
    out.set_name(type.name);
    out.set_upright(type.upright());
    out.set_max_acceleration_mps2(type.max_acceleration_mps2);
    out.set_max_velocity_jump_mps(type.max_velocity_jump_mps);
    out.set_max_spin_jump_rps(type.max_spin_jump_rps());
    out.set_character(type.kind == world::EntityKind::kCharacter);
    if (type.fields != nullptr) {
        describe_fields(*type.fields, out);
    }
    if (type.deformation != nullptr) {
        describe_deformation(type, *out.mutable_deformation());
    }
    if (!out.character()) {
        return;
    }
    const motion::CharacterLimits& from = type.character;
    proto::CharacterLimits& limits = *out.mutable_limits();
    limits.set_radius(from.radius);
    limits.set_half_segment(from.half_segment);
    limits.set_speed(from.speed);
    limits.set_sprint_factor(from.sprint_factor);
    limits.set_acceleration(from.acceleration);
    limits.set_air_acceleration(from.air_acceleration);
    limits.set_jump_speed(from.jump_speed);
    limits.set_max_slope_cos(from.max_slope_cos);
    limits.set_step_down(from.step_down);
    limits.set_step_up(from.step_up);
    limits.set_gravity(from.gravity);
}

void describe_quantization(const wire::Quantization& from, proto::Quantization& out) {
    out.set_position_step_m(from.position_step_m);
    out.set_velocity_step_mps(from.velocity_step_mps);
    out.set_acceleration_step_mps2(from.acceleration_step_mps2);
    out.set_angular_velocity_step_rps(from.angular_velocity_step_rps);
    out.set_orientation_bits(static_cast<std::uint32_t>(from.orientation_bits));
    out.set_yaw_bits(static_cast<std::uint32_t>(from.yaw_bits));
    out.set_horizontal_extent_m(from.horizontal_extent_m);
    out.set_vertical_extent_m(from.vertical_extent_m);
    out.set_max_speed_mps(from.max_speed_mps);
    out.set_gravity_mps2(from.gravity_mps2);
    for (const wire::LodShift& shift : from.lod_shift) {
        proto::Quantization::LodShift& level = *out.add_lod_shift();
        level.set_place(shift.place);
        level.set_turn(shift.turn);
    }
}

/// Empty where it is not rotated.
void describe_turn(const Quat& from, google::protobuf::RepeatedField<float>& out) {
    if (from.coeffs() != Quat::Identity().coeffs()) {
        for (const float part : {from.w(), from.x(), from.y(), from.z()}) {
            out.Add(part);
        }
    }
}

void describe_box(const motion::StaticBox& from, proto::StaticBox& out) {
    for (int axis = 0; axis < 3; ++axis) {
        out.add_centre(from.centre[axis]);
        out.add_half_extents(from.half_extents[axis]);
    }
    describe_turn(from.orientation, *out.mutable_orientation());
}

void describe_door(const NamedDoor& from, proto::Door& out) {
    out.set_name(from.name);
    describe_box(from.door.box, *out.mutable_box());
    out.set_period(from.door.times.period);
    out.set_shift(from.door.times.shift);
    for (const motion::Timetable::OpenSpan& span : from.door.times.open) {
        out.add_open(span.from);
        out.add_open(span.to);
    }
    out.set_by_rules(from.door.by_rules.has_value());
}

void describe_platform(const NamedPlatform& from, proto::Platform& out) {
    const motion::PlatformPath& path = from.platform.path;
    out.set_name(from.name);
    describe_box(from.platform.box, *out.mutable_box());
    for (const motion::PlatformStop& stop : path.stops) {
        for (const float coordinate : stop.offset) {
            out.add_offsets(coordinate);
        }
        out.add_ticks(stop.at);
    }
    out.set_back(path.back);
    out.set_wait(path.wait);
    out.set_shift(path.shift);
    out.set_by_rules(path.by_rules.has_value());
    out.set_start(path.start);
}

/// All but the geometry itself.
void describe_surface(const SurfaceSettings& from, proto::StaticSurface& out) {
    out.set_content(from.content);
    out.set_replicated(from.replicated);
    for (int axis = 0; axis < 3; ++axis) {
        out.add_position(from.position[axis]);
    }
    describe_turn(from.orientation, *out.mutable_orientation());
}

void describe_zone(const ZoneRegion& from, proto::Zone& out) {
    out.set_id(from.id.value);
    const Vec3d origin = from.origin();
    for (int axis = 0; axis < 3; ++axis) {
        out.add_origin(origin[axis]);
    }
    out.add_lower(from.min_x);
    out.add_lower(from.min_z);
    out.add_upper(from.max_x);
    out.add_upper(from.max_z);
}

void describe_cosmetic(const CosmeticSystem& from, proto::CosmeticSystem& out) {
    out.set_name(from.name);
    out.set_drag(from.drag);
    for (int axis = 0; axis < 3; ++axis) {
        out.add_gravity(from.gravity[axis]);
        out.add_wind(from.wind[axis]);
    }
    for (const motion::Emitter& e : from.emitters) {
        proto::Emitter& emitter = *out.add_emitters();
        emitter.set_seed(e.seed);
        emitter.set_start_tick(e.start);
        emitter.set_rate_hz(e.rate_hz);
        emitter.set_most(e.most == UINT64_MAX ? 0 : e.most);
        for (int axis = 0; axis < 3; ++axis) {
            emitter.add_position(e.position[axis]);
            emitter.add_direction(e.direction[axis]);
        }
        emitter.set_spread(e.spread);
        emitter.set_cone_cosine(e.cone_cosine);
        emitter.set_speed_min(e.speed_min);
        emitter.set_speed_max(e.speed_max);
        emitter.set_lifetime_min_s(e.lifetime_min_s);
        emitter.set_lifetime_max_s(e.lifetime_max_s);
    }
    if (from.burst) {
        proto::CosmeticSystem::Burst& burst = *out.mutable_burst();
        burst.set_cone_cosine(from.burst->cone_cosine);
        burst.set_slowest(from.burst->slowest);
        burst.set_spread(from.burst->spread);
        burst.set_lifetime_min_s(from.burst->lifetime_min_s);
        burst.set_lifetime_max_s(from.burst->lifetime_max_s);
    }
}

void describe_variable(const clock::SharedVariableDef& from, proto::SharedVariable& out) {
    out.set_name(from.name);
    out.set_seed(from.seed);
    out.set_blend_s(from.blend_s);
    for (const clock::VariablePhase& phase : from.phases) {
        proto::SharedVariable::Phase& sent = *out.add_phases();
        sent.set_name(phase.name);
        sent.set_value(phase.value);
        sent.set_weight(phase.weight);
        sent.set_min_s(phase.min_s);
        sent.set_max_s(phase.max_s);
    }
}

proto::WorldDescription describe_honestly(const Settings& settings) {
    proto::WorldDescription out;
    out.set_tick_rate_hz(settings.tick_rate_hz);
    describe_quantization(settings.replication.quantization, *out.mutable_quantization());
    for (const world::EntityType& type : settings.types) {
        proto::EntityType& described = *out.add_types();
        describe_type(type, described);
        if (type.is_root()) {
            const auto& seats = (*settings.assemblies)[type.assembly - 1U].seats;
            described.set_seats(static_cast<std::uint32_t>(seats.size()));
        }
    }
    for (std::size_t l = 0; l < settings.replication.lods.size(); ++l) {
        proto::Lod& lod = *out.add_lods();
        const auto& radii = settings.interest.lod_radius_m;
        lod.set_radius_m(l < radii.size() ? radii[l] : 0.0F);
        lod.set_position_bound_m(settings.replication.lods[l].position_m);
        lod.set_orientation_bound_rad(settings.replication.lods[l].orientation_rad);
    }
    for (const ZoneRegion& zone : settings.zones) {
        describe_zone(zone, *out.add_zones());
    }
    for (const motion::StaticBox& box : settings.boxes) {
        describe_box(box, *out.add_boxes());
    }
    for (const NamedDoor& door : settings.doors) {
        describe_door(door, *out.add_doors());
    }
    for (const NamedPlatform& platform : settings.platforms) {
        describe_platform(platform, *out.add_platforms());
    }
    for (const SurfaceSettings& surface : settings.surfaces) {
        describe_surface(surface, *out.add_surfaces());
    }
    for (const CosmeticSystem& cosmetic : settings.cosmetics) {
        describe_cosmetic(cosmetic, *out.add_cosmetics());
    }
    for (const clock::SharedClockDef& clock : settings.environment.clocks) {
        proto::SharedClock& sent = *out.add_shared_clocks();
        sent.set_name(clock.name);
        sent.set_period(clock.period);
    }
    for (const clock::SharedVariableDef& variable : settings.environment.variables) {
        describe_variable(variable, *out.add_shared_variables());
    }
    out.set_ground_height_m(settings.ground_height_m);
    out.set_interest_hysteresis(settings.interest.hysteresis);
    return out;
}

}  // namespace

void describe_geometry(const motion::Surface& from, proto::StaticSurface& out) {
    if (from.is_grid()) {
        const motion::HeightGrid& grid = from.grid();
        proto::StaticSurface::Heights& heights = *out.mutable_heights();
        heights.set_columns(grid.columns);
        heights.set_rows(grid.rows);
        heights.set_spacing_x(grid.spacing_x);
        heights.set_spacing_z(grid.spacing_z);
        heights.set_thickness(grid.thickness);
        heights.mutable_height()->Add(grid.heights.begin(), grid.heights.end());
        return;
    }
    proto::StaticSurface::Triangles& triangles = *out.mutable_triangles();
    for (const Vec3& v : from.mesh().vertices) {
        triangles.mutable_vertex()->Add(v.data(), v.data() + 3);
    }
    for (const auto& corners : from.mesh().corners) {
        triangles.mutable_corner()->Add(corners.begin(), corners.end());
    }
}

proto::WorldDescription describe_world(const Settings& settings) {
    proto::WorldDescription out = describe_honestly(settings);
    for (std::size_t s = 0; s < settings.surfaces.size(); ++s) {
        if (settings.surfaces[s].replicated) {
            describe_geometry(*settings.surfaces[s].surface,
                              *out.mutable_surfaces(static_cast<int>(s)));
        }
    }
    const std::optional<WrongLimitSettings>& wrong = settings.server.testing.wrong_limit;
    for (proto::EntityType& type : *out.mutable_types()) {
        if (wrong && (wrong->type.empty() || wrong->type == type.name())) {
            type.set_max_acceleration_mps2(wrong->max_acceleration_mps2);
            type.set_max_velocity_jump_mps(wrong->max_velocity_jump_mps);
        }
    }
    return out;
}

std::string world_digest(const Settings& settings) {
    std::string text;
    google::protobuf::TextFormat::PrintToString(describe_honestly(settings), &text);
    return sha256_hex(text);
}

}  // namespace zoned::config
