// PathProvider: the one interface through which paths are requested, whatever map they lead over.
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

/// Names a request until it is released.
struct PathRequestId {
    std::uint32_t slot = ~0U;
    std::uint32_t round = 0;

    friend bool operator==(const PathRequestId&, const PathRequestId&) = default;
};

/// The height of a place that is on the ground: on the lowest floor there.
inline constexpr float kOnGround = std::numeric_limits<float>::quiet_NaN();

struct PathRequest {
    /// Somebody who asks for this one path alone.
    static constexpr std::uint32_t kAlone = ~0U;

    std::uint32_t asker = kAlone;  ///< who asks: a small number, e.g. an agent's row
    Spot from;
    Spot to;
    float from_y = kOnGround;  ///< of the feet, m; maps of one floor do not look at it
    float to_y = kOnGround;
};

/// Where a map is left for a place beyond it.
struct MapExit {
    Spot at;
    float y = kOnGround;
};

/// What has become of a request.
struct PathResult {
    bool waiting = true;  ///< the rest says nothing yet
    PathOutcome outcome =
        PathOutcome::kUnreachable;  ///< kPartial: to the place nearest to the goal
    bool best = false;              ///< false: a path that is near the best
    float length_m = 0.0F;          ///< along the corners, over the ground
    std::span<const Spot> corners;  ///< without the start; true until the next serve()
};

/// What the ticks so far have done.
struct PathCounts {
    std::uint64_t asked = 0;
    std::uint64_t served = 0;
    std::uint64_t straight = 0;       ///< of these, by a free line
    std::uint64_t by_field = 0;       ///< along a field to a common goal
    std::uint64_t around_crowds = 0;  ///< along a field that knows how crowded it is
    std::uint64_t by_regions = 0;     ///< near the best only: the tick had no more work to give
    std::uint64_t fields = 0;         ///< that were made
    std::uint64_t broken = 0;         ///< paths that a change has cut
    std::uint64_t reviewed = 0;       ///< that a change may have made longer than they need be
    std::uint32_t waiting = 0;
    std::uint32_t longest_wait_ticks = 0;  ///< from an asker's turn to its answer
    std::uint64_t work = 0;                ///< of the last tick
    std::uint64_t crowd_work = 0;          ///< of the last tick besides, on paths around crowds
    std::uint64_t index_work = 0;          ///< of the last tick besides, on the map's index
};

/// A path request passes three layers: the PathService knows which agent of which size asks, a
/// provider whose turn it is, and the planner or search of its map finds the path.
///
/// Deterministic: what is answered, and when, hangs on the calls alone. Work is counted, never
/// timed. Nothing is allocated once as many have asked, for goals as far spread, as ever will.
class PathProvider {
  public:
    PathProvider() = default;
    PathProvider(const PathProvider&) = delete;
    PathProvider& operator=(const PathProvider&) = delete;
    virtual ~PathProvider() = default;

    /// Puts a request in its asker's queue. Where nothing leads from or to, it is answered at once.
    virtual PathRequestId ask(const PathRequest& ask) = 0;

    /// The ticket is of no use from now on, its path gone.
    virtual void release(PathRequestId ticket) = 0;

    /// By door of the zone, whether it is shut from now on. All answers are those of the map as it
    /// is from now on. Paths that are cut, as far as their askers still have to go, are looked for
    /// anew (they wait again); so are those for which what was opened may be a short cut, who
    /// follow the old path until the new one is there. All others stay as they are.
    virtual void turn_doors(std::span<const std::uint8_t> shut) = 0;

    /// Whether a ticket names a request that was not released.
    [[nodiscard]] virtual bool knows(PathRequestId ticket) const = 0;

    /// Once per tick: answers requests as far as the tick's work goes, and whoever has waited as
    /// long as anybody may.
    virtual void serve() = 0;

    /// Of a ticket that was not released.
    [[nodiscard]] virtual PathResult answer(PathRequestId ticket) const = 0;

