#include "server/ai/splines/spline.h"

#include "server/ai/splines/lane_change.h"
#include "server/ai/splines/racing_line.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace zoned::ai::splines {

namespace {

using testing::HasSubstr;

SplineDef winding(Curve curve, bool closed) {
    SplineDef def;
    def.curve = curve;
    def.closed = closed;
    def.points = {{0, 0}, {10, 2}, {14, 9}, {8, 15}, {9, 25}, {-3, 28}, {-8, 16}, {-9, 5}};
    def.width_m = 1.0F;
    return def;
}

SplineDef ring(float radius, int points) {
    SplineDef def;
    def.closed = true;
    for (int i = 0; i < points; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / points;
        def.points.push_back({radius * static_cast<float>(std::cos(angle)),
                              radius * static_cast<float>(std::sin(angle))});
    }
    return def;
}

/// Chords between `count` places evenly spaced by distance: a polygon whose sides are shorter than
/// their arcs by curvature^2 h^2 / 24.
double polygon(const Spline& track, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        const double h = track.length() / count;
        sum += (track.at(h * (i + 1)).at - track.at(h * i).at).norm();
    }
    return sum;
}

TEST(Spline, GoesThroughItsPointsOrAsItsKindDoes) {
    const Spline through = Spline::make(winding(Curve::kCatmullRom, false)).value();
    EXPECT_NEAR((through.at(0.0).at - Vec2d(0, 0)).norm(), 0.0, 1e-9);
    EXPECT_NEAR((through.at(1e9).at - Vec2d(-9, 5)).norm(), 0.0, 1e-9);
    double nearest = 1e9;
    for (double s = 0.0; s < through.length(); s += 0.001) {
        nearest = std::min(nearest, (through.at(s).at - Vec2d(8, 15)).norm());
    }
    EXPECT_LT(nearest, 0.001);
    // By hand, from the basis: at a point with even neighbours (p0 + 4 p1 + p2) / 6.
    SplineDef def;
    def.curve = Curve::kBSpline;
    def.closed = true;
    def.points = {{0, 0}, {6, 0}, {6, 6}, {0, 6}};
    const Spline near = Spline::make(def).value();
    EXPECT_NEAR((near.at(0.0).at - Vec2d(1, 1)).norm(), 0.0, 1e-9);
}

