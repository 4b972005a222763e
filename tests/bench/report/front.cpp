#include "tests/bench/report/front.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

namespace zoned::bench {

namespace {

/// The axes for rows with a certain metric: time and that metric.
struct CurveKind {
    const char* metric;
    const char* along_label;
    const char* time_label;
    bool times_metric;  ///< time_us_p50 is the time of one of these units
};

/// The kind of curve that a row is a point of, or null.
const CurveKind* curve_of(const Row& row) {
    static constexpr std::array<CurveKind, 3> kKinds{{
        {"passes", "passes", "microseconds of a solve", false},
        {"steps_per_s", "steps of a second", "microseconds of a simulated second", true},
        {"updates_per_s", "publications a second", "microseconds of a tick", false},
    }};
    const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&row](const CurveKind& kind) {
        return row.find_metric(kind.metric) != nullptr;
    });
    return found == kKinds.end() ? nullptr : found;
}

/// The first word of a curve's parameter varies along the curve.
std::string fixed_parameter(const Row& row) {
    if (curve_of(row) == nullptr) {
        return row.parameter;
    }
    const std::size_t blank = row.parameter.find(' ');
    return blank == std::string::npos ? "" : row.parameter.substr(blank + 1);
}

/// Rows that do less than their scene asks, or leave their work to others.
struct Aside {
    const char* suite;
    const char* method;
    const char* why;
};

constexpr std::array<Aside, 5> kAsides{{
    {"physics", "threads_2", "a second thread does part of the work"},
    {"navigation", "goal_field", "prepares a field for many agents, not one path"},
    {"navigation", "door", "times the change of a map"},
    {"scripting", "lua_empty", "its script does nothing"},
    {"store", "off", "stores nothing"},
}};

std::string why_aside(const Row& row) {
    const auto* const found =
        std::find_if(kAsides.begin(), kAsides.end(), [&row](const Aside& aside) {
            return row.peer.empty() && row.suite == aside.suite && row.method == aside.method;
        });
    return found == kAsides.end() ? "" : found->why;
}

/// Suites in which methods hand their work to threads of a pool or to a device: the caller's CPU
/// time would miss it.
bool timed_by_wall(const Row& row) {
    constexpr std::array<const char*, 3> kSuites{"crowd", "kernels", "particles"};
    return std::find(kSuites.begin(), kSuites.end(), row.suite) != kSuites.end() &&
           row.find_metric("wall_us_p50") != nullptr;
}

/// A frame of several items: metrics hold the time of a frame, time_us_p50 may be that of an item.
double wall_time(const Row& row) {
    const double* const wall = row.find_metric("wall_us_p50");
    const double* const mean = row.find_metric("time_us_mean");
    const double items =
        mean != nullptr && row.time_us_p50 > 0.0 ? std::round(*mean / row.time_us_p50) : 1.0;
    return *wall / (items >= 10.0 ? items : 1.0);
}

void place_points(Figure& figure) {
    for (const Row* row : figure.rows) {
        const CurveKind* const curve = curve_of(*row);
        const double along = curve == nullptr ? 0.0 : *row->find_metric(curve->metric);
        double time = timed_by_wall(*row) ? wall_time(*row) : row->time_us_p50;
        time *= curve != nullptr && curve->times_metric ? along : 1.0;
        if (std::isfinite(time) && time > 0.0 && std::isfinite(row->error)) {
            figure.points.push_back({row, std::abs(row->error), time, along, 0.0, why_aside(*row)});
        }
    }
    for (FigurePoint& point : figure.points) {
        double least = point.time_us;
        for (const FigurePoint& other : figure.points) {
            if (other.aside.empty() && other.error <= point.error) {
                least = std::min(least, other.time_us);
            }
        }
        point.factor = point.aside.empty() ? point.time_us / least : 0.0;
    }
}

/// The scene as `--scene` takes it of each row.
std::vector<std::string> run_scenes(const Results& results) {
    std::vector<std::string> scenes;
    for (const SceneRun& run : results.runs) {
        scenes.insert(scenes.end(), run.rows, run.scene);
    }
    scenes.resize(results.rows.size());
    return scenes;
}

