#include "tests/bench/suite_crowd_goals.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/grid_scene.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace zoned::bench {

namespace {

using ai::pathfinding::Cell;
using ai::pathfinding::GridPathRequests;
using ai::pathfinding::GroundMap;
using ai::pathfinding::PathOutcome;
using ai::pathfinding::PathRequestId;
using ai::pathfinding::PathResult;
using ai::pathfinding::Spot;
using scenario::GridInstance;

constexpr std::size_t kGoalAgents = 5000;
/// Ticks of 50 ms at 5 m/s, where a cell is a metre.
constexpr float kGoalStep_m = 0.25F;
constexpr float kGoalNear_m = 0.5F;
constexpr int kGoalTicks = 25;
/// Ticks after which no agent waits for an index any more.
constexpr int kPatience = 1000;

GroundMap metre_cells(const ai::pathfinding::GridMap& cells) {
    const ai::pathfinding::GroundRect area{
        0.0F, 0.0F, static_cast<float>(cells.width()), static_cast<float>(cells.height())};
    return {ai::pathfinding::GroundGrid(area, 1.0F), cells, std::vector<float>(cells.places())};
}

/// The queries of the scenario with the longest paths; fewer queries than agents come again.
std::vector<GridInstance> farthest(const GridScene& scene, std::size_t count) {
    std::vector<std::size_t> order(scene.instances.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&scene](std::size_t a, std::size_t b) {
        const double x = scene.instances[a].length;
        const double y = scene.instances[b].length;
        return x > y || (x == y && a < b);
    });
    std::vector<GridInstance> agents;
    for (std::size_t i = 0; i < count; ++i) {
        agents.push_back(scene.instances[order[i % std::min(order.size(), count)]]);
    }
    return agents;
}

/// Doors that shut, and open again, on the paths of many agents.
constexpr std::size_t kGoalDoors = 8;
/// Ticks after which a door turns again, long before the index is renewed.
constexpr int kHastyTicks = 5;
/// Ticks with less work give no useful cost of a unit.
constexpr std::uint64_t kTellingWork = 100'000;

struct DoorRun {
    std::vector<double> change_ms;  ///< of each change
    std::vector<double> serve_ms;   ///< of each tick after them
    std::vector<double> tick_ms;    ///< the same with the desired velocities of all agents
    std::vector<double> unit_ns;    ///< of ticks with work, per reported unit
    int ticks_to_repair = 0;        ///< until no agent waits
    int ticks_to_index = 0;         ///< until the planner is as quick as before
    std::uint64_t broken = 0;       ///< paths that the changes cut
    std::uint64_t reviewed = 0;     ///< paths that the changes might have made shorter
    std::size_t wrong = 0;          ///< paths that lead through a shut door
};

struct GoalsRun {
    DoorRun door;
    std::vector<double> tick_ms;
    int ticks_to_all = -1;
    std::size_t still = 0;     ///< agents that did not move in the first tick
    std::size_t backward = 0;  ///< agents whose first segment gains nothing along best paths
    std::size_t wrong = 0;     ///< without a free path to the goal
    std::size_t near_best = 0;
    double excess = 0.0;  ///< of paths over the best on the grid, mean; pulled ones may be shorter
};

class GoalsTrial {
  public:
    GoalsTrial(const GridScene& scene, std::size_t agents)
        : agents_(farthest(scene, agents)),
          service_(metre_cells(scene.map)) {}

