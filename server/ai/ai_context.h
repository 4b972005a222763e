// AiContext: what an update of the agents of a zone reads and moves.
#pragma once

#include "server/world/entities.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <functional>

namespace zoned::compute {
class Team;
}

namespace zoned::motion {
class StaticGeometry;
}

namespace zoned::physics {
class Query;
}

namespace zoned::spatial {
class PointGrid;
}

namespace zoned::ai {

class AgentStore;
class PathService;
class PointsOfInterest;
struct AiSettings;

/// One for all passes of an update. Not owned.
struct AiContext {
    AgentStore& agents;
    const AiSettings& settings;  ///< compiled for `dt`
    world::Entities& entities;
    const world::TypeTable& types;
    PointsOfInterest& points_of_interest;
    const motion::StaticGeometry& statics;
    compute::Team& team;  ///< helps; results do not depend on it
    /// x, z: an agent that has left the square of this half size around the origin is resumed, m.
    Vec2 half_size;
    Tick now;
    float dt;  ///< s
    /// Indexes entities.position by row; asked for at most once, and only where an agent needs to
    /// know of others than players.
    std::function<const spatial::PointGrid&()> make_grid{};
    const physics::Query* query = nullptr;  ///< what lines of sight meet; null: nothing
    PathService* paths = nullptr;           ///< null: none are planned
    float shared_m = 0.0F;  ///< so far within half_size entities may belong to other zones
    /// What make_grid() has answered in this update; null: no agent looks for others than players.
    const spatial::PointGrid* near = nullptr;
};

}  // namespace zoned::ai
