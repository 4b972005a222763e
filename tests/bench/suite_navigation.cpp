// Suite `navigation`: paths on maps of the Moving AI benchmark, by our planners beside Detour.
#include "tests/bench/suite_navigation.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "tests/bench/comparison.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/detour_mesh.h"
#include "tests/bench/mesh_visibility.h"
#include "tests/bench/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace zoned::bench {

namespace {

using ai::pathfinding::GridAnswer;
using ai::pathfinding::GridPlanner;
using ai::pathfinding::GridQuery;
using ai::pathfinding::PathOutcome;
using scenario::GridInstance;

/// Frames take every so many-th query of the scene in turn.
constexpr std::size_t kQueryShares = 16;
/// Slow methods take one in so many of these.
constexpr std::size_t kSlowShare = 16;
/// Of the times of one query, the median of this many counts.
constexpr int kTimesEach = 5;

/// So many queries are held to the shortest paths on the mesh.
constexpr std::size_t kHeldToExact = 100;

/// Recast takes minutes for this map, of which every fifth cell touches an obstacle.
constexpr const char* kNoMesh = "random512-10-0";

/// A path query: returns the length of the path found, below 0 for none.
using Ask = std::function<double(const GridInstance&)>;

/// The reference for path lengths.
enum class PathLength {
    kBest,  ///< those of the scenario
    kAny,   ///< on another map of the same world
};

struct PathTrialMethod {
    std::string name;
    std::string peer;
    bool slow = false;
    PathLength length = PathLength::kBest;
    Ask ask;
    double preprocess_s = 0.0;
    double index_mib = 0.0;
    Ask exact{};  ///< on the mesh that it plans on
};

class PathTrial final : public JudgedTrial {
  public:
    PathTrial(const GridScene& scene, const PathTrialMethod& method)
        : scene_(scene),
          method_(method) {}

    void frame() override {
        for_queries(turn_++ % kQueryShares,
                    [this](const GridInstance& i) { sum_ += method_.ask(i); });
    }

    /// Queries that all frames take together.
    [[nodiscard]] std::size_t queries() const {
        std::size_t n = 0;
        for (std::size_t turn = 0; turn < kQueryShares; ++turn) {
            for_queries(turn, [&n](const GridInstance&) { ++n; });
        }
        return n;
    }

    void judge(Row& row) override {
        std::size_t wrong = 0;
        double worst = 0.0;
        std::vector<double> ratios;
        for (const GridInstance& i : scene_.instances) {
            const double length = method_.ask(i);
            const double off = std::abs(length - i.length);
            if (length < 0.0 || (method_.length == PathLength::kBest && off > kLengthTolerance)) {
                ++wrong;
            }
            worst = std::max(worst, off);
            ratios.push_back(i.length > 0.0 ? length / i.length : 1.0);
        }
        row.error = static_cast<double>(wrong);
        row.error_unit = "wrong";
        row.metric("instances", static_cast<double>(scene_.instances.size()));
        if (method_.length == PathLength::kBest) {
            row.metric("worst_off_cells", worst);
        } else {
            row.metric("length_ratio_mean", mean(ratios));
            hold_to_exact(row);
        }
        row.metric("preprocess_s", method_.preprocess_s);
        row.metric("index_mib", method_.index_mib);
        time_each(row);
    }

  private:
    template <class Take>
    void for_queries(std::size_t turn, const Take& take) const {
        const std::size_t step = kQueryShares * (method_.slow ? kSlowShare : 1);
        for (std::size_t i = turn; i < scene_.instances.size(); i += step) {
            take(scene_.instances[i]);
        }
    }

    /// Some of the paths, to the shortest ones on the same mesh.
    void hold_to_exact(Row& row) {
        if (!method_.exact) {
            return;
        }
        std::vector<double> excess;
        const std::size_t step = scene_.instances.size() / kHeldToExact + 1;
        for (std::size_t i = 0; i < scene_.instances.size(); i += step) {
            const double best = method_.exact(scene_.instances[i]);
            const double length = method_.ask(scene_.instances[i]);
            if (best > 0.0 && length > 0.0) {
                excess.push_back(length / best - 1.0);
            }
        }
        row.metric("excess_mean", mean(excess));
        row.metric("excess_worst", largest(excess));
        if (method_.peer.empty()) {
            row.error = mean(excess);
            row.error_unit = "mean excess";
        }
    }

    /// GridQuery by query, on the wall.
    void time_each(Row& row) {
        std::vector<double> times;
        for (std::size_t turn = 0; turn < kQueryShares; ++turn) {
            for_queries(turn, [&](const GridInstance& i) {
                std::vector<double> tries;
                for (int n = 0; n < kTimesEach; ++n) {
                    const std::int64_t before = wall_ns();
                    sum_ += method_.ask(i);
                    tries.push_back(static_cast<double>(wall_ns() - before));
                }
                times.push_back(median(tries) * 1e-3);
            });
        }
        const double p99 = quantile(times, 0.99);
        row.time_us_p99 = p99;
        row.metric("p99_us", p99);
        row.metric("p99_over_mean", mean(times) > 0.0 ? p99 / mean(times) : 0.0);
    }

