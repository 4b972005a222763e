// PathService: the paths of all agents of a zone, on maps of where characters of each size can
// walk.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/requests/path_provider.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "server/world/entity_type.h"
#include "shared/motion/static_geometry.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Number of an agent in the store of its zone.
using Slot = std::uint32_t;

/// What paths lead over.
enum class PathMapKind : std::uint8_t {
    kGrid,           ///< cells, one floor: exact in what can be walked, the fastest
    kNavmesh,        ///< polygons by Recast, any number of floors
    kWaypointGraph,  ///< waypoints with weighted edges: as somebody placed them, or regular
};

struct PathfindingSettings {
    float cell_m =
        0.0F;  ///< of the maps; 0: no paths are planned. kWaypointGraph: distance of waypoints
    /// Of a tick and zone, in units of about 2 ns; shared evenly among the sizes of characters.
    std::uint64_t work_per_tick = 1'000'000;
    PathMapKind map = PathMapKind::kGrid;
    float cell_height_m = 0.05F;  ///< kNavmesh: steps of height
    std::optional<pathfinding::CrowdPathSettings>
        crowding{};  ///< kGrid; none: crowds are no matter
    /// kWaypointGraph: those of the world, in its coordinates; null: regular ones wherever one can
    /// stand.
    std::shared_ptr<const pathfinding::WaypointGraph> waypoints{};
};

/// Heights of the ends of a path, of the feet, zone-local, m.
struct PathHeights {
    float from = pathfinding::kOnGround;
    float to = pathfinding::kOnGround;
};

/// All that PathService remembers of who has asked; see pathfinding::SavedPaths.
struct SavedPathService {
    static constexpr std::uint8_t kNoSize = 255;

    struct Asked {
        EntityId entity;
        pathfinding::PathRequestId ticket;
        std::uint8_t size = kNoSize;  ///< of its character; kNoSize: it has not asked
        bool beyond = false;          ///< the goal lies beyond the zone
    };

    std::vector<Asked> asked;                    ///< ascending by entity
    std::vector<pathfinding::SavedPaths> sizes;  ///< by size of characters
};

/// A zone has one; it is empty, and costs nothing, where no paths are planned. A tick goes:
/// follow_doors(), then any ask() and release(), then serve(); answers hold until the next
/// follow_doors(), ask() or release() of the same agent, or serve().
///
/// An agent has one path at most. What is answered, and when, hangs on the calls and their order
/// alone: ask in an order that is always the same (ascending by entity). Nothing is allocated once
/// as many have asked as ever will.
class PathService {
  public:
    PathService() = default;

    /// Bakes a map of `area` (zone-local, m; pathfinding::GroundGrid::defect_of() is empty) and an
    /// index for each size of character that has an agent: types whose capsules and abilities to
    /// climb are alike share one. Doors are as at `now`. `origin`: of the zone in the world. Throws
    /// where Recast can't make a mesh of the area.
    PathService(const PathfindingSettings& settings,
                const motion::StaticGeometry& statics,
                const pathfinding::GroundRect& area,
                const world::TypeTable& types,
                Tick now,
                const Vec3d& origin = Vec3d::Zero());

    /// Whether a character of that type can ask.
    [[nodiscard]] bool plans_for(TypeIndex type) const {
        return type < size_of_type_.size() && size_of_type_[type] != kNoSize;
    }

    [[nodiscard]] bool empty() const { return sizes_.empty(); }

    /// Doors are as at `now` from here on, and some of the paths are compared with paths around
    /// crowds. Paths that a door cuts, as far as their agents still have to go, and those that an
    /// opened one may shorten, are looked for anew. Costs nothing where no door turns and no crowd
    /// has changed.
    void follow_doors(Tick now);

    /// What portals of one size are made of, see PathProvider::ground_map().
    [[nodiscard]] const pathfinding::GroundMap* ground_map(std::size_t size) const {
        return sizes_[size].map->ground_map();
    }

    /// From now on paths to places that cannot be reached within the zone lead through
    /// the portals of the world; this zone is `zone` there.
    void know_zones(std::size_t size,
                    std::shared_ptr<const pathfinding::ZonePortals> portals,
                    std::uint32_t zone);

    /// Where no other zone will be known.
    void forget_ground();

    /// A path from a place to another, both zone-local; in place of the one that the agent has.
    /// plans_for(type). To a place beyond the map, or in it but out of reach within it where the
    /// world's portals are known, the path leads to where that is best left (kPartial; see
    /// PathProvider::exit_towards). Maps of one floor do not look at heights.
    void ask(Slot agent,
             EntityId entity,
             TypeIndex type,
             pathfinding::Spot from,
             pathfinding::Spot to,
             PathHeights heights = {});

    /// The agent wants no path any more, or is gone. Nothing where it has none.
    void release(Slot agent);

