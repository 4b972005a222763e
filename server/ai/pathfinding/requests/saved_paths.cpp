#include "server/ai/pathfinding/requests/saved_paths.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// No map is so large, m.
constexpr float kOffAnyMap_m = 1e6F;
/// Askers are small numbers.
constexpr std::uint32_t kMostAskers = 1U << 20U;

bool on_a_map(float metres) {
    return std::abs(metres) <= kOffAnyMap_m;
}

/// A request for a place off any map keeps that place; heights may be not a number.
bool is_end(const PathEnd& end, std::size_t nodes) {
    return std::isfinite(end.wanted.x()) && std::isfinite(end.wanted.z()) &&
           !std::isinf(end.wanted.y()) && !std::isinf(end.on.y()) &&
           (end.node == ~0U || end.node < nodes) && on_a_map(end.on.x()) && on_a_map(end.on.z());
}

const char* wrong_with(const SavedRequest& r, const MapNumbers& map) {
    if (!r.taken) {
        return r.waiting ? nullptr : "was released and waits for nothing";
    }
    if (!is_end(r.from, map.nodes) || !is_end(r.to, map.nodes)) {
        return "leads from or to nowhere";
    }
    if ((r.waiting || r.usable) && (r.from.node == ~0U || r.to.node == ~0U)) {
        return "leads over no place of the map";
    }
    if (r.outcome > PathOutcome::kCutOff || r.asker >= kMostAskers) {
        return "has an outcome or an asker that is none";
    }
    const bool placed = std::all_of(r.corners.begin(), r.corners.end(), [](const Spot& s) {
        return on_a_map(s.x) && on_a_map(s.z);
    });
    if (!placed || !std::isfinite(r.length_m) || !std::isfinite(r.rest_m) ||
        !std::isfinite(r.cost) || !std::isfinite(r.short_m) ||
        (r.last != ~0U && r.last >= map.nodes)) {
        return "has a number that is none";
    }
    if (r.next >= std::max<std::size_t>(r.corners.size(), r.usable ? 0 : 1)) {
        return "is at a corner that there is not";
    }
    const bool hung = std::all_of(r.hinges.begin(), r.hinges.end(), [&](const Hinge& h) {
        return h.what < map.hinges && h.corner < r.corners.size();
    });
    return hung ? nullptr : "leads over what there is not";
}

}  // namespace

std::string defect_of(const SavedPaths& memory, const MapNumbers& map) {
    const std::size_t numbers = memory.requests.size() + memory.free.size();
    if (memory.free_rounds.size() != memory.free.size()) {
        return "free numbers of paths and their rounds differ in number";
    }
    std::vector<std::uint8_t> turns(numbers, 0);  // by number: 1 unless it waits
    std::vector<std::uint8_t> seen(numbers, 0);
    const auto name = [](std::uint32_t number) {
        return "path " + std::to_string(number) + " ";
    };
    for (const SavedRequest& r : memory.requests) {
        if (r.number >= numbers || seen[r.number]++ != 0) {
            return name(r.number) + "is there twice, or is none";
        }
        if (const char* const wrong = wrong_with(r, map)) {
            return name(r.number) + wrong;
        }
        turns[r.number] = r.waiting ? 0 : 1;
    }
    for (const std::uint32_t number : memory.free) {
        if (number >= numbers || seen[number]++ != 0) {
            return name(number) + "is there twice, or is none";
        }
        turns[number] = 1;
    }
    for (const SavedTurn& turn : memory.turns) {
        if (turn.asker >= kMostAskers || turn.requests.empty() ||
            turn.waited_ticks >= map.longest_wait_ticks) {
            return "an asker of paths is none, has a turn for none, or has waited too long";
        }
        for (const std::uint32_t number : turn.requests) {
            if (number >= numbers || turns[number]++ != 0) {
                return name(number) + "has a turn too many";
            }
        }
    }
    if (std::find(turns.begin(), turns.end(), 0) != turns.end()) {
        return "a path waits and has no turn";
    }
    const bool led = std::all_of(
        memory.unled.begin(), memory.unled.end(), [&](std::uint32_t n) { return n < numbers; });
    const bool fields = std::all_of(memory.fields.begin(),
                                    memory.fields.end(),
                                    [&](const SavedField& f) { return f.goal < map.nodes; });
    const bool tables = std::all_of(memory.tables.begin(),
                                    memory.tables.end(),
                                    [&](const SavedTable& t) { return t.node < map.nodes; });
    return led && fields && tables ? "" : "paths remember what there is not";
}

}  // namespace zoned::ai::pathfinding
