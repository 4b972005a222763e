// PathProvider: the interface through which paths are requested, on any kind of map.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "server/ai/pathfinding/requests/saved_paths.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

namespace zoned::ai::pathfinding {

struct GroundMap;
class ZonePortals;

/// PathRequestId: identifies a request until it is released.
struct PathRequestId {
    std::uint32_t slot = ~0U;
    std::uint32_t round = 0;

    friend bool operator==(const PathRequestId&, const PathRequestId&) = default;
};

/// The height of a place that is on the ground: on the lowest floor there.
inline constexpr float kOnGround = std::numeric_limits<float>::quiet_NaN();

struct PathRequest {
    /// The asker of this one path alone.
    static constexpr std::uint32_t kAlone = ~0U;

    std::uint32_t asker = kAlone;  ///< number of the asker, small, e.g. an agent's row
    Spot from;
    Spot to;
    float from_y = kOnGround;  ///< of the feet, m; maps of one floor ignore it
    float to_y = kOnGround;
};

/// MapExit: the point at which a map is left for a place beyond it.
struct MapExit {
    Spot at;
    float y = kOnGround;
    bool rough = false;  ///< a better one may be known later, see PathProvider::learn_exits()
};

/// PathResult: the state and result of a request.
struct PathResult {
    bool waiting = true;  ///< not answered yet; the other members mean nothing
    PathOutcome outcome = PathOutcome::kUnreachable;  ///< kPartial: the path leads to the reachable
                                                      ///< place nearest to the goal
    bool best = false;                                ///< false: a path that is near the best
    float length_m = 0.0F;                            ///< along the corners, over the ground
    std::span<const Spot> corners;  ///< without the start; valid until the next serve()
};

/// PathCounts: counts of the ticks so far.
struct PathCounts {
    std::uint64_t asked = 0;
    std::uint64_t served = 0;
    std::uint64_t straight = 0;       ///< of the answered ones, by a free line
    std::uint64_t by_field = 0;       ///< along a field to a common goal
    std::uint64_t around_crowds = 0;  ///< along a field that avoids crowds
    std::uint64_t by_regions = 0;     ///< only near the best: the tick had no more work to give
    std::uint64_t fields = 0;         ///< fields made
    std::uint64_t broken = 0;         ///< paths cut by a change
    std::uint64_t reviewed = 0;       ///< paths that a change may have made needlessly long
    std::uint32_t waiting = 0;
    std::uint32_t longest_wait_ticks = 0;  ///< from an asker's turn to its answer
    std::uint64_t work = 0;                ///< work of the last tick
    std::uint64_t crowd_work = 0;          ///< work of the last tick on paths around crowds, in
                                           ///< addition
    std::uint64_t index_work = 0;          ///< work of the last tick on the map's index, in
                                           ///< addition
};

/// A path request passes three layers. The PathService knows which agent of which size asks. A
/// provider decides whose turn it is. The planner or search of its map finds the path.
///
/// Deterministic: answers and their ticks depend on the calls alone. Work is counted, never timed.
/// Nothing is allocated once as many requests have been made, for goals as far spread, as ever
/// will.
class PathProvider {
  public:
    PathProvider() = default;
    PathProvider(const PathProvider&) = delete;
    PathProvider& operator=(const PathProvider&) = delete;
    virtual ~PathProvider() = default;

    /// Puts a request in its asker's queue. Where no path leads from its start or to its goal, it
    /// is answered at once.
    virtual PathRequestId ask(const PathRequest& ask) = 0;

    /// Releases a request: its id becomes invalid, and its path is removed.
    virtual void release(PathRequestId ticket) = 0;

    /// Sets the doors of the zone; `shut` is by door. From now on all answers are those of the
    /// changed map. A path that is cut, in the part that its asker still has to go, is looked for
    /// anew (the request waits again). A path that an opened door may shorten is looked for anew
    /// too; its asker follows the old path until the new one is ready. All others stay as they are.
    virtual void turn_doors(std::span<const std::uint8_t> shut) = 0;

    /// True if the id names a request that was not released.
    [[nodiscard]] virtual bool knows(PathRequestId ticket) const = 0;

    /// Call once per tick: answers requests within the tick's work, and all requests that have
    /// waited for the longest wait.
    virtual void serve() = 0;

    /// The result of a request that was not released.
    [[nodiscard]] virtual PathResult answer(PathRequestId ticket) const = 0;

    /// The point to walk to from `at`. Once the path is ready it leads from corner to corner; a
    /// corner is reached within `near_m`, and the progress is stored. Until then it is a sensible
    /// point. It is the goal at the path's end, and `at` itself where there is no path. Different
    /// requests may ask at the same time.
    virtual Spot heading(PathRequestId ticket, Spot at, float near_m) = 0;