    const GridScene& scene_;
    const PathTrialMethod& method_;
    std::size_t turn_ = 0;
    double sum_ = 0.0;
};

template <class Work>
double seconds_of(const Work& work) {
    const std::int64_t before = thread_cpu_ns();
    work();
    return static_cast<double>(thread_cpu_ns() - before) * 1e-9;
}

PathTrialMethod planner_method(const std::string& name,
                               ai::pathfinding::GridMethod method,
                               const std::shared_ptr<GridPlanner>& planner,
                               bool slow) {
    PathTrialMethod m;
    m.name = name;
    m.slow = slow;
    m.ask = [planner, method](const GridInstance& i) {
        GridQuery q;
        q.start = i.start;
        q.goal = i.goal;
        const GridAnswer a = planner->plan(q, method);
        return a.outcome == PathOutcome::kFound ? a.length : -1.0;
    };
    return m;
}

Vec3 centre_on_mesh(ai::pathfinding::Cell c) {
    return {static_cast<float>(c.x) + 0.5F, 1.0F, static_cast<float>(c.y) + 0.5F};
}

constexpr float kMeshReach = 2.0F;

/// Our own search over Detour's polygons, with places, the corridor and corners found by us.
PathTrialMethod mesh_method(const std::shared_ptr<DetourMesh>& mesh, double baked_s) {
    PathTrialMethod m{"mesh", "", false, PathLength::kAny, {}, baked_s, 0.0, {}};
    m.ask = [mesh,
             search = std::make_shared<ai::pathfinding::NavmeshSearch>()](const GridInstance& i) {
        const auto a = search->plan(
            mesh->navmesh(), centre_on_mesh(i.start), centre_on_mesh(i.goal), kMeshReach);
        return a.outcome == PathOutcome::kFound ? static_cast<double>(a.length_m) : -1.0;
    };
    m.index_mib = static_cast<double>(mesh->navmesh().bytes()) / (1024.0 * 1024.0);
    return m;
}

/// The cells as waypoints, with an edge for each step; waypoints have the numbers of their places.
ai::pathfinding::WaypointGraph waypoints_of(const ai::pathfinding::GridMap& map) {
    using ai::pathfinding::Cell;
    std::vector<ai::pathfinding::Waypoint> nodes;
    std::vector<ai::pathfinding::WaypointEdge> edges;
    for (int y = 0; y < map.height(); ++y) {
        for (int x = 0; x < map.width(); ++x) {
            const auto at = [&](int dx, int dy) {
                return map.place(
                           Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)}) +
                       static_cast<ai::pathfinding::Place>(dx) +
                       static_cast<ai::pathfinding::Place>(dy) * map.stride();
            };
            if (!map.passable(at(0, 0))) {
                continue;
            }
            nodes.push_back(
                {at(0, 0), Vec3(static_cast<float>(x), 0.0F, static_cast<float>(y)), true});
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    if ((dx != 0 || dy != 0) && map.passable(at(dx, dy)) &&
                        map.passable(at(dx, 0)) && map.passable(at(0, dy))) {
                        edges.push_back({at(0, 0),
                                         at(dx, dy),
                                         dx != 0 && dy != 0 ? std::numbers::sqrt2_v<float> : 1.0F});
                    }
                }
            }
        }
    }
    return std::move(ai::pathfinding::WaypointGraph::build(nodes, edges)).value();
}

PathTrialMethod graph_method(const GridScene& scene) {
    struct Waypoints {
        ai::pathfinding::WaypointGraph graph;
        ai::pathfinding::WaypointSearch search;
    };

    PathTrialMethod m{"graph", "", true, PathLength::kBest, {}, 0.0, 0.0, {}};
    const auto w = std::make_shared<Waypoints>();
    m.preprocess_s = seconds_of([&] { w->graph = waypoints_of(scene.map); });
    m.ask = [w, &scene](const GridInstance& i) {
        const auto a = w->search.plan(w->graph,
                                      w->graph.number_of(scene.map.place(i.start)),
                                      w->graph.number_of(scene.map.place(i.goal)));
        return a.outcome == PathOutcome::kFound ? a.cost : -1.0;
    };
    m.index_mib = static_cast<double>(w->graph.bytes()) / (1024.0 * 1024.0);
    return m;
}