    GoalsRun run() {
        GoalsRun r;
        tickets_.resize(agents_.size());
        at_.clear();
        for (const GridInstance& a : agents_) {
            at_.push_back(service_.grid().centre(a.start));
        }
        from_ = at_;
        for (int tick = 0; tick < kGoalTicks; ++tick) {
            const std::int64_t before = thread_cpu_ns();
            if (tick == 0) {
                ask();
            }
            service_.serve();
            heads_.clear();
            for (std::size_t i = 0; i < agents_.size(); ++i) {
                heads_.push_back(service_.heading(tickets_[i], at_[i], kGoalNear_m));
            }
            r.tick_ms.push_back(static_cast<double>(thread_cpu_ns() - before) * 1e-6);
            if (tick == 0) {
                look_at_first(r);
            }
            for (std::size_t i = 0; i < agents_.size(); ++i) {
                const bool waits = service_.answer(tickets_[i]).waiting;
                from_[i] = waits ? at_[i] : from_[i];  // its path begins at its last known place
            }
            if (r.ticks_to_all < 0 && service_.counts().waiting == 0) {
                r.ticks_to_all = tick + 1;
            }
            move();
        }
        judge(r);
        turn_doors(r.door);
        for (const PathRequestId t : tickets_) {
            service_.release(t);
        }
        return r;
    }

    [[nodiscard]] const GridPathRequests& service() const { return service_; }

  private:
    void ask() {
        for (std::size_t i = 0; i < agents_.size(); ++i) {
            tickets_[i] = service_.ask(
                {static_cast<std::uint32_t>(i), at_[i], service_.grid().centre(agents_[i].goal)});
        }
    }

    void move() {
        for (std::size_t i = 0; i < at_.size(); ++i) {
            const float x = heads_[i].x - at_[i].x;
            const float z = heads_[i].z - at_[i].z;
            const float off = std::sqrt(x * x + z * z);
            const float share = off > kGoalStep_m ? kGoalStep_m / off : 1.0F;
            at_[i] = {at_[i].x + share * x, at_[i].z + share * z};
        }
    }

    /// The cell of a corner that a requester has still to pass, and the cells around it.
    [[nodiscard]] std::vector<ai::pathfinding::CellChange> door_of(std::size_t asker) const {
        std::vector<ai::pathfinding::CellChange> door;
        const std::span<const Spot> corners = service_.answer(tickets_[asker]).corners;
        if (corners.empty()) {
            return door;
        }
        const Cell middle = service_.grid().cell(corners[corners.size() / 2]);
        const ai::pathfinding::GridMap& map = service_.planner().map();
        for (int y = middle.y - 1; y <= middle.y + 1; ++y) {
            for (int x = middle.x - 1; x <= middle.x + 1; ++x) {
                const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
                if (map.passable(c)) {
                    door.push_back({c, false});
                }
            }
        }
        return door;
    }

    /// Doors one after the other: each shuts and opens, and does so again before the index is
    /// renewed.
    void turn_doors(DoorRun& d) {
        const ai::pathfinding::PathCounts before = service_.counts();
        for (std::size_t i = 0; i < std::min(kGoalDoors, agents_.size()); ++i) {
            std::vector<ai::pathfinding::CellChange> door =
                door_of(i * agents_.size() / kGoalDoors);
            turn(d, door, false, kPatience);
            for (std::size_t a = 0; a < agents_.size(); ++a) {
                d.wrong += free_from(tickets_[a], at_[a]) ? 0U : 1U;
            }
            turn(d, door, true, kHastyTicks);
            turn(d, door, false, kHastyTicks);
            turn(d, door, true, kPatience);
        }
        d.broken = service_.counts().broken - before.broken;
        d.reviewed = service_.counts().reviewed - before.reviewed;
    }

    void turn(DoorRun& d,
              std::vector<ai::pathfinding::CellChange>& door,
              bool passable,
              int ticks) {
        for (auto& c : door) {
            c.passable = passable;
        }
        const std::int64_t begin = thread_cpu_ns();
        service_.change(door);
        d.change_ms.push_back(static_cast<double>(thread_cpu_ns() - begin) * 1e-6);
        follow(d, ticks);
    }

