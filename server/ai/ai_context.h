// AiContext: the input and the output of one update of a zone's agents.
#pragma once

#include "server/world/entities.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <functional>
#include <limits>

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

/// The box around all zones of the world, in coordinates x, z of this one, m. Who wanders, patrols
/// or flees does not set out beyond it.
struct WorldBox {
    Vec2 lower = Vec2::Constant(-std::numeric_limits<float>::infinity());
    Vec2 upper = Vec2::Constant(std::numeric_limits<float>::infinity());

    /// The place within that is nearest.
    [[nodiscard]] Vec2 nearest(const Vec2& place) const {
        return place.cwiseMax(lower).cwiseMin(upper);
    }

    /// The direction without its part that would lead out.
    [[nodiscard]] Vec2 held(const Vec2& here, Vec2 direction) const {
        for (const int axis : {0, 1}) {
            if ((here[axis] >= upper[axis] && direction[axis] > 0.0F) ||
                (here[axis] <= lower[axis] && direction[axis] < 0.0F)) {
                direction[axis] = 0.0F;
            }
        }
        return direction;
    }
};

/// All passes of an update share one context. It owns nothing.
struct AiContext {
    AgentStore& agents;
    const AiSettings& settings;  ///< compiled for `dt`
    world::Entities& entities;
    const world::TypeTable& types;
    PointsOfInterest& points_of_interest;
    const motion::StaticGeometry& statics;
    compute::Team& team;  ///< helper threads; results do not depend on them
    /// Half size in x and z of a square around the origin, m. An agent outside it is resumed.
    Vec2 half_size;
    Tick now;
    float dt;  ///< s
    /// Indexes entities.position by row. An update asks for it at most once, and only where an
    /// agent looks for other entities than players.
    std::function<const spatial::PointGrid&()> make_grid{};
    const physics::Query* query = nullptr;  ///< for lines of sight; null: nothing blocks them
    PathService* paths = nullptr;           ///< null: no paths are planned
    float shared_m = 0.0F;                  ///< so near half_size, entities may be of other zones
    WorldBox world{};
    const motion::StaticGeometry* platforms =
        nullptr;  ///< `statics` with them; null: there are none
    /// The result of make_grid() in this update; null: no agent looks for other entities than
    /// players.
    const spatial::PointGrid* near = nullptr;
};

}  // namespace zoned::ai
