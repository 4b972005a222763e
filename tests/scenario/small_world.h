// SmallWorld: settings of a small flat world, built in code, for zone tests without a config file.
#pragma once

#include "server/config/settings.h"

namespace zoned::scenario {

inline constexpr TypeIndex kPlayer = 0;
inline constexpr TypeIndex kCrate = 1;
inline constexpr TypeIndex kBall = 2;

inline world::TypeTable small_types(float radius_m) {
    world::EntityType player;
    player.name = "player";
    player.kind = world::EntityKind::kCharacter;
    player.shape = world::TypeShape::kCapsule;
    player.radius = player.character.radius;
    player.half_segment = player.character.half_segment;
    player.mass = 80.0F;
    player.aura_m.fill(radius_m);
    player.nimbus_m.fill(radius_m);
    world::EntityType crate;
    crate.name = "crate";
    crate.mass = 10.0F;
    crate.aura_m.fill(radius_m);
    world::EntityType ball;
    ball.name = "ball";
    ball.shape = world::TypeShape::kSphere;
    ball.mass = 2.0F;
    ball.aura_m.fill(radius_m);
    return {player, crate, ball};
}

/// columns x rows square zones of `zone_m` metres each, centred on the origin, flat ground, radii
/// of 40 m.
inline config::Settings small_world(int columns, int rows, double zone_m) {
    config::Settings s;
    s.types = small_types(40.0F);
    s.ghost_margin_m = 50.0F;
    s.handoff_hysteresis_m = 1.0F;
    const double x0 = -0.5 * columns * zone_m;
    const double z0 = -0.5 * rows * zone_m;
    for (int z = 0; z < rows; ++z) {
        for (int x = 0; x < columns; ++x) {
            config::ZoneRegion region;
            region.id = ZoneId(static_cast<std::uint16_t>(s.zones.size() + 1));
            region.name = "zone" + std::to_string(s.zones.size() + 1);
            region.min_x = x0 + x * zone_m;
            region.min_z = z0 + z * zone_m;
            region.max_x = region.min_x + zone_m;
            region.max_z = region.min_z + zone_m;
            s.zones.push_back(region);
        }
    }
    s.spawn_points = {{Vec3d(0.5, 0.9, 0.5), "", ""}};
    s.interest.lod_radius_m = {30.0F};
    s.replication.lods = {{0.05F, 0.1F}, {0.5F, 0.3F}};
    s.audit.enabled = true;
    return s;
}

}  // namespace zoned::scenario
