// Spectator details: what viewers ask about one entity, or about the ground that its zone plans on.
#pragma once

#include "server/app/world/world.h"
#include "server/config/settings.h"

#include <string>

namespace zoned::app {

/// As JSON: state, explanation, path, perception and radii of one entity. For a client's avatar
/// also what the client hears, and of what moves: where the client is assumed to show it, and the
/// error in m. Empty when no zone owns the entity. Runs between two ticks.
[[nodiscard]] std::string details_json(const config::Settings& settings,
                                       const World& world,
                                       EntityId entity);

/// The ground that agents of a zone plan on, within `reach_m` of a place (world coordinates, m):
/// little-endian f32, six for a line. Edges of a navmesh; of a grid, crosses where no walker
/// stands; nothing of waypoints. Runs between two ticks.
[[nodiscard]] std::string walkable_lines(const World& world,
                                         ZoneId zone,
                                         float x,
                                         float z,
                                         float reach_m);

/// The flow field that leads to the goal of an entity's agent, within `reach_m` of the entity:
/// lines as above, each from one end of a cell's step to the other. Empty where the agent has no
/// path on a grid, or shares no field: its path was planned alone. Runs between two ticks.
[[nodiscard]] std::string flow_lines(const World& world, EntityId entity, float reach_m);

/// Quantiles over pairs of client and moving entity: the distance of truth from what the client is
/// assumed to show, as a share of the promised bound.
struct ErrorShares {
    std::size_t pairs = 0;
    double p50 = 0.0;
    double p99 = 0.0;
    double max = 0.0;
};

/// Takes some pairs of each zone. Runs between two ticks.
[[nodiscard]] ErrorShares sample_errors(const World& world);

}  // namespace zoned::app
