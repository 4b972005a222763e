#include "server/ai/splines/spline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace zoned::ai::splines {

namespace {

constexpr std::size_t kParts = 8;  ///< of a piece, in the table of lengths
constexpr double kPart = 1.0 / static_cast<double>(kParts);
constexpr int kNewtonSteps = 4;
constexpr double kNear_m = 1e-6;     ///< of Newton's method: the step after it is none
constexpr double kWalkStep = 0.125;  ///< m

/// Abscissae and weights of the rule of five points on [-1, 1] (Abramowitz and Stegun, 25.4.30).
constexpr std::array<double, 5> kGaussAt{-0.906179845938663992797627,
                                         -0.538469310105683091036314,
                                         0.0,
                                         0.538469310105683091036314,
                                         0.906179845938663992797627};
constexpr std::array<double, 5> kGaussWeight{0.236926885056189087514264,
                                             0.478628670499366468041292,
                                             0.568888888888888888888889,
                                             0.478628670499366468041292,
                                             0.236926885056189087514264};

std::string fault_of(const SplineDef& def, std::optional<std::size_t>& at) {
    const std::size_t least = def.closed ? 3 : 2;
    if (def.points.size() < least || def.points.size() > Spline::kMostPoints) {
        return "a track has from " + std::to_string(least) + " to " +
               std::to_string(Spline::kMostPoints) + " points, not " +
               std::to_string(def.points.size());
    }
    if (!(def.width_m > 0.0F && def.width_m <= 1000.0F) || def.lanes < 1 || def.lanes > 100) {
        return "a track is wider than 0 m, up to 1000 m, and has from 1 to 100 lanes";
    }
    for (std::size_t i = 0; i < def.points.size(); ++i) {
        const Vec2& p = def.points[i];
        at = i;
        if (!(std::abs(p.x()) <= Spline::kFarthest && std::abs(p.y()) <= Spline::kFarthest)) {
            return "point " + std::to_string(i) + " is not finite or more than 100 km away";
        }
        const bool last = i + 1 == def.points.size();
        if ((!last || def.closed) && (def.points[last ? 0 : i + 1] - p).norm() < 1e-3F) {
            return "point " + std::to_string(i) + " and the next one are less than 1 mm apart";
        }
    }
    at.reset();
    return {};
}

}  // namespace

core::Result<Spline> Spline::make(const SplineDef& def, std::optional<std::size_t>* at) {
    using Made = core::Result<Spline>;
    std::optional<std::size_t> unasked;
    std::optional<std::size_t>& wrong = at != nullptr ? *at : unasked;
    wrong.reset();
    if (const std::string fault = fault_of(def, wrong); !fault.empty()) {
        return Made::failure(fault);
    }
    Spline track;
    track.closed_ = def.closed;
    track.width_ = def.width_m;
    track.lanes_ = def.lanes;
    const auto n = static_cast<std::int64_t>(def.points.size());
    const auto point = [&](std::int64_t i) -> Vec2d {
        if (def.closed) {
            return def.points[static_cast<std::size_t>((i + n) % n)].cast<double>();
        }
        const auto inner = [&](std::int64_t k) -> Vec2d {
            return def.points[static_cast<std::size_t>(k)].cast<double>();
        };
        return i < 0    ? Vec2d(2.0 * inner(0) - inner(1))
               : i >= n ? Vec2d(2.0 * inner(n - 1) - inner(n - 2))
                        : inner(i);
    };
    for (std::int64_t i = 0; i + (def.closed ? 0 : 1) < n; ++i) {
        track.add_piece({point(i - 1), point(i), point(i + 1), point(i + 2)}, def.curve);
    }
    track.measure();
    wrong = track.narrow_bend();
    if (wrong) {
        return Made::failure("behind point " + std::to_string(*wrong) +
                             " the track bends with a radius below half its width");
    }
    return track;
}

