#include "server/app/world_settings.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::app {

namespace {

/// Static boxes that can be touched from within the region: those that overlap it, grown by a
/// margin for ghosts and reach.
std::shared_ptr<const motion::StaticGeometry> local_statics(const ops::Settings& settings,
                                                            const zone::Region& region) {
    const Vec3d origin = region.origin();
    const auto margin = static_cast<double>(settings.ghost_margin_m);
    std::vector<motion::StaticBox> local;
    for (const motion::StaticBox& box : settings.boxes) {
        const double reach = box.half_extents.norm();
        if (region.outside(box.centre.x(), box.centre.z()) <= margin + reach) {
            motion::StaticBox moved = box;
            moved.centre = (box.centre.cast<double>() - origin).cast<float>();
            local.push_back(moved);
        }
    }
    return std::make_shared<const motion::StaticGeometry>(std::move(local),
                                                          settings.ground_height_m);
}

zone::FaultSettings faults_of(const ops::Settings& settings, ZoneId id) {
    zone::FaultSettings faults;
    if (!settings.config.has_testing()) {
        return faults;
    }
    const proto::Config::Testing& testing = settings.config.testing();
    if (testing.has_corrupt_position()) {
        const auto& corrupt = testing.corrupt_position();
        faults.corrupt = {corrupt.probability(), static_cast<Tick>(corrupt.from_tick())};
        faults.corrupt_offset_m = static_cast<float>(corrupt.offset_m());
    }
    if (testing.has_hide_entity()) {
        faults.hide = {testing.hide_entity().probability(),
                       static_cast<Tick>(testing.hide_entity().from_tick())};
    }
    if (testing.has_leak_entity()) {
        faults.leak = {testing.leak_entity().probability(),
                       static_cast<Tick>(testing.leak_entity().from_tick())};
    }
    if (testing.has_stall_zone()) {
        const auto& stall = testing.stall_zone();
        const std::string& name = settings.zones[id.value - 1U].name;
        if (stall.has_zone() ? stall.zone() == name : id.value == 1) {
            faults.stall_from = static_cast<Tick>(stall.at_tick());
            faults.stall_ticks = static_cast<Tick>(stall.ticks());
        }
    }
    return faults;
}

template <class Vector, class Field>
void add_components(const Vector& from, Field* to) {
    for (Eigen::Index i = 0; i < from.size(); ++i) {
        to->Add(from[i]);
    }
}

void describe_type(const world::EntityType& type, proto::EntityType* out) {
    out->set_name(type.name);
    out->set_upright(type.upright());
    out->set_character(type.kind == world::EntityKind::kCharacter);
    out->set_max_acceleration_mps2(type.max_acceleration_mps2);
    out->set_max_velocity_jump_mps(type.max_velocity_jump_mps);
    if (type.kind != world::EntityKind::kCharacter) {
        return;
    }
    const motion::CharacterLimits& limits = type.character;
    proto::CharacterLimits* to = out->mutable_limits();
    to->set_radius(limits.radius);
    to->set_half_segment(limits.half_segment);
    to->set_speed(limits.speed);
    to->set_sprint_factor(limits.sprint_factor);
    to->set_acceleration(limits.acceleration);
    to->set_air_acceleration(limits.air_acceleration);
    to->set_jump_speed(limits.jump_speed);
    to->set_max_slope_cos(limits.max_slope_cos);
    to->set_step_down(limits.step_down);
    to->set_gravity(limits.gravity);
}

void describe_quantization(const wire::Quantization& q, proto::Quantization* out) {
    out->set_position_step_m(q.position_step_m);
    out->set_velocity_step_mps(q.velocity_step_mps);
    out->set_acceleration_step_mps2(q.acceleration_step_mps2);
    out->set_angular_velocity_step_rps(q.angular_velocity_step_rps);
    out->set_orientation_bits(static_cast<std::uint32_t>(q.orientation_bits));
    out->set_yaw_bits(static_cast<std::uint32_t>(q.yaw_bits));
    out->set_horizontal_extent_m(q.horizontal_extent_m);
    out->set_vertical_extent_m(q.vertical_extent_m);
    out->set_max_speed_mps(q.max_speed_mps);
}

/// Declared limits as clients hear of them; a fault of the checker's check may make them a lie.
void apply_wrong_limit(const ops::Settings& settings, proto::WorldDescription& world) {
    if (!settings.config.testing().has_wrong_limit()) {
        return;
    }
    const auto& wrong = settings.config.testing().wrong_limit();
    for (proto::EntityType& type : *world.mutable_types()) {
        if (!wrong.has_type() || wrong.type() == type.name()) {
            type.set_max_acceleration_mps2(static_cast<float>(wrong.max_acceleration_mps2()));
            type.set_max_velocity_jump_mps(static_cast<float>(wrong.max_velocity_jump_mps()));
        }
    }
}

}  // namespace

