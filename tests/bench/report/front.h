// Fronts: how far a row is from the best that any row of its figure reaches.
#pragma once

#include "tests/bench/results.h"

#include <string>
#include <vector>

namespace zoned::bench {

/// Whose method a row times.
enum class Role {
    kDefault,  ///< a user gets it without asking
    kOwn,      ///< another method of ours
    kPeer,
};

Role role_of(const Row& row);

/// "peer/method", or the method alone where it is ours.
std::string method_name(const Row& row);

struct FigurePoint {
    const Row* row = nullptr;
    double error = 0.0;    ///< absolute, finite
    double time_us = 0.0;  ///< > 0
    double along = 0.0;    ///< passes, steps or publications a second; 0 where the figure has none
    /// The time over the least time of a point with no larger error: 1 on the front. 0 where the
    /// point stands aside.
    double factor = 0.0;
    std::string aside;  ///< why the point is not compared; empty: it is
};

/// The rows of one scene that solve the same task with errors of one unit.
struct Figure {
    std::string suite;
    std::string scene;      ///< of the rows
    std::string run_scene;  ///< as `--scene` takes it
    std::string parameter;  ///< without what varies along curves
    std::string error_unit;
    std::string time_label;
    std::string along_label;  ///< empty: points, no curves
    std::vector<const Row*> rows;
    std::vector<FigurePoint> points;  ///< rows with a time and a finite error

    [[nodiscard]] std::string heading() const;
};

/// Figures in the order of their first rows; they point into `results`. A row with the metric
/// `passes`, `steps_per_s` or `updates_per_s` is a point of a curve. Times are CPU time of the
/// calling thread, or by the wall in suites whose work goes to other threads and devices.
std::vector<Figure> figures_of(const Results& results);

/// A time this much above the front counts as being on it: smaller differences are noise of a run.
inline constexpr double kFrontTolerance = 1.05;

/// The non-dominated points in order of rising error, each faster than those before (the Pareto
/// front, as work-precision diagrams show it: Hairer, Norsett, Wanner, "Solving Ordinary
/// Differential Equations I", section II.10).
std::vector<const FigurePoint*> front_of(const Figure& figure);

/// Where our default, all our methods and the peers stand in one figure.
struct Standing {
    const Figure* figure = nullptr;
    double default_factor = 0.0;  ///< the least over its points; 0: no such point
    double own_factor = 0.0;      ///< the least over all points of ours, the default's among them
    double peer_factor = 0.0;
    std::string beaten_by;  ///< the fastest method with no larger error than the default's point
};

inline bool on_front(double factor) {
    return factor > 0.0 && factor <= kFrontTolerance;
}

/// Figures with a point of our default and a method beside it, in their order.
std::vector<Standing> standings_of(const std::vector<Figure>& figures);

/// Counts over standings.
struct FrontCounts {
    int scenes = 0;
    int default_on_front = 0;
    int own_on_front = 0;
};

/// Over the figures with a peer, or over all.
FrontCounts count_fronts(const std::vector<Standing>& standings, bool with_peer_only);

}  // namespace zoned::bench