double least_factor(double a, double b) {
    return a == 0.0 || b == 0.0 ? std::max(a, b) : std::min(a, b);
}

}  // namespace

Role role_of(const Row& row) {
    if (!row.peer.empty()) {
        return Role::kPeer;
    }
    return row.method == "default" ? Role::kDefault : Role::kOwn;
}

std::string method_name(const Row& row) {
    return row.peer.empty() ? row.method : row.peer + "/" + row.method;
}

std::string Figure::heading() const {
    return suite + ": " + scene + (parameter.empty() ? "" : ", " + parameter);
}

std::vector<Figure> figures_of(const Results& results) {
    std::vector<Figure> figures;
    const std::vector<std::string> scenes = run_scenes(results);
    for (std::size_t i = 0; i < results.rows.size(); ++i) {
        const Row& row = results.rows[i];
        const CurveKind* const curve = curve_of(row);
        const std::string parameter = fixed_parameter(row);
        const std::string along = curve == nullptr ? "" : curve->along_label;
        auto at = std::find_if(figures.begin(), figures.end(), [&](const Figure& f) {
            return std::tie(f.suite, f.scene, f.parameter, f.error_unit, f.along_label) ==
                   std::tie(row.suite, row.scene, parameter, row.error_unit, along);
        });
        if (at == figures.end()) {
            Figure figure;
            figure.suite = row.suite;
            figure.scene = row.scene;
            figure.run_scene = scenes[i].empty() ? row.scene : scenes[i];
            figure.parameter = parameter;
            figure.error_unit = row.error_unit;
            figure.along_label = along;
            figure.time_label = curve != nullptr     ? curve->time_label
                                : timed_by_wall(row) ? "microseconds of a frame, by the wall"
                                                     : "microseconds of a frame, CPU time";
            at = figures.insert(figures.end(), figure);
        }
        at->rows.push_back(&row);
    }
    std::for_each(figures.begin(), figures.end(), place_points);
    return figures;
}

std::vector<const FigurePoint*> front_of(const Figure& figure) {
    std::vector<const FigurePoint*> points;
    for (const FigurePoint& point : figure.points) {
        if (point.aside.empty()) {
            points.push_back(&point);
        }
    }
    std::stable_sort(points.begin(), points.end(), [](const FigurePoint* a, const FigurePoint* b) {
        return std::tie(a->error, a->time_us) < std::tie(b->error, b->time_us);
    });
    std::vector<const FigurePoint*> front;
    for (const FigurePoint* point : points) {
        if (front.empty() || point->time_us < front.back()->time_us) {
            front.push_back(point);
        }
    }
    return front;
}

std::vector<Standing> standings_of(const std::vector<Figure>& figures) {
    std::vector<Standing> standings;
    for (const Figure& figure : figures) {
        Standing standing{&figure, 0.0, 0.0, 0.0, ""};
        const FigurePoint* ours = nullptr;
        std::set<std::string> methods;
        for (const FigurePoint& point : figure.points) {
            if (!point.aside.empty()) {
                continue;
            }
            methods.insert(method_name(*point.row));
            const Role role = role_of(*point.row);
            double& own = role == Role::kPeer ? standing.peer_factor : standing.own_factor;
            own = least_factor(own, point.factor);
            if (role == Role::kDefault && (ours == nullptr || point.factor < ours->factor)) {
                ours = &point;
            }
        }
        if (ours == nullptr || methods.size() < 2 || figure.error_unit.empty()) {
            continue;
        }
        standing.default_factor = ours->factor;
        for (const FigurePoint* point : front_of(figure)) {
            if (point->error <= ours->error && point->row != ours->row) {
                standing.beaten_by = method_name(*point->row);  // the last one is the fastest
            }
        }
        standings.push_back(standing);
    }
    return standings;
}

FrontCounts count_fronts(const std::vector<Standing>& standings, bool with_peer_only) {
    FrontCounts counts;
    for (const Standing& standing : standings) {
        if (with_peer_only && standing.peer_factor == 0.0) {
            continue;
        }
        ++counts.scenes;
        counts.default_on_front += on_front(standing.default_factor) ? 1 : 0;
        counts.own_on_front += on_front(standing.own_factor) ? 1 : 0;
    }
    return counts;
}

}  // namespace zoned::bench
