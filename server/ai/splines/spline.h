// Spline: a smooth curve over the ground that agents follow by distance, with lanes beside it.
#pragma once

#include "shared/core/result.h"
#include "shared/math/types.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::splines {

using Vec2d = Eigen::Vector2d;

enum class Curve : std::uint8_t {
    kCatmullRom,  ///< through all points; its curvature jumps there; centripetal: no loops
    kBSpline,     ///< near all points, uniform and cubic; its curvature does not jump
};

/// SplineDef: a spline as written in the configuration. Lanes are numbered from the left.
struct SplineDef {
    std::vector<Vec2> points;  ///< x, z, m
    Curve curve = Curve::kCatmullRom;
    bool closed = false;
    float width_m = 1.0F;  ///< of all lanes together
    std::uint32_t lanes = 1;
};

/// SplinePoint: the place at a distance along the spline.
struct SplinePoint {
    Vec2d at = Vec2d::Zero();     ///< m
    Vec2d ahead = Vec2d::Zero();  ///< unit length
    double curvature = 0.0;       ///< 1/m, > 0 to the right
};

/// Cubic pieces with a table of their lengths. Both kinds continue beyond the ends of an open
/// spline by reflection of the second point. Source for Catmull-Rom: Yuksel, Schaefer and Keyser,
/// "Parameterization and applications of Catmull-Rom curves", Computer-Aided Design 43, 2011, alpha
/// = 1/2.
/// The place at a distance is off by less than 1e-6 of a piece between two points, and the speed
/// along it by less than 1e-5. The length of an eighth of a piece is integrated by Gauss and
/// Legendre's rule of five points and inverted by Newton's method.
class Spline {
  public:
    static constexpr std::size_t kMostPoints = 100'000;
    static constexpr float kFarthest = 1e5F;  ///< of a point from the origin, m

    /// Errors name the point. Causes: too few points (2, closed 3) or too many; a point not finite
    /// or too far; the same point twice in a row; width or lanes out of range; a bend narrower than
    /// half the width, in which lanes would run backwards. `at`, if given, gets the named point, or
    /// nothing where there is none.
    static core::Result<Spline> make(const SplineDef& def,
                                     std::optional<std::size_t>* at = nullptr);

    /// m.
    [[nodiscard]] double length() const { return until_.back(); }

    [[nodiscard]] bool closed() const { return closed_; }

    [[nodiscard]] float width() const { return width_; }

    [[nodiscard]] std::uint32_t lanes() const { return lanes_; }

    /// The place on the middle, `s` m from the start. `s` is taken modulo the length of a closed
    /// spline; on an open one it is clamped to the ends.
    [[nodiscard]] SplinePoint at(double s) const;

    /// As above, `offset` m to the right.
    [[nodiscard]] SplinePoint beside(double s, double offset) const;

    /// The offset of the middle of a lane, m to the right of the middle of the spline.
    [[nodiscard]] double offset_of(std::uint32_t lane) const {
        return static_cast<double>(width_) *
               ((static_cast<double>(lane) + 0.5) / static_cast<double>(lanes_) - 0.5);
    }

    /// The position along the spline after a walk of `distance` m from `s` in a lane `offset` m to
    /// the right. It is less far along in a bend's outer lane than in its inner one. The midpoint
    /// rule takes steps of at most an eighth of a metre: off by less than 1e-3 of the distance for
    /// bends down to 2 m.
    [[nodiscard]] double walked(double s, double offset, double distance) const;

    [[nodiscard]] std::size_t bytes() const {
        return pieces_.capacity() * sizeof(Cubic) + until_.capacity() * sizeof(double);
    }

  private:
    /// a + b u + c u^2 + d u^3, 0 <= u <= 1.
    struct Cubic {
        Vec2d a, b, c, d;

        [[nodiscard]] Vec2d at(double u) const { return a + u * (b + u * (c + u * d)); }

        [[nodiscard]] Vec2d slope(double u) const { return b + u * (2.0 * c + u * (3.0 * d)); }

        [[nodiscard]] Vec2d bend(double u) const { return 2.0 * c + u * (6.0 * d); }
    };

    Spline() = default;

    void add_piece(const Vec2d (&p)[4], Curve curve);
    void measure();
    [[nodiscard]] static double length_of(const Cubic& piece, double from, double to);
    [[nodiscard]] static double curvature_of(const Cubic& piece, double u);
    [[nodiscard]] std::optional<std::size_t> narrow_bend() const;

    std::vector<Cubic> pieces_;
    std::vector<double> until_;  // length from the start to the end of each eighth of a piece
    bool closed_ = false;
    float width_ = 1.0F;
    std::uint32_t lanes_ = 1;
};

}  // namespace zoned::ai::splines
