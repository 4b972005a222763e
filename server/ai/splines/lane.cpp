#include "server/ai/splines/lane.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::splines {

namespace {

/// Points of a lane are so far apart at most, m, and at least.
constexpr double kWidestStep = 4.0;
constexpr double kClosestStep = 0.1;
/// Curvature is sampled this often between two stations.
constexpr int kLooks = 4;
/// Looks at the middle, for its least radius.
constexpr double kMiddleLook_m = 0.5;

/// The largest curvature of a line beside `middle`, 1/m.
double curvature_beside(const Spline& middle, double offset) {
    const auto looks =
        static_cast<std::size_t>(std::clamp(middle.length() / kMiddleLook_m, 16.0, 400'000.0));
    double most = 0.0;
    for (std::size_t i = 0; i <= looks; ++i) {
        const double s = middle.length() * static_cast<double>(i) / static_cast<double>(looks);
        most = std::max(most, std::abs(middle.beside(s, offset).curvature));
    }
    return most;
}

/// The step between points at which a Catmull-Rom curve through them is accurate enough. On a
/// circle of that curvature it is off by less than 0.024 h^4 k^3 (cubic Hermite pieces whose slopes
/// are central differences). Where curvature jumps it is off by h^2 k / 32. Both stay within a
/// tenth of the allowed error.
double step_for(double curvature, double error_m) {
    const double radius = 1.0 / std::max(curvature, 1e-6);
    return std::clamp(
        std::min(0.25 * radius, std::sqrt(3.2 * error_m * radius)), kClosestStep, kWidestStep);
}

}  // namespace

core::Result<Lane> Lane::make(const Spline& middle, double offset, double error_m) {
    const double step = step_for(curvature_beside(middle, offset), error_m);
    const auto pieces = static_cast<std::size_t>(std::clamp(
        std::ceil(middle.length() / step), 4.0, static_cast<double>(Spline::kMostPoints - 1)));
    SplineDef def;
    def.closed = middle.closed();
    // It has no width: bends too narrow for one were found in the spline.
    def.width_m = 1e-3F;
    for (std::size_t i = 0; i < pieces + (def.closed ? 0 : 1); ++i) {
        const double s = middle.length() * static_cast<double>(i) / static_cast<double>(pieces);
        def.points.push_back(middle.beside(s, offset).at.cast<float>());
    }
    core::Result<Spline> curve = Spline::make(def);
    if (!curve) {
        return core::Result<Lane>::failure(curve.error());
    }
    Lane lane(std::move(curve).value());
    lane.error_m_ = error_m;
    lane.survey(step);
    return lane;
}

void Lane::survey(double spacing_m) {
    const auto stations =
        static_cast<std::size_t>(std::max(4.0, std::ceil(length() / std::max(1.0, spacing_m))));
    station_m_ = length() / static_cast<double>(stations);
    SplinePoint before = at(0.0);
    for (std::size_t i = 0; i < stations; ++i) {
        place_.push_back(before.at);
        double most = std::abs(before.curvature);
        double turn = 0.0;
        for (int k = 1; k <= kLooks; ++k) {
            const SplinePoint p =
                at(station_m_ * (static_cast<double>(i) + static_cast<double>(k) / double{kLooks}));
            most = std::max(most, std::abs(p.curvature));
            const double cross = before.ahead.x() * p.ahead.y() - before.ahead.y() * p.ahead.x();
            turn += std::abs(elementary::atan2(cross, before.ahead.dot(p.ahead)));
            before = p;
        }
        curved_.push_back(static_cast<float>(most));
        turned_.push_back(static_cast<float>(turn));
    }
    if (!closed()) {
        place_.push_back(before.at);
    }
}

double Lane::most_curved() const {
    return static_cast<double>(*std::max_element(curved_.begin(), curved_.end()));
}

double Lane::on_lane(double s) const {
    return closed() ? s - length() * std::floor(s / length()) : std::clamp(s, 0.0, length());
}

double Lane::segment_m(double s, const SegmentLimits& limits) const {
    const double from = on_lane(s);
    const double most = std::min({limits.most_m, closed() ? 0.5 * length() : length() - from});
    const std::size_t stations = curved_.size();
    auto station = std::min(static_cast<std::size_t>(from / station_m_), stations - 1);
    // To the end of the station that it is in, then station by station.
    double ahead = station_m_ * static_cast<double>(station + 1) - from;
    double until = 0.0;
    double turn = 0.0;
    double curvature = 0.0;
    while (until < most) {
        curvature = std::max(curvature, static_cast<double>(curved_[station]));
        const double per_m = static_cast<double>(turned_[station]) / station_m_;
        const double to = std::min(most, until + ahead);
        const auto fits = [&](double way) {
            const double turned = turn + per_m * (way - until);
            return turned <= limits.turn &&
                   way * std::min(0.25 * turned, 0.125 * curvature * way) <= limits.off_m;
        };
        if (!fits(to)) {
            double low = until;
            double high = to;
            for (int halving = 0; halving < 12; ++halving) {
                const double middle = 0.5 * (low + high);
                (fits(middle) ? low : high) = middle;
            }
            until = low;
            break;
        }
        turn += per_m * (to - until);
        until = to;
        ahead = station_m_;
        station = station + 1 < stations ? station + 1 : 0;
    }
    return std::min(most, std::max(until, kLeast_m));
}

Lane::NearestOnLane Lane::refine(const Vec2d& here, double s, double step) const {
    NearestOnLane best{on_lane(s), (at(s).at - here).norm()};
    for (; step > 1e-3; step *= 0.5) {
        for (const double to : {best.s - step, best.s + step}) {
            const double distance = (at(to).at - here).norm();
            if (distance < best.distance_m) {
                best = {on_lane(to), distance};
                break;
            }
        }
    }
    return best;
}

std::size_t Lane::nearest_station(const Vec2d& here) const {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < place_.size(); ++i) {
        const double apart = (place_[i] - here).squaredNorm();
        if (apart < least) {
            least = apart;
            best = i;
        }
    }
    return best;
}

Lane::NearestOnLane Lane::nearest(const Vec2d& here) const {
    return refine(here, station_m_ * static_cast<double>(nearest_station(here)), station_m_);
}

Lane::NearestOnLane Lane::nearest_by_chords(const Vec2d& here) const {
    const std::size_t count = place_.size();
    const std::size_t station = nearest_station(here);
    NearestOnLane best;
    for (const std::size_t next : {station, station + 1}) {
        if (!closed() && (next == 0 || next == count)) {
            continue;
        }
        const Vec2d& from = place_[(next + count - 1) % count];
        const Vec2d chord = place_[next % count] - from;
        const double share = std::clamp((here - from).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
        const double apart = (from + share * chord - here).norm();
        if (apart < best.distance_m) {
            best = {on_lane(station_m_ * (static_cast<double>(next) - 1.0 + share)), apart};
        }
    }
    return best;
}

Lane::NearestOnLane Lane::nearest(const Vec2d& here, double about, double reach_m) const {
    double best = on_lane(about);
    double least = (at(best).at - here).squaredNorm();
    const int steps = static_cast<int>(std::ceil(reach_m / station_m_));
    for (int k = -steps; k <= steps; ++k) {
        const double s = on_lane(about + station_m_ * static_cast<double>(k));
        const auto station = std::min(static_cast<std::size_t>(std::lround(s / station_m_)) %
                                          (closed() ? place_.size() : ~std::size_t{0}),
                                      place_.size() - 1);
        const double apart = (place_[station] - here).squaredNorm();
        if (apart < least) {
            least = apart;
            best = station_m_ * static_cast<double>(station);
        }
    }
    return refine(here, best, station_m_);
}

std::size_t Lane::bytes() const {
    return curve_.bytes() + place_.capacity() * sizeof(Vec2d) +
           (curved_.capacity() + turned_.capacity()) * sizeof(float);
}

}  // namespace zoned::ai::splines