std::vector<PathTrialMethod> path_methods(const GridScene& scene) {
    using ai::pathfinding::GridMethod;
    constexpr double kMib = 1024.0 * 1024.0;
    const auto indexed = std::make_shared<GridPlanner>(scene.map);
    const double prepared_s = seconds_of([&indexed] { indexed->prepare(); });
    const auto bare = std::make_shared<GridPlanner>(scene.map);
    std::vector<PathTrialMethod> methods;
    methods.push_back(planner_method("default", GridMethod::kDefault, indexed, false));
    methods.back().preprocess_s = prepared_s;
    methods.back().index_mib = static_cast<double>(indexed->index_bytes()) / kMib;
    if (indexed->can(GridMethod::kSubgoals)) {
        methods.push_back(planner_method("subgoals", GridMethod::kSubgoals, indexed, false));
    }
    methods.push_back(planner_method("jump_points", GridMethod::kJumpPoints, bare, false));
    methods.push_back(planner_method("astar", GridMethod::kAStar, bare, true));
    methods.push_back(graph_method(scene));
    std::shared_ptr<DetourMesh> mesh;
    const double baked_s =
        scene.name == kNoMesh ? 0.0 : seconds_of([&] { mesh = DetourMesh::bake(scene.map); });
    if (mesh) {
        const auto exact = std::make_shared<MeshVisibility>(mesh->navmesh());
        const auto shortest = [mesh, exact](const GridInstance& i) {
            return exact->shortest(centre_on_mesh(i.start), centre_on_mesh(i.goal), kMeshReach);
        };
        methods.push_back(mesh_method(mesh, baked_s));
        methods.back().exact = shortest;
        PathTrialMethod m{"default", "detour", false, PathLength::kAny, {}, baked_s, 0.0, shortest};
        m.ask = [mesh](const GridInstance& i) {
            return mesh->find(i.start, i.goal);
        };
        m.index_mib = static_cast<double>(mesh->bytes()) / kMib;
        methods.push_back(std::move(m));
    }
    return methods;
}

/// From a frame to a query: the mean over all queries that were timed.
void per_query(Row& row, double queries) {
    for (auto& [name, value] : row.metrics) {
        if (name == "time_us_mean") {
            value = value * static_cast<double>(kQueryShares) / queries;
            row.time_us_p50 = value;
            row.time_us_p99 = *row.find_metric("p99_us");
        }
    }
    row.metric("queries_per_s", row.time_us_p50 > 0.0 ? 1e6 / row.time_us_p50 : 0.0);
}

void compare_with_detour(std::vector<Row>& rows) {
    const auto theirs =
        std::find_if(rows.begin(), rows.end(), [](const Row& row) { return row.peer == "detour"; });
    if (theirs == rows.end() || theirs->time_us_p50 <= 0.0) {
        return;
    }
    const double time = theirs->time_us_p50;
    for (Row& row : rows) {
        row.metric("queries_over_detour", row.time_us_p50 > 0.0 ? time / row.time_us_p50 : 0.0);
    }
}

void run_path_scene(Session& session, const GridScene& scene) {
    const std::vector<PathTrialMethod> all = path_methods(scene);
    if (all.back().peer.empty()) {
        session.note("navigation: no mesh by Recast of " + scene.name);
    }
    std::vector<Method> methods;
    std::vector<std::size_t> queries;
    for (const PathTrialMethod& m : all) {
        if (session.wants_method(m.name, m.peer)) {
            methods.push_back({m.name, m.peer, [&scene, &m] {
                                   return std::make_unique<PathTrial>(scene, m);
                               }});
            queries.push_back(PathTrial(scene, m).queries());
        }
    }
    if (methods.empty()) {
        return;
    }
    const Plan plan{0, static_cast<int>(kQueryShares), session.quick ? 1 : session.repeats};
    std::vector<Row> rows = compare("navigation", scene.name, "", methods, plan);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        per_query(rows[i], static_cast<double>(queries[i]));
    }
    compare_with_detour(rows);
    session.add(std::move(rows));
}

const std::vector<std::string>& path_scenes() {
    static const std::vector<std::string> names{
        "den520d", "brc202d", "AR0011SR", "den312d", "arena", "random512-10-0"};
    return names;
}

std::vector<std::string> all_path_scenes() {
    std::vector<std::string> names = path_scenes();
    names.push_back(kPatchedScene);
    return names;
}

void run_navigation(Session& session) {
    session.note(
        "navigation: all queries of each scenario, on one thread; time is the mean over them, per "
        "query, with its path put together; error is the number of wrong lengths (of mesh, "
        "our search over Detour's polygons, the mean excess over the "
        "shortest paths there, found by visibility, of 100 queries, as is excess_mean of detour, "
        "whose error counts queries without a path; graph: A* along a waypoint in each cell). "
        "goal_field: time of a field to a new goal; arena2_patched: an empty map that 439 patches "
        "build up and change between 2,000 "
        "queries. detour is Debian's, built for baseline x86-64");
    for (const std::string& name : path_scenes()) {
        if (!session.wants_scene(name)) {
            continue;
        }
        session.progress("navigation " + name);
        std::string why;
        const std::optional<GridScene> scene = read_grid_scene(name, session.quick ? 40 : 1, why);
        if (scene) {
            run_path_scene(session, *scene);
            run_flow_fields(session, *scene);
            run_doors(session, *scene);
        } else {
            session.note("navigation: " + why);
        }
    }
    if (session.wants_scene(kPatchedScene)) {
        session.progress("navigation " + kPatchedScene);
        run_patched_map(session);
    }
}

const Registration kNavigation({"navigation",
                                "paths on grids: time per query, lengths that are wrong",
                                all_path_scenes(),
                                {"default",
                                 "subgoals",
                                 "jump_points",
                                 "astar",
                                 "goal_field",
                                 "door",
                                 "mesh",
                                 "graph",
                                 "detour/default"},
                                run_navigation});

}  // namespace

}  // namespace zoned::bench
