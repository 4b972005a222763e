// PathService: the paths of all agents of a zone, on one map for each size of character.
#pragma once

#include "server/ai/pathfinding/path_settings.h"
#include "server/ai/pathfinding/requests/path_provider.h"
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

/// The number of an agent in the store of its zone.
using Slot = std::uint32_t;

/// Heights of the feet at the ends of a path, zone-local, m.
struct PathHeights {
    float from = pathfinding::kOnGround;
    float to = pathfinding::kOnGround;
};

/// SavedPathService: the saved state of PathService's requests; see pathfinding::SavedPaths.
struct SavedPathService {
    static constexpr std::uint8_t kNoSize = 255;

    struct Asked {
        EntityId entity;
        pathfinding::PathRequestId ticket;
        std::uint8_t size = kNoSize;  ///< size of its character; kNoSize: it has no request
        bool beyond = false;          ///< the goal lies beyond the zone
        bool rough = false;           ///< beyond it, by an exit that may not be the best
        pathfinding::Spot goal;       ///< rough: the goal beyond, zone-local, m
    };

    std::vector<Asked> asked;                    ///< ascending by entity
    std::vector<pathfinding::SavedPaths> sizes;  ///< by size of characters
};

/// A zone has one PathService; it is empty, and costs nothing, where no paths are planned. In each
/// tick call follow_doors(), then any ask() and release(), then serve(). Answers hold until the
/// next follow_doors() or serve(), or until the next ask() or release() of the same agent.
///
/// An agent has at most one path. The answers and their ticks depend only on the calls and their
/// order. So ask in an order that is always the same (ascending by entity). Nothing is allocated
/// once as many agents have asked as ever will.
class PathService {
  public:
    PathService() = default;

    /// Bakes a map of `area` (zone-local, m; pathfinding::GroundGrid::defect_of() is empty) and an
    /// index for each size of character that has an agent that travels. Types with equal capsules
    /// and equal abilities to climb share a size. Doors are as at `now`. `origin`: the origin of
    /// the zone in the world. Throws where Recast cannot make a mesh of the area.
    PathService(const PathfindingSettings& settings,
                const motion::StaticGeometry& statics,
                const pathfinding::GroundRect& area,
                const world::TypeTable& types,
                Tick now,
                const Vec3d& origin = Vec3d::Zero());

    /// The reason why the constructor cannot bake the maps of such a zone, or empty, as far as it
    /// can be told without baking them.
    static std::string defect_of(const PathfindingSettings& settings,
                                 const motion::StaticGeometry& statics,
                                 const pathfinding::GroundRect& area,
                                 const world::TypeTable& types);

    /// True if a character of that type can ask.
    [[nodiscard]] bool plans_for(TypeIndex type) const {
        return type < size_of_type_.size() && size_of_type_[type] != kNoSize;
    }

    [[nodiscard]] bool empty() const { return sizes_.empty(); }

    /// Sets the doors as at `now`, and compares some of the paths with paths around crowds. Goes on
    /// finding the costs that exits depend on; the next serve() goes by them. A path is looked for
    /// anew if a door cuts the part that its agent still has to go. It is also looked for anew if
    /// an opened door may shorten it. Costs nothing where no door turns and no crowd has changed.
    void follow_doors(Tick now);

    /// The ground from which portals of one size are made, see PathProvider::ground_map().
    [[nodiscard]] const pathfinding::GroundMap* ground_map(std::size_t size) const {
        return sizes_[size].map->ground_map();
    }

    /// From now on paths to places that cannot be reached within the zone lead through the portals
    /// of the world. This zone is number `zone` there.
    void know_zones(std::size_t size,
                    std::shared_ptr<const pathfinding::ZonePortals> portals,
                    std::uint32_t zone);

    /// Call this where no other zone will be known.
    void forget_ground();

    /// Requests a path between two zone-local places; it replaces the agent's present path.
    /// plans_for(type) must hold. A place may lie beyond the map, or within it but out of reach
    /// while the world's portals are known. Then the path leads to the best exit (kPartial; see
    /// PathProvider::exit_towards). Maps of one floor ignore heights.
    void ask(Slot agent,
             EntityId entity,
             TypeIndex type,
             pathfinding::Spot from,
             pathfinding::Spot to,
             PathHeights heights = {});

    /// Releases the agent's path, which it no longer needs. Does nothing where it has none.
    void release(Slot agent);

    /// Call once per tick, after all asks. A request of this tick is answered in it, unless the
    /// work of the tick is used up. Then it is answered in its turn, after
    /// GridPathSettings::longest_wait_ticks at most.
    void serve();