    /// Where to walk from `at`: from corner to corner once the path is there (it remembers how far
    /// the asker has come; a corner counts within `near_m`), somewhere sensible until then. The
    /// goal at its end; `at` itself where there is no path. Different tickets may ask at the same
    /// time.
    virtual Spot heading(PathRequestId ticket, Spot at, float near_m) = 0;

    /// The asker is here now: who waits is told a path from where it was seen last.
    virtual void see(PathRequestId ticket, Spot at, float at_y) = 0;

    /// PathRequestId::slot of the requests that were answered by the last serve(), and of those
    /// before it since the one before, in the order of the answers. Some may be released by now.
    [[nodiscard]] virtual std::span<const std::uint32_t> answered() const = 0;

    /// The same of those whose paths the last turn_doors() has cut, or may have made longer than
    /// need be: they wait again, or are answered that there is no path.
    [[nodiscard]] virtual std::span<const std::uint32_t> requeued() const = 0;

    /// Whether bodies are to be counted in this tick, before serve(): maps that know of crowds.
    [[nodiscard]] virtual bool counts_bodies() const { return false; }

    /// All bodies, x and z, m. Where counts_bodies().
    virtual void count_bodies(std::span<const float> /*x*/, std::span<const float> /*z*/) {}

    /// Once per tick, before asks: compares some of the paths with paths around crowds, as these
    /// are now. PathRequestId::slot of those that wait again because another may pay; they follow
    /// their path until it is there.
    virtual std::span<const std::uint32_t> review_crowds() { return {}; }

    /// Whether one can walk straight from a place to another. Different threads may ask at the same
    /// time, while nobody changes anything.
    [[nodiscard]] virtual bool straight(Spot from, float from_y, Spot to, float to_y) const = 0;

    /// Whether the map tells of a place: what lies beyond it is reached by straight_exit(). False
    /// for what is not a number.
    [[nodiscard]] virtual bool contains(Spot place) const = 0;

    /// Where to leave the map for a place beyond it, as straight lines lead.
    virtual MapExit straight_exit(Spot from, float from_y, Spot to) = 0;

    /// Where to leave the map for a place beyond it, or in it but out of reach within it where the
    /// zones around are known; nothing where the path is one of this map.
    virtual std::optional<MapExit> exit_towards(Spot from, float from_y, Spot to) {
        const bool beyond = std::isfinite(to.x) && std::isfinite(to.z) && !contains(to);
        return beyond ? std::optional(straight_exit(from, from_y, to)) : std::nullopt;
    }

    /// What portals between zones are made of: the map as baked, with all doors open. It is kept
    /// until know_zones() or forget_ground(); nullptr for maps that portals are not made of.
    [[nodiscard]] virtual const GroundMap* ground_map() const { return nullptr; }

    /// The portals of the world, where this map is that of `zone`. Only for maps that have a
    /// ground_map().
    virtual void know_zones(std::shared_ptr<const ZonePortals> /*portals*/,
                            std::uint32_t /*zone*/) {}

    /// Where no other zone will be known.
    virtual void forget_ground() {}

    /// Height of the lowest floor over or under a place, m; not a number where the map does not
    /// tell. This and the next may be asked like straight().
    [[nodiscard]] virtual float ground(Spot /*place*/) const { return kOnGround; }

    /// Height of the floor on which one comes to a place who walks straight there, m; likewise.
    [[nodiscard]] virtual float floor_along(Spot /*from*/, float /*from_y*/, Spot /*to*/) const {
        return kOnGround;
    }

    /// All who have asked and what has become of it, between serve() and the next call.
    [[nodiscard]] virtual SavedPaths save() const = 0;

    /// Of a map of the same ground whose doors are as they were, while nobody has asked. Empty:
    /// done, all tickets are what they were; else why not, and nothing was changed.
    virtual std::string load(const SavedPaths& memory) = 0;

    [[nodiscard]] virtual const PathCounts& counts() const = 0;

    [[nodiscard]] virtual std::size_t bytes() const = 0;
};

}  // namespace zoned::ai::pathfinding
