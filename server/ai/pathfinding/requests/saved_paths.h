// SavedPaths: what a map of paths remembers of who has asked, for whoever writes it down.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/math/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai::pathfinding {

/// Something that a path leads over and that doors may take away.
struct Hinge {
    std::uint32_t what = 0;    ///< the map's own number
    std::uint32_t corner = 0;  ///< it lies before this corner, and behind the one before
};

/// One end of a path: where somebody is or wants to be, and where that is on the map.
struct PathEnd {
    Vec3 wanted = Vec3::Zero();  ///< y: of the feet; not a number: on the ground
    Vec3 on = Vec3::Zero();      ///< on maps of cells: of no meaning
    std::uint32_t node = ~0U;    ///< the map's own number: of a cell, a polygon, a waypoint
};

/// What a map of nodes knows of a request beside its corners and what they hang on.
struct RequestState {
    std::uint32_t round = 0;
    std::uint32_t asker = 0;
    PathEnd from;
    PathEnd to;
    bool taken = false;  ///< false: it was released and still has its turn
    bool waiting = false;
    bool usable = false;  ///< its corners lead somewhere
    bool best = false;
    PathOutcome outcome = PathOutcome::kUnreachable;
    std::uint32_t next = 0;  ///< corner that the asker heads for
    float length_m = 0.0F;
    float rest_m = 0.0F;   ///< from that corner on
    double cost = 0.0;     ///< what the map says that the path costs
    float short_m = 0.0F;  ///< from its end to the place that was wanted; nodes only, like the next
    std::uint32_t last = ~0U;  ///< node in which it ends
};

/// A request, by the number that its ticket has.
struct SavedRequest : RequestState {
    std::uint32_t number = 0;
    bool doubted = false;  ///< cells: it waits for another path if that pays
    bool reaches = false;  ///< cells: the goal is no obstacle, for which another cell would stand
    std::vector<Spot> corners;
    std::vector<Hinge> hinges;
};

/// An asker and its requests, whose turn is next first.
struct SavedTurn {
    std::uint32_t asker = 0;
    std::uint32_t waited_ticks = 0;  ///< since its turn began
    std::vector<std::uint32_t> requests;
};

/// Next steps to a common goal that were there; they are made anew.
struct SavedField {
    std::uint32_t goal = 0;  ///< the cell's place
    std::uint64_t used = 0;  ///< tick of the map
};

/// All that later answers hang on beside the map itself, which is baked anew with its doors as they
/// are. Whoever remembers it gives the same answers in the same ticks. Only while a map was still
/// being renewed after a door had turned, another path may be found among equally long ones;
/// and while paths around crowds were being brought up to date, the new ones are there some ticks
/// sooner.
struct SavedPaths {
    std::vector<SavedRequest> requests;  ///< ascending by number
    std::vector<std::uint32_t> free;     ///< other numbers, the next to be used last
    std::vector<SavedTurn> turns;
    std::vector<std::uint32_t> unled;  ///< requests that wait since a change
    std::vector<SavedField> fields;
    std::vector<std::uint32_t> tables;  ///< a node of each part of the map that has a table to it
    std::uint32_t next_table = 0;       ///< part that is next to have one
    std::uint64_t tick = 0;             ///< of the map
    std::uint64_t typical_work = 0;
    std::uint64_t cheap_work = 0;
    pathfinding::SavedCrowds crowd{};  ///< of maps that know of crowds
};

/// How many of each a map numbers.
struct MapNumbers {
    std::size_t nodes = 0;
    std::size_t hinges = 0;
    std::uint32_t longest_wait_ticks = 0;
};

/// What keeps it from being one of a map that has so many; empty: nothing. PointsOfInterest are
/// finite but for heights, each number up to the largest is there once, who waits has one turn.
std::string defect_of(const SavedPaths& memory, const MapNumbers& numbers);

}  // namespace zoned::ai::pathfinding