/// Romberg's method: polygons of n and 2n sides give an error of fourth order in h. This length
/// shares nothing with Gauss' rule.
TEST(Spline, IsFollowedByDistanceWithTheErrorItStates) {
    for (const Curve curve : {Curve::kCatmullRom, Curve::kBSpline}) {
        for (const bool closed : {false, true}) {
            const Spline track = Spline::make(winding(curve, closed)).value();
            const double coarse = polygon(track, 20'000);
            const double fine = polygon(track, 40'000);
            EXPECT_NEAR(fine + (fine - coarse) / 3.0, track.length(), 1e-5 * track.length());
            const double h = 1e-3;
            for (int i = 1; i < 5000; ++i) {
                const double s = track.length() * i / 5000.0 + 0.0005;
                // Chords of 2 mm are shorter than arcs by 1.7e-7 at a radius of 1 m.
                const double speed = (track.at(s + h).at - track.at(s - h).at).norm() / (2.0 * h);
                if (s + h < track.length()) {
                    ASSERT_NEAR(speed, 1.0, 1e-5) << "at " << s;
                }
            }
        }
    }
}

TEST(Spline, BendsAsACircleDoes) {
    // 64 points on a circle: cubic pieces differ from it by (2 pi / 64)^4 / 384 or so.
    const Spline circle = Spline::make(ring(10.0F, 64)).value();
    EXPECT_NEAR(circle.length(), 20.0 * std::numbers::pi, 1e-2);
    for (int i = 0; i < 500; ++i) {
        const SplinePoint p = circle.at(0.37 * i);
        ASSERT_NEAR(p.at.norm(), 10.0, 1e-3);
        ASSERT_NEAR(p.ahead.norm(), 1.0, 1e-12);
        ASSERT_NEAR(p.curvature, 0.1, 6e-3);
        // x to z is to the right: the middle of the circle is there.
        ASSERT_NEAR(circle.beside(0.37 * i, 2.0).at.norm(), 8.0, 1e-2);
    }
}

TEST(Spline, LanesAreAsLongAsTheyAre) {
    SplineDef def = ring(10.0F, 64);
    def.width_m = 6.0F;
    def.lanes = 3;
    const Spline track = Spline::make(def).value();
    EXPECT_DOUBLE_EQ(track.offset_of(0), -2.0);
    EXPECT_DOUBLE_EQ(track.offset_of(1), 0.0);
    EXPECT_DOUBLE_EQ(track.offset_of(2), 2.0);
    // A round in the lane at 12, 10 and 8 m from the middle.
    for (std::uint32_t lane = 0; lane < 3; ++lane) {
        const double offset = track.offset_of(lane);
        const double round = 2.0 * std::numbers::pi * (10.0 - offset);
        EXPECT_NEAR(track.walked(0.0, offset, round), track.length(), 2e-3 * track.length());
        // At an even speed on the ground: steps of 0.1 m are 0.1 m.
        double s = 0.0;
        for (int i = 0; i < 200; ++i) {
            const double next = track.walked(s, offset, 0.1);
            const double step = (track.beside(next, offset).at - track.beside(s, offset).at).norm();
            ASSERT_NEAR(step, 0.1, 1e-3);
            s = next;
        }
    }
}

TEST(Spline, IsRefusedWithThePointAndTheReason) {
    SplineDef def = winding(Curve::kCatmullRom, false);
    def.points.resize(1);
    EXPECT_THAT(Spline::make(def).error(), HasSubstr("from 2 to 100000 points, not 1"));
    def = winding(Curve::kCatmullRom, true);
    def.points[3].x() = NAN;
    EXPECT_THAT(Spline::make(def).error(), HasSubstr("point 3 is not finite"));
    def = winding(Curve::kCatmullRom, true);
    def.points.push_back(def.points.front());
    EXPECT_THAT(Spline::make(def).error(), HasSubstr("point 8 and the next one are less"));
    def = winding(Curve::kCatmullRom, true);
    def.width_m = 40.0F;
    EXPECT_THAT(Spline::make(def).error(), HasSubstr("bends with a radius below half its width"));
    def.width_m = 1.0F;
    def.lanes = 0;
    EXPECT_THAT(Spline::make(def).error(), HasSubstr("from 1 to 100 lanes"));
}

TEST(RacingLine, TakesTheInnerRimOfARing) {
    // Second differences at an even angle h are r h^2: least where r is.
    SplineDef def = ring(20.0F, 64);
    def.width_m = 4.0F;
    const Spline track = Spline::make(def).value();
    const RacingLine line = racing_line(track, 128, 0.5);
    for (const double o : line.offset) {
        EXPECT_NEAR(o, 1.5, 1e-3) << "to the middle, which is right";
    }
}

/// A long oval: the optimum cuts bends and swings out before them. Whether it is one is seen from
/// the conditions of Karush, Kuhn and Tucker.
TEST(RacingLine, IsTheLeastBentLineWithinTheWidth) {
    SplineDef def;
    def.closed = true;
    def.width_m = 8.0F;
    def.points = {{0, 0},
                  {40, 0},
                  {80, 0},
                  {100, 10},
                  {110, 30},
                  {100, 50},
                  {80, 60},
                  {40, 60},
                  {0, 60},
                  {-20, 50},
                  {-30, 30},
                  {-20, 10}};
    const Spline track = Spline::make(def).value();
    const std::size_t n = 256;
    const RacingLine line = racing_line(track, n, 1.0, 3000);
    const RacingLine middle{std::vector<double>(n, 0.0), 0.0};
    std::vector<Vec2d> place;
    std::vector<Vec2d> right;
    double before = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const SplinePoint p = track.at(track.length() * static_cast<double>(i) / n);
        right.push_back({-p.ahead.y(), p.ahead.x()});
        place.push_back(p.at + line.offset[i] * right.back());
        ASSERT_LE(std::abs(line.offset[i]), 3.0 + 1e-12);
    }
    const auto second = [&](std::size_t i) {
        return Vec2d(place[(i + n - 1) % n] - 2.0 * place[i] + place[(i + 1) % n]);
    };
    for (std::size_t i = 0; i < n; ++i) {
        const double h = track.length() / static_cast<double>(n);
        before += (track.at(h * (static_cast<double>(i) - 1.0)).at -
                   2.0 * track.at(h * static_cast<double>(i)).at +
                   track.at(h * (static_cast<double>(i) + 1.0)).at)
                      .squaredNorm();
    }
    EXPECT_LT(line.bend, 0.8 * before);
    const double scale = std::sqrt(line.bend / n);
    for (std::size_t i = 0; i < n; ++i) {
        const double slope =
            (second((i + n - 1) % n) - 2.0 * second(i) + second((i + 1) % n)).dot(right[i]);
        if (line.offset[i] > 3.0 - 1e-9) {
            EXPECT_LT(slope, 0.02 * scale) << i;
        } else if (line.offset[i] < -3.0 + 1e-9) {
            EXPECT_GT(slope, -0.02 * scale) << i;
        } else {
            EXPECT_NEAR(slope, 0.0, 0.02 * scale) << i;
        }
    }
    const auto along = track_along(track, line);
    ASSERT_TRUE(along) << along.error();
    EXPECT_LT(along->length(), track.length());
}

TEST(LaneChange, JumpsNeitherInPlaceNorInVelocity) {
    // Of a curve whose curvature jumps, velocities in a lane jump where it does.
    SplineDef left = winding(Curve::kBSpline, false);
    SplineDef shifted = left;
    for (Vec2& p : shifted.points) {
        p += Vec2(2.0F, 1.0F);
    }
    const Spline a = Spline::make(left).value();
    const Spline b = Spline::make(shifted).value();
    const LaneChange change({&a, 5.0, 0.0}, {&b, 5.0, 0.25}, 12.0);
    EXPECT_NEAR((change.at(0.0).at - a.at(5.0).at).norm(), 0.0, 1e-12);
    EXPECT_NEAR((change.at(0.0).velocity - a.at(5.0).ahead).norm(), 0.0, 1e-12);
    const double end = change.distance_on_target(12.0);
    EXPECT_NEAR((change.at(12.0).at - b.beside(end, 0.25).at).norm(), 0.0, 1e-9);
    EXPECT_NEAR((change.at(12.0).velocity - b.at(end).ahead).norm(), 0.0, 1e-9);
    EXPECT_FALSE(change.done(11.9));
    EXPECT_TRUE(change.done(12.0));
    double most_gap = 0.0;
    double most_off = 0.0;
    for (double walked = 0.01; walked < 12.0; walked += 0.01) {
        const auto here = change.at(walked);
        const Vec2d moved = (change.at(walked + 1e-4).at - change.at(walked - 1e-4).at) / 2e-4;
        // The velocity is that of the places.
        ASSERT_NEAR((moved - here.velocity).norm(), 0.0, 2e-3);
        most_gap = std::max(
            most_gap,
            (b.beside(change.distance_on_target(walked), 0.25).at - a.at(5.0 + walked).at).norm());
        most_off = std::max(most_off, std::abs(here.velocity.norm() - 1.0));
    }
    // 15/8 of the gap over the length, plus the difference of directions: unit vectors that are
    // mixed are shorter by at most 1 - cos(angle / 2), here below 0.05.
    EXPECT_LT(most_off, 15.0 / 8.0 * most_gap / 12.0 + 0.05);
}

}  // namespace

}  // namespace zoned::ai::splines
