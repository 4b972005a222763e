// SavedPaths: the saved state of a map's path requests.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/math/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai::pathfinding {

/// Hinge: a part of the map under a path that doors may take away.
struct Hinge {
    std::uint32_t what = 0;    ///< the map's own number
    std::uint32_t corner = 0;  ///< it lies between the corner before and this one
};

/// PathEnd: one end of a path: an asker's place or goal, and the matching place on the map.
struct PathEnd {
    Vec3 wanted = Vec3::Zero();  ///< y: of the feet; not a number: on the ground
    Vec3 on = Vec3::Zero();      ///< unused on maps of cells
    std::uint32_t node = ~0U;    ///< the map's own number: of a cell, a polygon, a waypoint
};

/// The state of a request on a map of nodes, besides its corners and hinges.
struct RequestState {
    std::uint32_t round = 0;
    std::uint32_t asker = 0;
    PathEnd from;
    PathEnd to;
    bool taken = false;  ///< false: it was released and still has its turn
    bool waiting = false;
    bool usable = false;  ///< its corners form a path
    bool best = false;
    PathOutcome outcome = PathOutcome::kUnreachable;
    std::uint32_t next = 0;  ///< the corner that the asker heads for
    float length_m = 0.0F;
    float rest_m = 0.0F;   ///< length from that corner on
    double cost = 0.0;     ///< cost of the path on the map
    float short_m = 0.0F;  ///< distance from its end to the wanted place; only for maps of nodes,
                           ///< like the next
    std::uint32_t last = ~0U;  ///< node in which it ends
};

/// SavedRequest: a request, by the slot number of its id.
struct SavedRequest : RequestState {
    std::uint32_t number = 0;
    bool doubted = false;  ///< cells: it waits for another path, to be taken if that pays
    bool reaches = false;  ///< cells: the goal is no obstacle, so no other cell replaces it
    std::vector<Spot> corners;
    std::vector<Hinge> hinges;
};

/// SavedTurn: an asker and its requests, the one whose turn is next first.
struct SavedTurn {
    std::uint32_t asker = 0;
    std::uint32_t waited_ticks = 0;  ///< ticks since its turn began
    std::vector<std::uint32_t> requests;
};

/// SavedField: a common goal that had a field of next steps; the field is made anew.
struct SavedField {
    std::uint32_t goal = 0;  ///< the cell's place
    std::uint64_t used = 0;  ///< tick of the map when it was last used
};

/// SavedTable: distances to a part of the map from all others; they are made anew.
struct SavedTable {
    std::uint32_t node = 0;  ///< a node of that part
    std::uint64_t used = 0;  ///< tick of the map when it was last used
};

/// SavedPortalRow: the costs of paths from beyond a portal, see PortalRow.
struct SavedPortalRow {
    std::uint32_t portal = 0;
    std::vector<Cost> costs;
};

/// SavedPortalCosts: the rows that are known, and those that are being found.
struct SavedPortalCosts {
    std::vector<SavedPortalRow> rows;  ///< ascending by portal
    std::vector<std::uint32_t> wanted;
    std::uint64_t spread = 0;  ///< cells that the field of the first wanted row has spread from
};

/// All state that later answers depend on, besides the map itself. The map is baked anew with its
/// doors as they are. With this state loaded, a map gives the same answers in the same ticks. There
/// are two exceptions, in which it is not `whole`. While a map is still being renewed after a door
/// has turned, it may find another of several equally long paths. While paths around crowds are
/// being brought up to date, the new ones are ready some ticks sooner.
struct SavedPaths {
    std::vector<SavedRequest> requests;      ///< ascending by number
    std::vector<std::uint32_t> free;         ///< unused numbers, the next to be used last
    std::vector<std::uint32_t> free_rounds;  ///< of these numbers, in their order
    std::vector<SavedTurn> turns;
    std::vector<std::uint32_t> unled;  ///< requests that wait since a change
    std::vector<SavedField> fields;
    std::vector<SavedTable> tables;
    SavedPortalCosts portal_costs;
    std::uint64_t tick = 0;  ///< tick of the map
    std::uint64_t typical_work = 0;
    std::uint64_t cheap_work = 0;
    std::uint64_t index_given = 0;     ///< cells: units of work on the index; 0: it was not begun
    std::uint64_t searched_work = 0;   ///< cells: of the searches before that
    pathfinding::SavedCrowds crowd{};  ///< for maps that know crowds
    /// False: work on the map or its fields is under way and is not in here, so the answers after
    /// loading may differ. It travels in no bytes.
    bool whole = true;
};

/// MapNumbers: the numbers of nodes and hinges on a map.
struct MapNumbers {
    std::size_t nodes = 0;
    std::size_t hinges = 0;
    std::uint32_t longest_wait_ticks = 0;
};

/// The reason why the state does not fit a map with these numbers; empty: it fits. Places must be
/// finite, except heights. Each number up to the largest must occur once. A waiting request must
/// have one turn.
std::string defect_of(const SavedPaths& memory, const MapNumbers& numbers);

}  // namespace zoned::ai::pathfinding