void Spline::add_piece(const Vec2d (&p)[4], Curve curve) {
    if (curve == Curve::kBSpline) {
        pieces_.push_back({(p[0] + 4.0 * p[1] + p[2]) / 6.0,
                           (p[2] - p[0]) / 2.0,
                           (p[0] - 2.0 * p[1] + p[2]) / 2.0,
                           (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]) / 6.0});
        return;
    }
    // Knots are the square roots of distances apart.
    const double t01 = std::sqrt((p[1] - p[0]).norm());
    const double t12 = std::sqrt((p[2] - p[1]).norm());
    const double t23 = std::sqrt((p[3] - p[2]).norm());
    const Vec2d along = p[2] - p[1];
    const Vec2d m1 = along + t12 * ((p[1] - p[0]) / t01 - (p[2] - p[0]) / (t01 + t12));
    const Vec2d m2 = along + t12 * ((p[3] - p[2]) / t23 - (p[3] - p[1]) / (t12 + t23));
    pieces_.push_back({p[1], m1, 3.0 * along - 2.0 * m1 - m2, m1 + m2 - 2.0 * along});
}

double Spline::length_of(const Cubic& piece, double from, double to) {
    const double half = 0.5 * (to - from);
    const double middle = 0.5 * (to + from);
    double sum = 0.0;
    for (std::size_t i = 0; i < kGaussAt.size(); ++i) {
        sum += kGaussWeight[i] * piece.slope(middle + half * kGaussAt[i]).norm();
    }
    return half * sum;
}

double Spline::curvature_of(const Cubic& piece, double u) {
    const Vec2d slope = piece.slope(u);
    const Vec2d bend = piece.bend(u);
    const double speed = slope.norm();
    return speed > 0.0 ? (slope.x() * bend.y() - slope.y() * bend.x()) / (speed * speed * speed)
                       : 0.0;
}

void Spline::measure() {
    double sum = 0.0;
    for (const Cubic& piece : pieces_) {
        for (std::size_t part = 0; part < kParts; ++part) {
            const double from = kPart * static_cast<double>(part);
            sum += length_of(piece, from, from + kPart);
            until_.push_back(sum);
        }
    }
}

/// The point behind which it is.
std::optional<std::size_t> Spline::narrow_bend() const {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        for (std::size_t k = 0; k <= 2 * kParts; ++k) {
            const double u = 0.5 * kPart * static_cast<double>(k);
            if (std::abs(curvature_of(pieces_[i], u)) * 0.5 * static_cast<double>(width_) >= 1.0) {
                return i;
            }
        }
    }
    return std::nullopt;
}

SplinePoint Spline::at(double s) const {
    const double whole = length();
    const double wrapped = closed_ ? s - whole * std::floor(s / whole) : std::clamp(s, 0.0, whole);
    const auto found = std::lower_bound(until_.begin(), until_.end(), wrapped);
    const auto part = static_cast<std::size_t>(std::min(found, until_.end() - 1) - until_.begin());
    const double begin = part > 0 ? until_[part - 1] : 0.0;
    const double share = (wrapped - begin) / (until_[part] - begin);
    const Cubic& piece = pieces_[part / kParts];
    const double from = kPart * static_cast<double>(part % kParts);
    double u = from + kPart * std::clamp(share, 0.0, 1.0);
    for (int i = 0; i < kNewtonSteps; ++i) {
        const double off = length_of(piece, from, u) - (wrapped - begin);
        const double speed = piece.slope(u).norm();
        u = speed > 0.0 ? std::clamp(u - off / speed, from, from + kPart) : u;
        if (std::abs(off) < kNear_m) {
            break;  // the next step would be its square
        }
    }
    const Vec2d slope = piece.slope(u);
    const double speed = slope.norm();
    return {
        piece.at(u), speed > 0.0 ? Vec2d(slope / speed) : Vec2d(1.0, 0.0), curvature_of(piece, u)};
}

SplinePoint Spline::beside(double s, double offset) const {
    SplinePoint p = at(s);
    p.at += offset * Vec2d(-p.ahead.y(), p.ahead.x());
    p.curvature /= 1.0 - offset * p.curvature;
    return p;
}

double Spline::walked(double s, double offset, double distance) const {
    if (offset == 0.0) {
        return s + distance;
    }
    // Whole steps and the rest, so that the place does not jump as the distance grows.
    for (double left = distance; std::abs(left) > 0.0;) {
        const double step = std::clamp(left, -kWalkStep, kWalkStep);
        const double half = 0.5 * step / (1.0 - offset * at(s).curvature);
        s += step / (1.0 - offset * at(s + half).curvature);
        left -= step;
    }
    return s;
}

}  // namespace zoned::ai::splines