    /// Ticks until the paths and the index are correct again, at most this many.
    void follow(DoorRun& d, int most) {
        for (int tick = 1; tick <= most; ++tick) {
            const std::int64_t begin = thread_cpu_ns();
            service_.serve();
            const std::int64_t served = thread_cpu_ns();
            for (std::size_t i = 0; i < agents_.size(); ++i) {
                heads_[i] = service_.heading(tickets_[i], at_[i], kGoalNear_m);
            }
            const auto serve_ns = static_cast<double>(served - begin);
            d.serve_ms.push_back(serve_ns * 1e-6);
            d.tick_ms.push_back(static_cast<double>(thread_cpu_ns() - begin) * 1e-6);
            const std::uint64_t work = service_.counts().work + service_.counts().index_work;
            if (work >= kTellingWork) {
                d.unit_ns.push_back(serve_ns / static_cast<double>(work));
            }
            const bool waits = service_.counts().waiting != 0;
            d.ticks_to_repair = waits ? std::max(d.ticks_to_repair, tick + 1) : d.ticks_to_repair;
            if (!waits && service_.indexed()) {
                d.ticks_to_index = std::max(d.ticks_to_index, tick);
                return;
            }
        }
    }

    /// The rest of a path, as far as it is known from the requester's place.
    bool free_from(PathRequestId ticket, Spot at) {
        const Spot head = service_.heading(ticket, at, kGoalNear_m);
        const std::span<const Spot> corners = service_.answer(ticket).corners;
        std::uint32_t looked = 0;
        auto next = std::find(corners.begin(), corners.end(), head);
        for (; next != corners.end() && next + 1 != corners.end(); ++next) {
            if (!ai::pathfinding::sees(service_.planner().map(),
                                       service_.grid().cell(*next),
                                       service_.grid().cell(next[1]),
                                       looked)) {
                return false;
            }
        }
        return true;
    }

    void look_at_first(GoalsRun& r) {
        ai::pathfinding::GridPlanner judge(service_.planner().map());
        judge.prepare();
        for (std::size_t i = 0; i < agents_.size(); ++i) {
            ai::pathfinding::GridQuery query;
            query.start = service_.grid().cell(heads_[i]);
            query.goal = agents_[i].goal;
            r.still += heads_[i] == at_[i] && agents_[i].length > 0.0 ? 1U : 0U;
            r.backward += judge.plan(query).length >= agents_[i].length ? 1U : 0U;
        }
    }

    /// Whether a path is free from its start to a goal. An agent beside an obstacle may stand in a
    /// cell whose middle is blocked; an agent on the edge of two cells is in both.
    [[nodiscard]] bool leads_to(const PathResult& path, Spot from, Cell goal) const {
        constexpr float kOnEdge_m = 1e-3F;
        for (const Spot off : {Spot{-kOnEdge_m, -kOnEdge_m},
                               Spot{kOnEdge_m, -kOnEdge_m},
                               Spot{-kOnEdge_m, kOnEdge_m},
                               Spot{kOnEdge_m, kOnEdge_m}}) {
            Cell at;
            bool free = ai::pathfinding::nearest_passable(
                service_.planner().map(), service_.grid(), {from.x + off.x, from.z + off.z}, 1, at);
            std::uint32_t looked = 0;
            for (const Spot& corner : path.corners) {
                const Cell to = service_.grid().cell(corner);
                free = free && ai::pathfinding::sees(service_.planner().map(), at, to, looked);
                at = to;
            }
            if (free && at == goal) {
                return true;
            }
        }
        return false;
    }

    void judge(GoalsRun& r) {
        std::vector<double> ratios;
        for (std::size_t i = 0; i < agents_.size(); ++i) {
            const PathResult a = service_.answer(tickets_[i]);
            const bool found = !a.waiting && a.outcome == PathOutcome::kFound;
            r.wrong += found && leads_to(a, from_[i], agents_[i].goal) ? 0U : 1U;
            r.near_best += a.best ? 0U : 1U;
            ratios.push_back(static_cast<double>(a.length_m) / agents_[i].length);
        }
        r.excess = mean(ratios) - 1.0;
    }

