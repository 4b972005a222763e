#include "server/zone/zone_setup.h"

#include "server/zone/simulation/moving/zone_doors.h"
#include "server/zone/simulation/moving/zone_platforms.h"
#include "server/zone/simulation/zone_particles.h"
#include "shared/core/assert.h"

namespace zoned::zone {

namespace {

void add_static_bodies(ZoneState& state) {
    physics::BodyDef ground;
    ground.kind = physics::BodyKind::kStatic;
    ground.shape = physics::Shape::plane();
    ground.position = Vec3(0.0F, state.settings.statics->ground_height(), 0.0F);
    ground.material.friction = 0.6F;
    const auto added = state.scene.add(ground);
    ZONED_ASSERT(added.ok(), "the ground is a valid body");
    for (const motion::StaticBox& box : state.settings.statics->boxes()) {
        physics::BodyDef def;
        def.kind = physics::BodyKind::kStatic;
        def.shape = physics::Shape::box(box.half_extents);
        def.position = box.centre;
        def.orientation = box.orientation;
        def.material = {box.friction, box.restitution};
        const auto body = state.scene.add(def);
        ZONED_ASSERT(body.ok(), "static boxes were checked when the config was read");
    }
    for (const SurfaceBody& surface : state.settings.surfaces) {
        physics::BodyDef def;
        def.kind = physics::BodyKind::kStatic;
        def.shape = surface.shape;
        def.position = surface.position;
        def.orientation = surface.orientation;
        def.material = surface.material;
        const auto body = state.scene.add(def);
        ZONED_ASSERT(body.ok(), "surfaces were checked when the config was read");
    }
}

ai::pathfinding::GroundRect paths_area_of(const ZoneSettings& settings) {
    const Region& region = settings.region();
    return paths_area(region.max_x - region.min_x,
                      region.max_z - region.min_z,
                      settings.handoff_hysteresis_m,
                      settings.ai.pathfinding.cell_m);
}

}  // namespace

std::string paths_defect(const ZoneSettings& settings) {
    return ai::PathService::defect_of(
        settings.ai.pathfinding, *settings.statics, paths_area_of(settings), *settings.types);
}

void make_paths(ZoneState& state) {
    const ZoneSettings& settings = state.settings;
    state.paths = ai::PathService(settings.ai.pathfinding,
                                  *settings.statics,
                                  paths_area_of(settings),
                                  *settings.types,
                                  state.now,
                                  settings.region().origin());
}

void set_up(ZoneState& state) {
    add_static_bodies(state);
    add_doors(state);
    add_platforms(state);
    add_particle_systems(state);
    if (!state.settings.maps_later) {
        make_paths(state);
    }
}

}  // namespace zoned::zone