    /// True if the agent of that entity has asked. The slot may have been another agent's.
    [[nodiscard]] bool has(Slot agent, EntityId entity) const {
        return agent < asked_.size() && asked_[agent].size != kNoSize &&
               asked_[agent].entity == entity;
    }

    /// The answer to an agent that has asked. Corners are the points where the path turns, in any
    /// direction; the last is its end, and the start is left out. kFound: the path leads to the
    /// place itself. kPartial: it leads to the reachable place nearest to it. best = false: the
    /// path is near the best.
    [[nodiscard]] pathfinding::PathResult answer(Slot agent) const;

    /// The point to walk to from `at`, see GridPathRequests::heading; it is sensible even before
    /// the path is found. Different agents may ask at the same time.
    pathfinding::Spot heading(Slot agent, pathfinding::Spot at, float near_m);

    /// Agents whose answers the last serve() has made, ascending. An agent whose path a door has
    /// cut or shortened is listed again once it has another path.
    [[nodiscard]] std::span<const Slot> answered() const { return answered_; }

    /// Agents whose paths the last follow_doors() has cut, or may have made needlessly long,
    /// ascending: they wait again. Also agents that the next serve() may lead to another exit.
    [[nodiscard]] std::span<const Slot> requeued() const { return requeued_; }

    /// False: maps are being brought up to date, see PathProvider::settled().
    [[nodiscard]] bool settled() const;

    /// True if bodies have to be counted in this tick, before serve().
    [[nodiscard]] bool counts_bodies() const;

    /// x and z of all bodies that may be in the path of agents, m.
    void count_bodies(std::span<const float> x, std::span<const float> z);

    /// Reports the present place of an agent that has asked. A waiting agent gets its path from the
    /// place reported last.
    void see(Slot agent, pathfinding::Spot at, float at_y = pathfinding::kOnGround);

    /// True if a character of that type can walk straight from one place to another, as far as the
    /// map shows; then it needs no path. Different threads may ask at the same time, while nobody
    /// changes anything.
    [[nodiscard]] bool straight(TypeIndex type,
                                pathfinding::Spot from,
                                pathfinding::Spot to,
                                PathHeights heights = {}) const;

    /// Heights of floors at the feet of a character of that type; see PathProvider::ground() and
    /// PathProvider::floor_along(). plans_for(type) must hold.
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

    /// Call between serve() and the next call.
    [[nodiscard]] SavedPathService save() const;

    /// Loads saved requests into paths of the same ground, whose doors are as they were, before
    /// anybody has asked. `slot_of` returns the slot of an entity's agent; an agent that has asked
    /// has one. Empty: loaded, and all goes on as before. Else it returns the reason, and these
    /// paths are unusable.
    std::string load(const SavedPathService& memory,
                     const std::function<std::optional<Slot>(EntityId)>& slot_of);

    /// The counts of all sizes together.
    [[nodiscard]] pathfinding::PathCounts counts() const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    static constexpr std::uint8_t kNoSize = SavedPathService::kNoSize;

    struct Size {
        std::unique_ptr<pathfinding::PathProvider> map;
        std::vector<Slot> agent_of_request;  // by the service's number of the request
        bool learned = false;                // exits may be better since the last serve()
    };

    using Asked = SavedPathService::Asked;

    /// Makes the map of characters of one size.
    static std::unique_ptr<pathfinding::PathProvider> make_map(
        const PathfindingSettings& settings,
        const motion::StaticGeometry& statics,
        const pathfinding::GroundRect& area,
        const motion::CharacterLimits& limits,
        std::span<const std::uint8_t> shut,
        const Vec3d& origin);
    /// Finds the doors that are shut at a tick. Returns whether any is other than before.
    bool see_doors(Tick now);
    /// Appends the agents of these requests of a size.
    void note(std::span<const std::uint32_t> requests,
              std::size_t number,
              std::vector<Slot>& out) const;
    static void put_in_order(std::vector<Slot>& agents);
    /// Puts a request in place of the agent's.
    void ask_of(Slot agent, const Asked& asked, const pathfinding::PathRequest& request);
    /// Finds the exits of a size's rough paths again.
    void refine_exits(std::size_t number);
    void note_rough(Slot agent);

    std::vector<std::uint8_t> size_of_type_;
    std::vector<Size> sizes_;
    motion::StaticGeometry statics_;              // its doors
    Tick next_turn_ = motion::Timetable::kNever;  // the next turn of any door
    std::vector<Asked> asked_;                    // by slot of the agent
    std::vector<Slot> answered_;
    std::vector<Slot> requeued_;
    std::vector<Slot> rough_;         // agents whose exits are rough, ascending by entity
    std::vector<std::uint8_t> shut_;  // by door
};

}  // namespace zoned::ai