    /// Once per tick, after all have asked. Who asked in this tick is answered in it, unless its
    /// work is used up: then in its turn, after GridPathSettings::longest_wait_ticks at most.
    void serve();

    /// Whether the agent of that entity has asked. The slot may have been another's.
    [[nodiscard]] bool has(Slot agent, EntityId entity) const {
        return agent < asked_.size() && asked_[agent].size != kNoSize &&
               asked_[agent].entity == entity;
    }

    /// Of an agent that has asked. Corners are those where the path turns, in any direction, the
    /// last is its end; without the start. kFound: to the place itself. kPartial: to the nearest
    /// place from which one comes no nearer; best = false: a path that is near the best.
    [[nodiscard]] pathfinding::PathResult answer(Slot agent) const;

    /// Where to walk from `at`, see GridPathRequests::heading: somewhere sensible before the path
    /// is there too. Different agents may ask at the same time.
    pathfinding::Spot heading(Slot agent, pathfinding::Spot at, float near_m);

    /// Agents whose answers the last serve() has made, ascending; those whose path a door has
    /// cut or shortened are among them again once they have another.
    [[nodiscard]] std::span<const Slot> answered() const { return answered_; }

    /// Agents whose paths the last follow_doors() has cut, or may have made longer than need
    /// be, ascending: they wait again.
    [[nodiscard]] std::span<const Slot> requeued() const { return requeued_; }

    /// Whether bodies are to be counted in this tick, before serve().
    [[nodiscard]] bool counts_bodies() const;

    /// x and z of all bodies that may be in the way, m.
    void count_bodies(std::span<const float> x, std::span<const float> z);

    /// An agent that has asked is here now: who waits is told a path from where it was seen last.
    void see(Slot agent, pathfinding::Spot at, float at_y = pathfinding::kOnGround);

    /// Whether a character of that type can walk straight from one place to another, as far as the
    /// map tells: then it needs no path. Different threads may ask at the same time, while nobody
    /// changes anything.
    [[nodiscard]] bool straight(TypeIndex type,
                                pathfinding::Spot from,
                                pathfinding::Spot to,
                                PathHeights heights = {}) const;

    /// Heights of floors, of the feet of a character of that type, plans_for(type), as
    /// PathProvider::ground() and PathProvider::floor_along() say.
    [[nodiscard]] float ground(TypeIndex type, pathfinding::Spot place) const {
        return sizes_[size_of_type_[type]].map->ground(place);
    }

    [[nodiscard]] float floor_along(TypeIndex type,
                                    pathfinding::Spot from,
                                    float from_y,
                                    pathfinding::Spot to) const {
        return sizes_[size_of_type_[type]].map->floor_along(from, from_y, to);
    }

    [[nodiscard]] std::size_t sizes() const { return sizes_.size(); }

    [[nodiscard]] const pathfinding::PathProvider& map(std::size_t size) const {
        return *sizes_[size].map;
    }

    /// Between serve() and the next call.
    [[nodiscard]] SavedPathService save() const;

    /// In paths of the same ground, whose doors are as they were, while nobody has asked. `slot_of`
    /// answers with the slot of an entity's agent; an agent that has asked has one. Empty: done,
    /// and all goes on as it would have; else why not, and these paths are of no use any more.
    std::string load(const SavedPathService& memory,
                     const std::function<std::optional<Slot>(EntityId)>& slot_of);

    /// Counts of all sizes together.
    [[nodiscard]] pathfinding::PathCounts counts() const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    static constexpr std::uint8_t kNoSize = SavedPathService::kNoSize;

    struct Size {
        std::unique_ptr<pathfinding::PathProvider> map;
        std::vector<Slot> agent_of_request;  // by the service's number of the request
    };

    using Asked = SavedPathService::Asked;

    /// The map of characters of one size.
    static std::unique_ptr<pathfinding::PathProvider> make_map(
        const PathfindingSettings& settings,
        const motion::StaticGeometry& statics,
        const pathfinding::GroundRect& area,
        const motion::CharacterLimits& limits,
        std::span<const std::uint8_t> shut,
        const Vec3d& origin);
    /// Which doors are shut at a tick.
    void see_doors(Tick now);
    /// Appends whose requests of a size these are.
    void note(std::span<const std::uint32_t> requests,
              std::size_t number,
              std::vector<Slot>& out) const;
    static void put_in_order(std::vector<Slot>& agents);

    std::vector<std::uint8_t> size_of_type_;
    std::vector<Size> sizes_;
    std::vector<motion::Timetable> timetables_;   // of the doors
    Tick next_turn_ = motion::Timetable::kNever;  // of any door
    std::vector<Asked> asked_;                    // by slot of the agent
    std::vector<Slot> answered_;
    std::vector<Slot> requeued_;
    std::vector<std::uint8_t> shut_;  // by door
};

}  // namespace zoned::ai