    std::vector<GridInstance> agents_;
    GridPathRequests service_;
    std::vector<PathRequestId> tickets_;
    std::vector<Spot> at_;
    std::vector<Spot> heads_;
    std::vector<Spot> from_;
};

Row goals_row(Session& session, const GridScene& scene) {
    const std::int64_t before = thread_cpu_ns();
    GoalsTrial trial(scene, session.quick ? 200 : kGoalAgents);
    const double prepared_s = static_cast<double>(thread_cpu_ns() - before) * 1e-9;
    trial.run();  // warms up
    std::vector<std::vector<double>> ticks;
    GoalsRun last;
    for (int i = 0; i < (session.quick ? 1 : session.repeats); ++i) {
        last = trial.run();
        ticks.push_back(last.tick_ms);
    }
    const std::vector<double> tick_ms = median_of_rows(ticks);
    Row row;
    row.suite = "crowd";
    row.scene = kGoalsScene;
    row.parameter = "map=" + scene.name;
    row.time_us_p50 = largest(tick_ms) * 1e3;
    row.time_us_p99 = row.time_us_p50;
    row.error = static_cast<double>(last.wrong + last.still + last.door.wrong);
    row.error_unit = "wrong";
    row.metric("ticks_to_all_paths", last.ticks_to_all);
    row.metric("path_ms_per_tick", largest(tick_ms));
    row.metric("path_ms_first_tick", tick_ms.front());
    row.metric("path_ms_last_tick", tick_ms.back());
    row.metric("still_in_first_tick", static_cast<double>(last.still));
    row.metric("first_leg_not_nearer", static_cast<double>(last.backward));
    row.metric("near_best_only", static_cast<double>(last.near_best));
    row.metric("excess_mean", last.excess);
    row.metric("door_change_ms", median(last.door.change_ms));
    row.metric("door_change_ms_max", largest(last.door.change_ms));
    row.metric("door_serve_ms_p50", median(last.door.serve_ms));
    row.metric("door_serve_ms_p99", quantile(last.door.serve_ms, 0.99));
    row.metric("door_serve_ms_max", largest(last.door.serve_ms));
    row.metric("door_ms_per_tick", largest(last.door.tick_ms));
    row.metric("door_unit_ns_p50", median(last.door.unit_ns));
    row.metric("door_unit_ns_max", largest(last.door.unit_ns));
    row.metric("door_ways_cut", static_cast<double>(last.door.broken));
    row.metric("door_ways_reviewed", static_cast<double>(last.door.reviewed));
    row.metric("door_ticks_to_repair", last.door.ticks_to_repair);
    row.metric("door_ticks_to_index", last.door.ticks_to_index);
    row.metric("preprocess_s", prepared_s);
    row.metric("index_mib", static_cast<double>(trial.service().bytes()) / (1024.0 * 1024.0));
    return row;
}

}  // namespace

void run_crowd_goals(Session& session) {
    if (!session.wants_scene(kGoalsScene) || !session.wants_method("default", "")) {
        return;
    }
    session.note(
        "goals_5000: 5,000 agents ask for the farthest goals of the map's scenario in the same "
        "tick of 50 ms; path_ms_per_tick is the CPU time of asking, serving and heading in the "
        "dearest tick, median of the runs after the first; excess_mean is over the best path on "
        "the "
        "grid, below 0 where pulling straight gains more than it costs to be near the best. Then "
        "doors of 3 x 3 cells on agents' paths shut and open, one after the other, and again "
        "before "
        "the index is renewed (door_*; door_serve_ms is the CPU time of a tick's serving alone)");
    for (const std::string name : {"den520d", "brc202d", "random512-10-0"}) {
        session.progress("crowd " + kGoalsScene + " " + name);
        std::string why;
        const std::optional<GridScene> scene = read_grid_scene(name, session.quick ? 40 : 1, why);
        if (scene) {
            session.add({goals_row(session, *scene)});
        } else {
            session.note("crowd: " + why);
        }
    }
}

}  // namespace zoned::bench
