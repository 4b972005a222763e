#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/file_text.h"
#include "tests/bench/public_data.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite_navigation.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::CellChange;
using ai::pathfinding::GridMap;
using ai::pathfinding::GridPlanner;
using ai::pathfinding::GridQuery;
using ai::pathfinding::PathOutcome;
using scenario::GridEvent;
using scenario::GridPatch;

/// The patched map of the data: it begins as an empty one of this size.
constexpr int kPatchedWidth = 281;
constexpr int kPatchedHeight = 209;

Cell patched_cell(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

GridMap empty_map() {
    GridMap map(kPatchedWidth, kPatchedHeight);
    for (int y = 0; y < kPatchedHeight; ++y) {
        for (int x = 0; x < kPatchedWidth; ++x) {
            map.set_passable(patched_cell(x, y), true);
        }
    }
    return map;
}

std::vector<CellChange> changes_of(const GridPatch& patch, int left, int top) {
    std::vector<CellChange> changes;
    for (int y = 0; y < patch.height; ++y) {
        for (int x = 0; x < patch.width; ++x) {
            if (left + x < kPatchedWidth && top + y < kPatchedHeight) {
                const auto at = static_cast<std::size_t>(y * patch.width + x);
                changes.push_back({patched_cell(left + x, top + y), patch.passable[at]});
            }
        }
    }
    return changes;
}

struct Replayed {
    std::vector<double> patch_us;  ///< until a query may be asked again
    std::vector<double> query_us;
    std::size_t wrong = 0;
};

Replayed replay(const std::vector<GridPatch>& patches, const std::vector<GridEvent>& events) {
    Replayed r;
    GridPlanner planner(empty_map());
    GridQuery nowhere;
    planner.plan(nowhere);
    for (const GridEvent& e : events) {
        const std::vector<CellChange> changes =
            e.query ? std::vector<CellChange>()
                    : changes_of(patches[static_cast<std::size_t>(e.patch)], e.x, e.y);
        GridQuery query;
        query.start = e.instance.start;
        query.goal = e.instance.goal;
        const std::int64_t before = wall_ns();
        if (e.query) {
            const ai::pathfinding::GridAnswer a = planner.plan(query);
            r.wrong += a.outcome != PathOutcome::kFound ||
                               std::abs(a.length - e.instance.length) > kLengthTolerance
                           ? 1U
                           : 0U;
        } else {
            planner.change(changes);
            planner.plan(nowhere);  // recomputes which cells reach which
        }
        const double us = static_cast<double>(wall_ns() - before) * 1e-3;
        (e.query ? r.query_us : r.patch_us).push_back(us);
    }
    return r;
}

/// Doors that shut: cells in the middle of best paths.
constexpr std::size_t kDoors = 48;

/// Puts shut and open doors on a planner, and asks for a path past each.
struct DoorTimes {
    std::vector<double> us;  ///< of a change, until a query may be made again
    std::size_t wrong = 0;   ///< paths that are not as long as A* finds
    std::size_t asked = 0;
};

DoorTimes shut_doors(const GridScene& scene) {
    DoorTimes t;
    GridPlanner planner(scene.map);
    const std::size_t step = std::max<std::size_t>(1, scene.instances.size() / kDoors);
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < scene.instances.size(); i += step) {
        GridQuery query;
        query.start = scene.instances[i].start;
        query.goal = scene.instances[i].goal;
        GridQuery nowhere = query;
        nowhere.goal = nowhere.start;
        planner.plan(query);
        ai::pathfinding::cells_of(planner.path().corners(), cells);
        if (cells.size() < 3) {
            continue;
        }
        CellChange door{cells[cells.size() / 2], false};
        for (const bool passable : {false, true}) {
            door.passable = passable;
            const std::int64_t before = wall_ns();
            planner.change(std::span(&door, 1));
            planner.plan(nowhere);
            t.us.push_back(static_cast<double>(wall_ns() - before) * 1e-3);
            const ai::pathfinding::GridAnswer a = planner.plan(query);
            const ai::pathfinding::GridAnswer b =
                planner.plan(query, ai::pathfinding::GridMethod::kAStar);
            t.wrong += a.outcome != b.outcome || a.cost != b.cost ? 1U : 0U;
            ++t.asked;
        }
    }
    return t;
}

}  // namespace

void run_doors(Session& session, const GridScene& scene) {
    if (!session.wants_method("door", "")) {
        return;
    }
    std::vector<std::vector<double>> us;
    Row row;
    for (int i = 0; i < (session.quick ? 1 : session.repeats); ++i) {
        const DoorTimes t = shut_doors(scene);
        us.push_back(t.us);
        row.error = static_cast<double>(t.wrong);
    }
    const std::vector<double> times = median_of_rows(us);
    row.suite = "navigation";
    row.scene = scene.name;
    row.method = "door";
    row.time_us_p50 = median(times);
    row.time_us_p99 = quantile(times, 0.99);
    row.error_unit = "wrong";
    row.metric("changes", static_cast<double>(times.size()));
    session.add({row});
}

void run_patched_map(Session& session) {
    const std::string folder = data_directory() + "/movingai/dynamic/";
    const auto patches = scenario::parse_grid_patches(text_of_file(folder + "dao_arena2.patch"));
    const auto events = scenario::parse_grid_events(text_of_file(folder + "dao_arena2.scen"));
    if (!patches || !events) {
        session.note("navigation: " + folder + "dao_arena2: " +
                     (patches ? events.error() : patches.error()) + ": no rows of it");
        return;
    }
    const bool known = std::all_of(events->begin(), events->end(), [&patches](const GridEvent& e) {
        return e.query || static_cast<std::size_t>(e.patch) < patches->size();
    });
    if (!known || !session.wants_method("default", "")) {
        return;
    }
    std::vector<std::vector<double>> patch_us;
    std::vector<std::vector<double>> query_us;
    Row row;
    for (int i = 0; i < (session.quick ? 1 : session.repeats); ++i) {
        const Replayed r = replay(*patches, *events);
        patch_us.push_back(r.patch_us);
        query_us.push_back(r.query_us);
        row.error = static_cast<double>(r.wrong);
    }
    const std::vector<double> queries = median_of_rows(query_us);
    const std::vector<double> laid = median_of_rows(patch_us);
    row.suite = "navigation";
    row.scene = kPatchedScene;
    row.time_us_p50 = mean(queries);
    row.time_us_p99 = quantile(queries, 0.99);
    row.error_unit = "wrong";
    row.metric("instances", static_cast<double>(queries.size()));
    row.metric("p99_us", row.time_us_p99);
    row.metric("patches", static_cast<double>(laid.size()));
    row.metric("patch_us_mean", mean(laid));
    row.metric("patch_us_max", largest(laid));
    session.add({row});
}

}  // namespace zoned::bench