    /// Reports the asker's present place. A waiting request gets its path from the place reported
    /// last.
    virtual void see(PathRequestId ticket, Spot at, float at_y) = 0;

    /// PathRequestId::slot of the requests that the last serve() answered, and of those answered
    /// between the last two, in the order of the answers. Some may be released by now.
    [[nodiscard]] virtual std::span<const std::uint32_t> answered() const = 0;

    /// PathRequestId::slot of the requests whose paths the last turn_doors() has cut, or may have
    /// made needlessly long. They wait again, or are answered that there is no path.
    [[nodiscard]] virtual std::span<const std::uint32_t> requeued() const = 0;

    /// True if bodies have to be counted in this tick, before serve(); for maps that know crowds.
    [[nodiscard]] virtual bool counts_bodies() const { return false; }

    /// Takes all bodies, x and z, m; call where counts_bodies().
    virtual void count_bodies(std::span<const float> /*x*/, std::span<const float> /*z*/) {}

    /// Call once per tick, before asks: compares some of the paths with paths around the present
    /// crowds. Returns PathRequestId::slot of the requests that wait again because another path may
    /// pay. They follow their path until the new one is ready.
    virtual std::span<const std::uint32_t> review_crowds() { return {}; }

    /// True if one can walk straight from a place to another. Different threads may ask at the same
    /// time, while nobody changes anything.
    [[nodiscard]] virtual bool straight(Spot from, float from_y, Spot to, float to_y) const = 0;

    /// True if the map covers the place; places beyond it are reached by straight_exit(). False for
    /// a place that is not a number.
    [[nodiscard]] virtual bool contains(Spot place) const = 0;

    /// The exit towards a place beyond the map, by straight lines.
    virtual MapExit straight_exit(Spot from, float from_y, Spot to) = 0;

    /// The exit towards a place beyond the map, or within it but out of reach, where the
    /// neighbouring zones are known. Nothing where the path stays on this map.
    virtual std::optional<MapExit> exit_towards(Spot from, float from_y, Spot to) {
        const bool beyond = std::isfinite(to.x) && std::isfinite(to.z) && !contains(to);
        return beyond ? std::optional(straight_exit(from, from_y, to)) : std::nullopt;
    }

    /// Call once per tick, before asks: goes on finding what rough exits depend on, within a share
    /// of work. True where exit_towards() may answer better than before.
    virtual bool learn_exits() { return false; }

    /// The asker's place as last reported, and the place that its request leads to.
    struct RequestEnds {
        Spot from;
        Spot to;
    };

    [[nodiscard]] virtual RequestEnds ends(PathRequestId ticket) const = 0;

    /// The ground from which portals between zones are made: the map as baked, with all doors open.
    /// It is kept until know_zones() or forget_ground(). It is nullptr for maps that make no
    /// portals.
    [[nodiscard]] virtual const GroundMap* ground_map() const { return nullptr; }

    /// Sets the portals of the world, in which this map is that of `zone`. Only for maps that have
    /// a ground_map().
    virtual void know_zones(std::shared_ptr<const ZonePortals> /*portals*/,
                            std::uint32_t /*zone*/) {}

    /// Call this where no other zone will be known.
    virtual void forget_ground() {}

    /// The height of the lowest floor over or under a place, m; not a number where the map has
    /// none. This function and the next have the threading rules of straight().
    [[nodiscard]] virtual float ground(Spot /*place*/) const { return kOnGround; }

    /// The height of the floor on which a straight walk to a place ends, m; not a number where
    /// unknown.
    [[nodiscard]] virtual float floor_along(Spot /*from*/, float /*from_y*/, Spot /*to*/) const {
        return kOnGround;
    }

    /// False: the map is being brought up to date, by further calls of serve(). Meanwhile not all
    /// of it is in save().
    [[nodiscard]] virtual bool settled() const { return true; }

    /// The state of all requests; call between serve() and the next call.
    [[nodiscard]] virtual SavedPaths save() const = 0;

    /// Loads the state of a map of the same ground whose doors are as they were, before anybody has
    /// asked. Empty: loaded, and all request ids are valid again. Else it returns the reason, and
    /// nothing was changed.
    virtual std::string load(const SavedPaths& memory) = 0;

    [[nodiscard]] virtual const PathCounts& counts() const = 0;

    [[nodiscard]] virtual std::size_t bytes() const = 0;
};

}  // namespace zoned::ai::pathfinding