std::vector<zone::Region> regions_of(const ops::Settings& settings) {
    std::vector<zone::Region> regions;
    for (const ops::ZoneRegion& z : settings.zones) {
        regions.push_back({z.id, z.min_x, z.min_z, z.max_x, z.max_z});
    }
    return regions;
}

zone::ZoneSettings zone_settings(const ops::Settings& settings,
                                 ZoneId id,
                                 const std::shared_ptr<const world::TypeTable>& types) {
    zone::ZoneSettings z;
    z.id = id;
    z.regions = regions_of(settings);
    z.ghost_margin_m = settings.ghost_margin_m;
    z.handoff_hysteresis_m = settings.handoff_hysteresis_m;
    z.dt = static_cast<float>(1.0 / settings.tick_rate_hz);
    z.seed = settings.seed;
    z.types = types;
    z.statics = local_statics(settings, z.region());
    z.physics = settings.physics;
    z.ai = settings.ai;
    z.interest = settings.interest;
    z.replication = settings.replication;
    z.audit = {settings.config.audit().enabled(), settings.config.audit().period_ticks()};
    z.faults = faults_of(settings, id);
    return z;
}

void populate(const ops::Settings& settings,
              const std::vector<zone::Region>& regions,
              std::span<const std::unique_ptr<zone::Zone>> zones) {
    for (const ops::InitialEntity& initial : settings.initial) {
        const auto region =
            std::find_if(regions.begin(), regions.end(), [&](const zone::Region& r) {
                return r.outside(initial.position.x(), initial.position.z()) == 0.0;
            });
        ZONED_ASSERT(region != regions.end(), "initial entities were checked to lie in the world");
        zone::SpawnDef def;
        def.type = initial.type;
        def.position = (initial.position - region->origin()).cast<float>();
        def.orientation = initial.orientation;
        def.yaw = initial.yaw;
        def.asleep = initial.asleep;
        zones[region->id.value - 1U]->spawn(def);
    }
}

proto::WorldDescription describe(const ops::Settings& settings) {
    proto::WorldDescription world;
    world.set_tick_rate_hz(settings.tick_rate_hz);
    describe_quantization(settings.replication.quantization, world.mutable_quantization());
    for (const world::EntityType& type : settings.types) {
        describe_type(type, world.add_types());
    }
    for (std::size_t i = 0; i < settings.replication.lods.size(); ++i) {
        proto::Lod* lod = world.add_lods();
        const auto& radii = settings.interest.lod_radius_m;
        lod->set_radius_m(i < radii.size() ? radii[i] : 0.0F);
        lod->set_position_bound_m(settings.replication.lods[i].position_m);
        lod->set_orientation_bound_rad(settings.replication.lods[i].orientation_rad);
    }
    for (const zone::Region& region : regions_of(settings)) {
        proto::Zone* zone = world.add_zones();
        zone->set_id(region.id.value);
        add_components(region.origin(), zone->mutable_origin());
        zone->add_lower(region.min_x);
        zone->add_lower(region.min_z);
        zone->add_upper(region.max_x);
        zone->add_upper(region.max_z);
    }
    for (const motion::StaticBox& box : settings.boxes) {
        proto::StaticBox* out = world.add_boxes();
        add_components(box.centre, out->mutable_centre());
        add_components(box.half_extents, out->mutable_half_extents());
        if (box.orientation.coeffs() != Quat::Identity().coeffs()) {
            for (const float c : {box.orientation.w(),
                                  box.orientation.x(),
                                  box.orientation.y(),
                                  box.orientation.z()}) {
                out->add_orientation(c);
            }
        }
    }
    world.set_ground_height_m(settings.ground_height_m);
    world.set_interest_hysteresis(settings.interest.hysteresis);
    apply_wrong_limit(settings, world);
    return world;
}

}  // namespace zoned::app
